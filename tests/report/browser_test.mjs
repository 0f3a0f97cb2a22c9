// browser_test.mjs PAGE CHROMIUM: what a visitor does with the page.
import assert from 'node:assert/strict';
import { chromium } from 'playwright-core';

const [address, executablePath] = [`file://${process.argv[2]}`, process.argv[3]];
const withGl = ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];

async function opened(browser, options, script = true) {
  const context = await browser.newContext({ javaScriptEnabled: script, ...options });
  const page = await context.newPage(), wrong = [];
  page.on('console', message => { if (message.type() === 'error') wrong.push(message.text()); });
  page.on('pageerror', error => wrong.push(error.message));
  page.on('request', request => { if (!/^(file|data|blob):/.test(request.url())) wrong.push(request.url()); });
  await page.goto(address);
  return { page, wrong };
}

const browser = await chromium.launch({ executablePath, args: withGl });
for (const options of [{ colorScheme: 'light' }, { colorScheme: 'dark' }, { viewport: { width: 400, height: 800 } }]) {
  const { page, wrong } = await opened(browser, options);
  for (const section of ['summary', 'identification', 'closure', 'compensation', 'correction', 'piece'])
    assert.ok(await page.locator(`#${section}`).isVisible(), section);
  assert.ok(await page.locator('.uplot').count() > 15);
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), 'the page is wider than its window');
  // Values under the pointer, and by keys.
  const chart = page.locator('.chart').first();
  const value = () => chart.locator('.u-legend .u-value').nth(1).textContent();
  const before = await value();
  await chart.locator('.u-over').hover();
  assert.notEqual(await value(), before);
  await chart.focus();
  await page.keyboard.press('ArrowRight');
  assert.match(await value(), /\d/);
  // The part turns by pointer and key, and swells by the slider.
  const canvas = page.locator('figure.part canvas'), picture = () => canvas.evaluate(c => c.toDataURL());
  await canvas.scrollIntoViewIfNeeded();
  let last = await picture();
  const moved = async what => {
    const now = await picture();
    assert.notEqual(now, last, what);
    last = now;
  };
  const box = await canvas.boundingBox();
  await page.mouse.move(box.x + box.width / 4, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 3, box.y + box.height / 2, { steps: 5 });
  await page.mouse.up();
  await moved('the pointer');
  await canvas.focus();
  await page.keyboard.press('ArrowLeft');
  await moved('a key');
  await page.locator('figure.part input[type=range]').fill('4');
  await moved('the slider');
  assert.equal(await page.locator('figure.part output').textContent(), '10000 x');
  assert.deepEqual(wrong, []);
}
{
  const { page, wrong } = await opened(browser, {}, false);
  assert.ok(await page.locator('.chart svg').count() > 15, 'still pictures without scripts');
  assert.match(await page.locator('#identification').textContent(), /EAA/);
  assert.deepEqual(wrong, []);
}
await browser.close();
{
  const blind = await chromium.launch({ executablePath, args: ['--no-sandbox', '--disable-gpu', '--disable-3d-apis'] });
  const { page, wrong } = await opened(blind, {});
  assert.equal(await page.locator('figure.part canvas').count(), 0);
  assert.ok(await page.locator('figure.part svg').isVisible(), 'a still picture without WebGL');
  assert.deepEqual(wrong, []);
  await blind.close();
}
console.log('the page holds');
