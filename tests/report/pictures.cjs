// The pictures of the documentation, taken from a page of evidence.
//
//   node pictures.cjs REPORT.html FOLDER
//
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

(async () => {
  const [file, folder] = process.argv.slice(2).map((argument) => path.resolve(argument));
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
  await browser.close();
})();
