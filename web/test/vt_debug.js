// usage: node view_test.js CPPLUS RESULT_FOLDER [SCREENSHOT_FOLDER]
// Serves a viewer and uses it: the cloud is drawn in colour, a click on a camera shows its photo over the cloud, the
// switch moves it, a distance is measured. Only this machine is served.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { mkdirSync, writeFileSync } from 'node:fs';
import { request } from 'node:http';
import { join, resolve } from 'node:path';
import { openPage, shareOfPixels, startBrowser } from './browser.js';

const [program, folder, pictures] = process.argv.slice(2).map((path) => resolve(path));
const browser = await startBrowser();
const server = spawn(program, ['view', folder, '--port', '0'], { stdio: ['ignore', 'pipe', 'inherit'] });
const stopped = new Promise((done) => { server.on('exit', done); });

function statusFor(address, host) {
  const { hostname, port } = new URL(address);
  return new Promise((done, fail) => {
    request({ hostname, port, path: '/', headers: { Host: host } }, (response) => { response.resume(); done(response.statusCode); })
      .on('error', fail).end();
  });
}

try {
  const address = await new Promise((done, fail) => {
    server.stdout.on('data', (text) => done(String(text).trim()));
    server.on('exit', (code) => fail(new Error(`cpplus view ended with ${code}`)));
  });
  assert.match(address, /^http:\/\/127\.0\.0\.1:\d+\/$/);
  console.log('1', process.uptime().toFixed(1), 'assert.match(address, /^http:\\/\\/127\\.0\\.0\\.1:\\d+\\/$/);');
  assert.equal(await statusFor(address, '127.0.0.1'), 200);
  console.log('2', process.uptime().toFixed(1), "assert.equal(await statusFor(address, '127.0.0.1'), 200);");
  assert.equal(await statusFor(address, 'example.org'), 403);
  console.log('3', process.uptime().toFixed(1), "assert.equal(await statusFor(address, 'example.org'), 403);");

  const { page, problems } = await openPage(browser, { viewport: { width: 1000, height: 700 } });
  console.log('4', process.uptime().toFixed(1), 'const { page, problems } = await openPage(browser, { viewport: { width');
  page.setDefaultTimeout(240000);
  // What the canvas shows, drawn and read at once: a software renderer may take too long for a screenshot of the page.
  const shot = async (name) => {
    const data = await page.evaluate(() => {
      const { renderer, scene, camera } = window.cpplusViewer.stage;
      renderer.render(scene, camera);
      return renderer.domElement.toDataURL('image/png').split(',')[1];
    });
    const png = Buffer.from(data, 'base64');
    if (pictures) {
      mkdirSync(pictures, { recursive: true });
      writeFileSync(join(pictures, `${name}.png`), png);
    }
    return png;
  };
  // Waits for the tiles, not for a time.
  const settled = () => page.waitForFunction(() => {
    const { cloud, stage } = window.cpplusViewer ?? {};
    if (!cloud) return false;
    stage.invalidate();
    window.quietLooks = cloud.isLoading || cloud.numDrawn === 0 ? 0 : (window.quietLooks ?? 0) + 1;
    return window.quietLooks > 8;
  }, null, { polling: 100 });
  // A click that does not wait for frames, of which a software renderer may need many seconds each.
  const press = (selector) => page.locator(selector).evaluate((button) => button.click());
  const background = (r, g, b) => Math.abs(r - 0xe9) + Math.abs(g - 0xec) + Math.abs(b - 0xef) < 9;
  const drawnShare = async (png) => 1 - (await shareOfPixels(page, png, background));

  await page.goto(address);
  console.log('5', process.uptime().toFixed(1), 'await page.goto(address);');
  await page.waitForFunction(() => window.cpplusViewer);
  console.log('6', process.uptime().toFixed(1), 'await page.waitForFunction(() => window.cpplusViewer);');
  await page.evaluate(() => { window.cpplusViewer.cloud.detail = 7; });  // fewer points: there may be no graphics card
  await settled();
  console.log('7', process.uptime().toFixed(1), 'await settled();');
  const overview = await shot('view');
  console.log('8', process.uptime().toFixed(1), "const overview = await shot('view');");
  assert.ok((await page.evaluate(() => window.cpplusViewer.cloud.numDrawn)) > 1000);
  console.log('9', process.uptime().toFixed(1), 'assert.ok((await page.evaluate(() => window.cpplusViewer.cloud.numDraw');
  assert.ok((await drawnShare(overview)) > 0.1, `share of the overview that is drawn: ${await drawnShare(overview)}`);
  console.log('10', process.uptime().toFixed(1), 'assert.ok((await drawnShare(overview)) > 0.1, `share of the overview t');
  const colored = await shareOfPixels(page, overview, (r, g, b) => Math.max(r, g, b) - Math.min(r, g, b) > 25);
  console.log('11', process.uptime().toFixed(1), 'const colored = await shareOfPixels(page, overview, (r, g, b) => Math.');
  assert.ok(colored > 0.005, `coloured share of the overview: ${colored}`);
  console.log('12', process.uptime().toFixed(1), 'assert.ok(colored > 0.005, `coloured share of the overview: ${colored}');

  // A click on a camera.
  const index = await page.evaluate(() => {
    const { cameras } = window.cpplusViewer;
    const inside = ([x, y]) => x > 280 && x < innerWidth - 20 && y > 20 && y < innerHeight - 60;
    return window.cpplusView.images.findIndex((image, i) => inside(cameras.screenPlace(i))
      && cameras.pick(...cameras.screenPlace(i)) === i && image.status === 'refined');
  });
  assert.ok(index >= 0, 'a camera can be clicked');
  console.log('13', process.uptime().toFixed(1), "assert.ok(index >= 0, 'a camera can be clicked');");
  await page.mouse.click(...(await page.evaluate((i) => window.cpplusViewer.cameras.screenPlace(i), index)));
  console.log('14', process.uptime().toFixed(1), 'await page.mouse.click(...(await page.evaluate((i) => window.cpplusVie');
  await page.waitForFunction(() => window.cpplusViewer.photo.ready);
  console.log('15', process.uptime().toFixed(1), 'await page.waitForFunction(() => window.cpplusViewer.photo.ready);');
  assert.equal(await page.evaluate(() => window.cpplusViewer.photo.index), index);
  console.log('16', process.uptime().toFixed(1), 'assert.equal(await page.evaluate(() => window.cpplusViewer.photo.index');
  await settled();
  console.log('17', process.uptime().toFixed(1), 'await settled();');
  await page.locator('#photo-bar input[type=range]').fill('0');
  console.log('18', process.uptime().toFixed(1), "await page.locator('#photo-bar input[type=range]').fill('0');");
  const cloudOnly = await shot('photo_0');
  console.log('19', process.uptime().toFixed(1), "const cloudOnly = await shot('photo_0');");
  await page.locator('#photo-bar input[type=range]').fill('1');
  console.log('20', process.uptime().toFixed(1), "await page.locator('#photo-bar input[type=range]').fill('1');");
  const photoOnly = await shot('photo_1');
  console.log('21', process.uptime().toFixed(1), "const photoOnly = await shot('photo_1');");
  await page.locator('#photo-bar input[type=range]').fill('0.5');
  console.log('22', process.uptime().toFixed(1), "await page.locator('#photo-bar input[type=range]').fill('0.5');");
  await shot('photo_half');
  console.log('23', process.uptime().toFixed(1), "await shot('photo_half');");
  assert.ok((await drawnShare(photoOnly)) > 0.5, 'the photo fills the view');
  console.log('24', process.uptime().toFixed(1), "assert.ok((await drawnShare(photoOnly)) > 0.5, 'the photo fills the vi");
  assert.notDeepEqual(cloudOnly, photoOnly);
  console.log('25', process.uptime().toFixed(1), 'assert.notDeepEqual(cloudOnly, photoOnly);');

  // The coloured cloud looks as the photo does: colours of a coarse grid differ little, and less than with the view of
  // another photo.
  const difference = (a, b) => page.evaluate(async ([first, second]) => {
    const grid = async (data) => {
      const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${data}`)).blob());
      const canvas = new OffscreenCanvas(24, 16);
      const context = canvas.getContext('2d');
      context.imageSmoothingQuality = 'high';
      context.drawImage(image, 150, 60, image.width - 300, image.height - 120, 0, 0, 24, 16);
      return context.getImageData(0, 0, 24, 16).data;
    };
    const [x, y] = [await grid(first), await grid(second)];
    return x.reduce((sum, value, i) => sum + Math.abs(value - y[i]), 0) / x.length;
  }, [a.toString('base64'), b.toString('base64')]);
  await page.evaluate(() => window.cpplusViewer.photo.step(3));
  console.log('26', process.uptime().toFixed(1), 'await page.evaluate(() => window.cpplusViewer.photo.step(3));');
  await page.waitForFunction(() => window.cpplusViewer.photo.ready);
  console.log('27', process.uptime().toFixed(1), 'await page.waitForFunction(() => window.cpplusViewer.photo.ready);');
  await page.locator('#photo-bar input[type=range]').fill('1');
  console.log('28', process.uptime().toFixed(1), "await page.locator('#photo-bar input[type=range]').fill('1');");
  const otherPhoto = await shot('photo_other');
  console.log('29', process.uptime().toFixed(1), "const otherPhoto = await shot('photo_other');");
  const [same, other] = [await difference(cloudOnly, photoOnly), await difference(cloudOnly, otherPhoto)];
  assert.ok(same < 0.7 * other, `cloud against its photo ${same}, against another ${other}`);
  console.log('30', process.uptime().toFixed(1), 'assert.ok(same < 0.7 * other, `cloud against its photo ${same}, agains');

  // A drag looks around; shown anew, the photo is looked at straight again.
  const direction = () => page.evaluate(() => window.cpplusViewer.stage.camera.quaternion.toArray());
  const straight = await direction();
  console.log('31', process.uptime().toFixed(1), 'const straight = await direction();');
  await page.mouse.move(600, 300);
  console.log('32', process.uptime().toFixed(1), 'await page.mouse.move(600, 300);');
  await page.mouse.down();
  console.log('33', process.uptime().toFixed(1), 'await page.mouse.down();');
  await page.mouse.move(480, 340);
  console.log('34', process.uptime().toFixed(1), 'await page.mouse.move(480, 340);');
  await page.mouse.up();
  console.log('35', process.uptime().toFixed(1), 'await page.mouse.up();');
  const turned = await direction();
  console.log('36', process.uptime().toFixed(1), 'const turned = await direction();');
  const angle = 2 * Math.acos(Math.min(1, Math.abs(straight.reduce((sum, value, i) => sum + value * turned[i], 0))));
  assert.ok(angle > 0.02 && angle < 0.6, `turned by ${angle} rad`);
  console.log('37', process.uptime().toFixed(1), 'assert.ok(angle > 0.02 && angle < 0.6, `turned by ${angle} rad`);');
  assert.ok(await page.evaluate(() => window.cpplusViewer.photo.shown), 'a drag does not leave the photo');
  console.log('38', process.uptime().toFixed(1), 'assert.ok(await page.evaluate(() => window.cpplusViewer.photo.shown), ');
  await page.evaluate(() => {
    const { photo } = window.cpplusViewer;
    const { index } = photo;
    photo.hide();
    photo.show(index);
  });
  assert.deepEqual(await direction(), straight);
  console.log('39', process.uptime().toFixed(1), 'assert.deepEqual(await direction(), straight);');

  // The switch moves the camera to the coarse pose.
  const place = () => page.evaluate(() => window.cpplusViewer.stage.camera.position.toArray());
  const before = await place();
  console.log('40', process.uptime().toFixed(1), 'const before = await place();');
  await press('button[data-kind=coarse]');
  console.log('41', process.uptime().toFixed(1), "await press('button[data-kind=coarse]');");
  assert.notDeepEqual(await place(), before);
  console.log('42', process.uptime().toFixed(1), 'assert.notDeepEqual(await place(), before);');
  await press('button[data-kind=refined]');
  console.log('43', process.uptime().toFixed(1), "await press('button[data-kind=refined]');");
  assert.deepEqual(await place(), before);
  console.log('44', process.uptime().toFixed(1), 'assert.deepEqual(await place(), before);');
  await page.keyboard.press('Escape');
  console.log('45', process.uptime().toFixed(1), "await page.keyboard.press('Escape');");

  // Two points and their distance.
  await settled();
  console.log('46', process.uptime().toFixed(1), 'await settled();');
  await press('#measure');
  console.log('47', process.uptime().toFixed(1), "await press('#measure');");
  const targets = await page.evaluate(() => {
    const found = [];
    for (let x = 300; x < innerWidth - 60 && found.length < 40; x += 23) {
      for (let y = 120; y < innerHeight - 120; y += 61) if (window.cpplusViewer.cloud.pointAt(x, y)) found.push([x, y]);
    }
    return [found[0], found[found.length - 1]];
  });
  for (const target of targets) await page.mouse.click(...target);
  const distance = await page.evaluate(() => window.cpplusViewer.measure.distance);
  console.log('48', process.uptime().toFixed(1), 'const distance = await page.evaluate(() => window.cpplusViewer.measure');
  assert.ok(distance > 0.05, `distance ${distance}`);
  console.log('49', process.uptime().toFixed(1), 'assert.ok(distance > 0.05, `distance ${distance}`);');
  await page.waitForFunction(() => !document.getElementById('measure-label').hidden);
  console.log('50', process.uptime().toFixed(1), "await page.waitForFunction(() => !document.getElementById('measure-lab");
  assert.equal(await page.textContent('#measure-label'), `${distance.toFixed(3)} m`);
  console.log('51', process.uptime().toFixed(1), "assert.equal(await page.textContent('#measure-label'), `${distance.toF");
  // The orange line is seen: points that the cut hides are not measured.
  const line = await shareOfPixels(page, await shot('measure'), (r, g, b) => r > 240 && Math.abs(g - 140) < 20 && b < 30);
  console.log('52', process.uptime().toFixed(1), "const line = await shareOfPixels(page, await shot('measure'), (r, g, b");
  assert.ok(line > 0.0001, `share of the line: ${line}`);
  console.log('53', process.uptime().toFixed(1), 'assert.ok(line > 0.0001, `share of the line: ${line}`);');

  assert.deepEqual(problems, []);
  console.log('54', process.uptime().toFixed(1), 'assert.deepEqual(problems, []);');
  console.log(`viewer: all well; cloud against its photo ${same.toFixed(1)}, against another ${other.toFixed(1)}`);
} finally {
  server.kill();
  await browser.close();
  console.log('55', process.uptime().toFixed(1), 'await browser.close();');
  await stopped;
  console.log('56', process.uptime().toFixed(1), 'await stopped;');
}
