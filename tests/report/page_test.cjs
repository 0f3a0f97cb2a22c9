// The page of evidence in a real browser.
//
//   node page_test.cjs REPORT.html FOLDER
//
// and its print on A4 into FOLDER; pictures.cjs makes what is to be looked at.
// Debian's chromium, headless, driven by playwright-core (found through NODE_PATH). Exit status 77 where one of the two is
// missing, 1 and a line for each finding otherwise.
"use strict";
const fs = require("fs");
const path = require("path");

const CHROMIUM = process.env.TRUNNION_CHROMIUM || "/usr/bin/chromium";
const SOFTWARE_GL = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
const SLOW_MS = 120000;  // a page of many charts drawn by software, on a machine that builds beside it
const SECTIONS = ["summary", "identification", "interpolation", "closure", "compensation", "program", "piece", "data"];
const MOST_BYTES = 3e6;

const findings = [];
const check = (holds, what) => {
  if (!holds) findings.push(what);
};

let chromium;
try {
  ({ chromium } = require("playwright-core"));
} catch {
  console.log("playwright-core is not installed");
  process.exit(77);
}
if (!fs.existsSync(CHROMIUM)) {
  console.log(`${CHROMIUM} is not there`);
  process.exit(77);
}

const [file, pictures] = process.argv.slice(2).map((argument) => path.resolve(argument));
fs.mkdirSync(pictures, { recursive: true });

/// A page that records what it says, what it asks for, and where its errors are.
async function opened(browser, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(SLOW_MS);
  page.on("console", (message) => check(message.type() !== "error", `console: ${message.text()}`));
  page.on("pageerror", (error) => findings.push(`script: ${error.message}`));
  page.on("request", (request) =>
    check(/^(file|data|blob):/.test(request.url()), `a request leaves the file: ${request.url()}`));
  await page.goto(`file://${file}`);
  return page;
}

/// Into the window at once; playwright's own way waits for frames, which a busy machine does not draw.
const bring = (locator) => locator.evaluate((element) => element.scrollIntoView({ block: "center" }));

/// What an element shows.
async function shown(locator) {
  await bring(locator);
  return (await locator.page().screenshot({ clip: await locator.boundingBox() })).toString("base64");
}

