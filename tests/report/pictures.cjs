// The pictures of the documentation, taken from a page of evidence.
//
//   node pictures.cjs REPORT.html FOLDER [WHOLE]
//
// and into WHOLE, to be looked at, the whole page in pieces: light, dark on a small window, without scripts.
// Debian's chromium, headless, driven by playwright-core (found through NODE_PATH). Run by hand when the page looks otherwise.
"use strict";
const fs = require("fs");
const path = require("path");
const { chromium } = require("playwright-core");

const PICTURES = [
  ["summary", "section#summary"],
  ["maps", "section#identification figure.chart:has(figcaption:text-is('EXC'))"],
  ["residual", "section#closure figure.chart:has(figcaption:text-is('Residual over temperature'))"],
  ["part", "section#piece figure.part"],
];

const [file, folder, whole] = process.argv.slice(2).map((argument) => path.resolve(argument));

/// The whole page as it looks, in pieces: of a picture as high as the page Chromium draws 8192 pixels and repeats them.
async function picture(browser, folder, name, options) {
  const page = await (await browser.newContext(options)).newPage();
  await page.goto(`file://${file}`);
  const { width } = options.viewport;
  const most = 3600;
  await page.setViewportSize({ width, height: most });
  const end = await page.evaluate(() => document.documentElement.scrollHeight);
  for (let from = 0, piece = 1; from < end; from += most, ++piece) {
    await page.evaluate((y) => scrollTo(0, y), from);
    await page.waitForTimeout(300);
    await page.screenshot({ path: path.join(folder, `${name}_${piece}.png`) });
  }
  await page.context().close();
}

(async () => {
  fs.mkdirSync(folder, { recursive: true });
  const browser = await chromium.launch({
    executablePath: process.env.TRUNNION_CHROMIUM || "/usr/bin/chromium",
    args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
  });
  const page = await (await browser.newContext({ viewport: { width: 1000, height: 900 } })).newPage();
  await page.goto(`file://${file}`);
  for (const [name, selector] of PICTURES) {
    const place = page.locator(selector).first();
    await place.scrollIntoViewIfNeeded();
    await page.waitForTimeout(500);
    await place.screenshot({ path: path.join(folder, `${name}.png`) });
  }
  if (whole) {
    fs.mkdirSync(whole, { recursive: true });
    const large = { width: 1280, height: 900 };
    await picture(browser, whole, "light", { viewport: large, colorScheme: "light" });
    await picture(browser, whole, "without_scripts", { viewport: large, javaScriptEnabled: false });
    await picture(browser, whole, "small_dark", { viewport: { width: 390, height: 844 }, colorScheme: "dark" });
  }
  await browser.close();
})();
