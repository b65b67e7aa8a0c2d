// usage: node report_test.js REPORT_FOLDER [SCREENSHOT_FOLDER]
// Opens a report from disk and uses it: no error, words, map, sorting, filter, slider.
import assert from 'node:assert/strict';
import { mkdirSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { openPage, shareOfPixels, startBrowser } from './browser.js';

const [folder, pictures] = process.argv.slice(2).map((path) => resolve(path));
const browser = await startBrowser();
const { page, problems } = await openPage(browser, { viewport: { width: 1360, height: 900 } });
const keep = async (name, options) => {
  if (!pictures) return;
  mkdirSync(pictures, { recursive: true });
  await page.screenshot({ path: join(pictures, `${name}.png`), ...options });
};

await page.goto(pathToFileURL(join(folder, 'index.html')).href);
await page.waitForSelector('#table tbody tr');
const images = await page.evaluate(() => window.cpplusReport.images);
const placed = images.filter((image) => image.status === 'refined').length;

const title = await page.textContent('h1');
assert.ok(title.startsWith(`${placed} of ${images.length} photo`), title);
await keep('report', { fullPage: true });

// The map shows the photos in the colours of their expected shift.
const map = await page.locator('#map-chart').screenshot();
const colored = await shareOfPixels(page, map, (r, g, b) => Math.max(r, g, b) - Math.min(r, g, b) > 60);
assert.ok(colored > 0.0003, `coloured share of the map: ${colored}`);

// Worst first, then sorted by a click on a head, both ways.
const column = (index) => page.$$eval(`#table tbody tr`, (rows, i) => rows.map((row) => row.cells[i].textContent), index);
const numbers = async (index) => (await column(index)).filter((text) => text !== '–').map(Number);
const heads = await page.$$eval('#table th', (cells) => cells.map((cell) => cell.dataset.column));
await page.click('th[data-column=after] button');
const falling = await numbers(heads.indexOf('after'));
assert.deepEqual(falling, [...falling].sort((a, b) => b - a));
await page.click('th[data-column=after] button');
const rising = await numbers(heads.indexOf('after'));
assert.deepEqual(rising, [...rising].sort((a, b) => a - b));
assert.ok(rising.length > 1 && new Set(rising).size > 1, 'residuals differ');

// A filter by name leaves that photo alone.
await page.fill('#table-controls input[type=search]', images[1].name);
assert.deepEqual(await column(heads.indexOf('name')), [images[1].name]);
await page.fill('#table-controls input[type=search]', '');
await page.uncheck('#table-controls label:has-text("placed (") input');
assert.equal(await page.locator('#table tbody tr').count(), Math.min(50, images.length - placed));
await page.check('#table-controls label:has-text("placed (") input');

// The slider uncovers the picture with the refined pose.
await page.click(`#table tbody tr:has(img)`);
await page.waitForFunction(() => [...document.querySelectorAll('.compare img')].every((image) => image.complete && image.naturalWidth > 0));
const redShare = async (at) => {
  await page.locator('.compare input').fill(String(at));
  const shot = await page.locator('.compare').screenshot();
  return shareOfPixels(page, shot, (r, g, b) => r > 150 && g < 110 && b < 110);
};
const red = [await redShare(0), await redShare(50), await redShare(100)];
await redShare(50);
await keep('detail');
assert.ok(red[0] < red[1] && red[1] < red[2], `red lines uncovered by the slider: ${red}`);
const first = await page.textContent('dialog h2');
await page.keyboard.press('Escape');
assert.ok(first.length > 0);

await page.emulateMedia({ colorScheme: 'dark' });
await keep('report_dark', { fullPage: true });
assert.deepEqual(problems, []);
await browser.close();
console.log(`report: ${images.length} photos, all well`);