async function checkText(page) {
  const text = fs.readFileSync(file, "utf8");
  check(text.length < MOST_BYTES, `${text.length} bytes, fewer than ${MOST_BYTES} are wanted`);
  const outside = text.match(/\b(?:src|href)\s*=\s*["']?(?!#|data:|["'])[^\s"'>]+/g) || [];
  // In the bundle `src=` and `href=` are assignments of a script; what counts is the markup.
  const markup = text.replace(/<script[\s\S]*?<\/script>/g, "").match(/\b(?:src|href)\s*=\s*["']?(?!#|data:|["'])[^\s"'>]+/g) || [];
  check(markup.length === 0, `outside addresses: ${markup.slice(0, 3)}`);
  check(!outside.some((found) => /(?:https?:)?\/\//.test(found)), `outside addresses: ${outside.slice(0, 3)}`);
  for (const id of SECTIONS)
    check((await page.locator(`section#${id} h2`).count()) === 1, `section ${id} is missing`);
  check(!/\bnan\b|\binf\b|undefined/i.test(await page.locator("main").innerText()), "a number is missing: nan, inf or undefined");
}

/// A roundness plot says of a cut what the table beside it says.
async function checkRoundness(page) {
  const rows = await page.locator("section#piece table").first().locator("tbody tr").evaluateAll((list) =>
    list.map((row) => [...row.cells].map((cell) => cell.textContent.replace(/\u00a0/g, " ").replace("\u2212", "-"))));
  const plots = page.locator("section#piece figure.picture", { hasText: "Roundness at h" });
  let compared = 0;
  for (const plot of await plots.all()) {
    const height = (await plot.locator("figcaption").textContent()).replace(/\u00a0/g, " ").match(/h = (.*)/)[1];
    for (const [, cut, lsc] of (await plot.locator("svg").textContent()).matchAll(/(\w+): LSC ([\d.]+) µm/g)) {
      const row = rows.find((cells) => cells[0] === cut && cells[1] === height);
      check(row && Math.abs(parseFloat(row[2]) - lsc) < 0.006, `${cut} at ${height}: LSC ${lsc} µm drawn, the table has ${row?.[2]}`);
      ++compared;
    }
  }
  check(compared >= 9, `${compared} roundness values compared`);
}

/// Every axis has a unit, every picture a name for the screen reader.
async function checkLabels(page) {
  const charts = await page.locator("figure.chart > script").allTextContents();
  check(charts.length > 15, `${charts.length} charts`);
  for (const text of charts) {
    const chart = JSON.parse(text);
    for (const label of [chart.x_label, chart.y_label]) check(/, \S+/.test(label), `"${chart.title}": no unit in "${label}"`);
  }
  const unnamed = await page.evaluate(() =>
    [...document.querySelectorAll("svg:not([aria-hidden]), canvas[role], select, input, [role=application]")]
      .filter((e) => !e.closest("[aria-hidden]") &&
        !(e.getAttribute("aria-label") || e.querySelector("title") || e.labels?.length)).map((e) => e.outerHTML.slice(0, 80)));
  check(unnamed.length === 0, `no name for a screen reader: ${unnamed}`);
  const headings = await page.locator("h1,h2,h3").evaluateAll((list) => list.map((h) => Number(h.tagName[1])));
  check(headings[0] === 1 && headings.every((h, i) => i === 0 || h - headings[i - 1] <= 1), "a level of headings is skipped");
}

async function checkCharts(page) {
  const chart = page.locator("section#identification figure.chart").first();
  const live = chart.locator(".live");
  await bring(chart);
  check((await live.locator("canvas").count()) > 0, "the charts are not alive");
  // The values under the pointer are those of the result.
  const told = JSON.parse(await chart.locator("script").textContent());
  const over = await live.locator(".u-over").boundingBox();
  await page.mouse.move(over.x + over.width - 2, over.y + over.height / 2);
  const legend = await live.locator(".u-legend").innerText();
  const std = told.series[0].half_width.at(-1) / 2, decimals = 1 - Math.floor(Math.log10(std));
  const value = `${told.series[0].values.at(-1).toFixed(decimals).replace("-", "−")} ± ${std.toFixed(decimals)}`;
  check(legend.includes(value), `the pointer at the right end reads ${value} ${told.y_unit}: ${legend.replace(/\s+/g, " ")}`);
  // The lines stand in the legend as they are drawn.
  const samples = await live.locator(".u-legend svg path").evaluateAll((list) => list.map((path) => getComputedStyle(path).strokeDasharray));
  check(samples.length === told.series.length && new Set(samples).size === samples.length,
    `the legend does not tell the lines apart without colours: ${samples}`);
  // The same from the keyboard.
  await live.focus();
  await page.keyboard.press("Home");
  const first = await chart.locator(".reading").innerText();
  await page.keyboard.press("ArrowRight");
  const second = await chart.locator(".reading").innerText();
  check(first !== "" && first !== second, `the arrow keys do not read the chart: "${first}", "${second}"`);
}

async function checkPart(page) {
  const part = page.locator("figure.part").first();
  const canvas = part.locator("canvas");
  const before = await shown(canvas);
  const box = await canvas.boundingBox();
  await page.mouse.move(box.x + box.width / 4, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 4 + 90, box.y + box.height / 2 + 20, { steps: 4 });
  await page.mouse.up();
  await page.waitForTimeout(100);
  const turned = await shown(canvas);
  check(before !== turned, "the part does not turn with the mouse");
  await canvas.focus();
  await page.keyboard.press("ArrowLeft");
  check((await shown(canvas)) !== turned, "the part does not turn with the keys");
  const slider = part.locator("input[type=range]");
  const magnified = await part.locator("output").innerText();
  const small = await shown(canvas);
  await slider.focus();
  for (let k = 0; k < 40; ++k) await page.keyboard.press("ArrowRight");
  check((await part.locator("output").innerText()) !== magnified, "the slider does not tell its magnification");
  check((await shown(canvas)) !== small, "the slider does not magnify");
  await slider.fill("50");
  const one = await shown(canvas);
  await part.locator("select.right").selectOption({ index: 0 });
  check((await shown(canvas)) !== one, "the choice of the right part changes nothing");
  await part.locator("select.right").selectOption({ index: 2 });
  // From the lid down over the flank, wherever the turning has left it.
  const now = await canvas.boundingBox();
  let reading = "";
  for (let down = 0.6; down < 0.95 && reading === ""; down += 0.05) {
    await page.mouse.move(now.x + now.width / 4, now.y + now.height * down);
    reading = await part.locator(".reading").innerText();
  }
  check(/µm at phi \d+°/.test(reading), `the part does not tell the value under the pointer: "${reading}"`);
}

async function checkStill(browser) {
  const page = await opened(browser, { javaScriptEnabled: false });
  for (const id of SECTIONS) check(await page.locator(`section#${id} h2`).isVisible(), `without scripts: no section ${id}`);
  check(await page.locator("figure.chart .still svg").first().isVisible(), "without scripts: no still chart");
  check(await page.locator("figure.picture svg").first().isVisible(), "without scripts: no still picture");
  check(!(await page.locator(".controls").first().isVisible()), "without scripts: controls that do nothing");
  await page.context().close();
}

async function checkSmall(browser) {
  const page = await opened(browser, { viewport: { width: 390, height: 844 }, colorScheme: "dark" });
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
  check(wide <= 0, `on a small window the page is ${wide} pixels too wide`);
  // What a wide table is called stays in sight, however far the table is scrolled.
  const cut = await page.evaluate(() => [...document.querySelectorAll(".scroll")].flatMap((place) => {
    const caption = place.querySelector("caption");
    return [0, place.scrollWidth].flatMap((left) => {
      place.scrollLeft = left;
      const box = caption.getBoundingClientRect(), frame = place.getBoundingClientRect();
      return box.left < frame.left - 1 || box.right > frame.right + 1 ? [`${caption.textContent} (${box.left} … ${box.right})`] : [];
    });
  }));
  check(cut.length === 0, `on a small window captions are cut: ${cut.slice(0, 3)}`);
  await page.context().close();
}

async function main() {
  const browser = await chromium.launch({ executablePath: CHROMIUM, args: ["--no-sandbox", ...SOFTWARE_GL] });
  const page = await opened(browser, { colorScheme: "light" });
  await checkText(page);
  await checkLabels(page);
  await checkRoundness(page);
  await checkCharts(page);
  await checkPart(page);
  const paper = async () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const light = await paper();
  await page.locator("#theme").click();
  check(light !== (await paper()), "the button does not change between light and dark");
  await page.emulateMedia({ media: "print" });
  check((await paper()) === "rgb(255, 255, 255)", "the page is not printed on white");
  const pdf = await page.pdf({ format: "A4", path: path.join(pictures, "print.pdf"), preferCSSPageSize: true });
  check(pdf.length > 20000, "nothing is printed");
  const sheets = [...pdf.toString("latin1").matchAll(/\/MediaBox\s*\[\s*0\s+0\s+([\d.]+)\s+([\d.]+)\s*\]/g)];
  check(sheets.length > 0 && sheets.every(([, w, h]) => Math.abs(w - 595.3) < 1.5 && Math.abs(h - 841.9) < 1.5),
    `sheets of the print are not A4: ${sheets.map((sheet) => sheet[0]).slice(0, 3)}`);
  await page.context().close();
  const dark = await opened(browser, { colorScheme: "dark" });
  // The pictures that `predict` draws follow the page: no white sheets, letters in the page's ink, lines in its palette.
  const colours = await dark.locator("figure.picture svg").first().evaluate((svg) => {
    const of = (selector, property) => getComputedStyle(svg.querySelector(selector))[property];
    svg.style.color = "var(--s0)";
    const first = getComputedStyle(svg).color;
    svg.style.color = "";
    return { paper: of(".paper", "fill"), text: of("text", "fill"), line: of(".line.s0", "stroke"), first, ink: getComputedStyle(document.body).color };
  });
  check(colours.paper === "none", `dark: a picture lies on ${colours.paper}`);
  check(colours.text === colours.ink, `dark: a picture's letters are ${colours.text}, the page's ${colours.ink}`);
  check(colours.line === colours.first, `dark: a picture's first line is ${colours.line}`);
  await dark.context().close();
  await checkStill(browser);
  await checkSmall(browser);
  await browser.close();

  const bare = await chromium.launch({ executablePath: CHROMIUM, args: ["--no-sandbox", "--disable-gpu", "--disable-3d-apis"] });
  const flat = await opened(bare);
  check((await flat.locator("figure.part canvas").count()) === 0, "a part in three dimensions without WebGL");
  check(await flat.locator("figure.picture svg").first().isVisible(), "without WebGL: no still picture");
  check(/WebGL/.test(await flat.locator("figure.part").first().innerText()), "without WebGL: not said");
  await bare.close();

  console.log(findings.length ? findings.join("\n") : "the page does what it should");
  process.exit(findings.length ? 1 : 0);
}

main().catch((error) => {
  console.log(findings.join("\n"));
  console.log(error);
  process.exit(1);
});
