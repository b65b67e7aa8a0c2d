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
  assert.equal(await statusFor(address, '127.0.0.1'), 200);
  assert.equal(await statusFor(address, 'example.org'), 403);

  const { page, problems } = await openPage(browser, { viewport: { width: 1000, height: 700 } });
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
  await page.waitForFunction(() => window.cpplusViewer);
  await page.evaluate(() => { window.cpplusViewer.cloud.detail = 7; });  // fewer points: there may be no graphics card
  await settled();
  const overview = await shot('view');
  const numAtRest = await page.evaluate(() => window.cpplusViewer.cloud.numDrawn);
  assert.ok(numAtRest > 1000);
  assert.ok((await drawnShare(overview)) > 0.1, `share of the overview that is drawn: ${await drawnShare(overview)}`);
  const colored = await shareOfPixels(page, overview, (r, g, b) => Math.max(r, g, b) - Math.min(r, g, b) > 25);
  assert.ok(colored > 0.005, `coloured share of the overview: ${colored}`);

  // Slow frames of a movement are drawn coarser, and all points are back at rest.
  const numMoving = await page.evaluate(() => new Promise((done) => {
    const { stage, cloud } = window.cpplusViewer;
    let frames = 0;
    const step = () => {
      const start = performance.now();
      while (performance.now() - start < 100);  // a frame that takes long, also where there is a graphics card
      stage.camera.position.sub(stage.controls.target).applyAxisAngle(stage.up, frames % 2 ? 0.05 : -0.05).add(stage.controls.target);
      stage.invalidate();
      frames += 1;
      if (frames === 24) done(cloud.numDrawn);
      else requestAnimationFrame(step);
    };
    step();
  }));
  assert.ok(numMoving < 0.5 * numAtRest, `points while it moves: ${numMoving}, at rest: ${numAtRest}`);
  await page.waitForFunction((count) => {
    window.cpplusViewer.stage.invalidate();
    return window.cpplusViewer.cloud.numDrawn === count;
  }, numAtRest, { polling: 100 });

  // A click on a camera.
  const index = await page.evaluate(() => {
    const { cameras } = window.cpplusViewer;
    const inside = ([x, y]) => x > 280 && x < innerWidth - 20 && y > 20 && y < innerHeight - 60;
    return window.cpplusView.images.findIndex((image, i) => inside(cameras.screenPlace(i))
      && cameras.pick(...cameras.screenPlace(i)) === i && image.status === 'refined');
  });
  assert.ok(index >= 0, 'a camera can be clicked');
  await page.mouse.click(...(await page.evaluate((i) => window.cpplusViewer.cameras.screenPlace(i), index)));
  await page.waitForFunction(() => window.cpplusViewer.photo.ready);
  assert.equal(await page.evaluate(() => window.cpplusViewer.photo.index), index);
  await settled();
  await page.locator('#photo-bar input[type=range]').fill('0');
  const cloudOnly = await shot('photo_0');
  await page.locator('#photo-bar input[type=range]').fill('1');
  const photoOnly = await shot('photo_1');
  await page.locator('#photo-bar input[type=range]').fill('0.5');
  await shot('photo_half');
  assert.ok((await drawnShare(photoOnly)) > 0.5, 'the photo fills the view');
  assert.notDeepEqual(cloudOnly, photoOnly);

  // The coloured cloud looks as the photo does, but for its exposure: where points are drawn their brightness goes with
  // the photo's, and more so than with that of another photo.
  const correlation = (cloud, photo) => page.evaluate(async ([first, second]) => {
    const middle = async (data) => {
      const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${data}`)).blob());
      const canvas = new OffscreenCanvas(image.width - 300, image.height - 120);
      const context = canvas.getContext('2d');
      context.drawImage(image, -150, -60);
      return context.getImageData(0, 0, canvas.width, canvas.height).data;
    };
    const [x, y] = [await middle(first), await middle(second)];
    const gray = (rgba, i) => (rgba[i] + rgba[i + 1] + rgba[i + 2]) / 3;
    let [n, sx, sy, sxx, sxy, syy] = [0, 0, 0, 0, 0, 0];
    for (let i = 0; i < x.length; i += 4) {
      if (x[i] > 0xe0 && x[i + 1] > 0xe3 && x[i + 2] > 0xe6) continue;  // the background
      const [a, b] = [gray(x, i), gray(y, i)];
      n += 1, sx += a, sy += b, sxx += a * a, sxy += a * b, syy += b * b;
    }
    return (n * sxy - sx * sy) / Math.sqrt((n * sxx - sx * sx) * (n * syy - sy * sy));
  }, [cloud.toString('base64'), photo.toString('base64')]);
  // Another one whose pose was refined as well: the switch below has to move it.
  const another = await page.evaluate(
    (i) => window.cpplusView.images.findLastIndex((image, k) => k !== i && image.status === 'refined'), index);
  assert.ok(another >= 0, 'two images are refined');
  await page.evaluate((i) => window.cpplusViewer.photo.show(i), another);
  await page.waitForFunction(() => window.cpplusViewer.photo.ready);
  await page.locator('#photo-bar input[type=range]').fill('1');
  const otherPhoto = await shot('photo_other');
  const [same, other] = [await correlation(cloudOnly, photoOnly), await correlation(cloudOnly, otherPhoto)];
  assert.ok(same > 0.3 && same > other + 0.2, `correlation of the cloud with its photo ${same}, with another ${other}`);

  // A drag looks around; shown anew, the photo is looked at straight again.
  const direction = () => page.evaluate(() => window.cpplusViewer.stage.camera.quaternion.toArray());
  const straight = await direction();
  await page.mouse.move(600, 300);
  await page.mouse.down();
  await page.mouse.move(480, 340);
  await page.mouse.up();
  const turned = await direction();
  const angle = 2 * Math.acos(Math.min(1, Math.abs(straight.reduce((sum, value, i) => sum + value * turned[i], 0))));
  assert.ok(angle > 0.02 && angle < 0.6, `turned by ${angle} rad`);
  assert.ok(await page.evaluate(() => window.cpplusViewer.photo.shown), 'a drag does not leave the photo');
  await page.evaluate(() => {
    const { photo } = window.cpplusViewer;
    const { index } = photo;
    photo.hide();
    photo.show(index);
  });
  assert.deepEqual(await direction(), straight);

  // The switch moves the camera to the coarse pose.
  const place = () => page.evaluate(() => window.cpplusViewer.stage.camera.position.toArray());
  const before = await place();
  await press('button[data-kind=coarse]');
  assert.notDeepEqual(await place(), before);
  await press('button[data-kind=refined]');
  assert.deepEqual(await place(), before);
  await page.keyboard.press('Escape');

  // Two points and their distance.
  await settled();
  await press('#measure');
  const targets = await page.evaluate(() => {
    const found = [];
    for (let x = 300; x < innerWidth - 60 && found.length < 40; x += 23) {
      for (let y = 120; y < innerHeight - 120; y += 61) if (window.cpplusViewer.cloud.pointAt(x, y)) found.push([x, y]);
    }
    return [found[0], found[found.length - 1]];
  });
  for (const target of targets) await page.mouse.click(...target);
  const distance = await page.evaluate(() => window.cpplusViewer.measure.distance);
  assert.ok(distance > 0.05, `distance ${distance}`);
  await page.waitForFunction(() => !document.getElementById('measure-label').hidden);
  assert.equal(await page.textContent('#measure-label'), `${distance.toFixed(3)} m`);
  // The orange line is seen: points that the cut hides are not measured.
  const line = await shareOfPixels(page, await shot('measure'), (r, g, b) => r > 240 && Math.abs(g - 140) < 20 && b < 30);
  assert.ok(line > 0.0001, `share of the line: ${line}`);

  assert.deepEqual(problems, []);
  console.log(`viewer: all well; correlation of the cloud with its photo ${same.toFixed(2)}, with another ${other.toFixed(2)}`);
} finally {
  server.kill();
  await browser.close();
  await stopped;
}
