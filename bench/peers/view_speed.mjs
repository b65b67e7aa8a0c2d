// usage: node view_speed.mjs CPPLUS RESULT_FOLDER SCREENSHOT [MORE_OPTIONS_OF_VIEW...]
// Serves a viewer, opens it in headless Chromium with software rendering, and prints as JSON: seconds until the server
// is ready, until something is drawn and until all of it is; frames a second while orbiting; memory of both, MB.
import { spawn } from 'node:child_process';
import { readFileSync, readdirSync } from 'node:fs';
import { openPage, startBrowser } from '../../web/test/browser.js';

const ORBIT_MS = 15000;
const [program, folder, picture, ...more] = process.argv.slice(2);
const seconds = (since) => (performance.now() - since) / 1000;

/** A number of /proc/PID/status in MB; 0 where the process has gone. */
function statusMb(pid, key) {
  try {
    return Number(readFileSync(`/proc/${pid}/status`, 'utf8').match(new RegExp(`${key}:\\s+(\\d+)`))[1]) / 1024;
  } catch { return 0; }
}

function parentOf(pid) {
  try { return Number(readFileSync(`/proc/${pid}/status`, 'utf8').match(/PPid:\s+(\d+)/)[1]); } catch { return 0; }
}

/** Memory of all processes below one, without pages that they share, MB. */
function treeMb(root) {
  const pids = readdirSync('/proc').filter((name) => /^\d+$/.test(name)).map(Number);
  const isBelow = (pid) => pid === root || (pid > 1 && isBelow(parentOf(pid)));
  return pids.filter(isBelow).reduce((sum, pid) => sum + statusMb(pid, 'RssAnon') + statusMb(pid, 'RssShmem'), 0);
}

const browser = await startBrowser();
const begin = performance.now();
const server = spawn(program, ['view', folder, '--port', '0', ...more], { stdio: ['ignore', 'pipe', 'inherit'] });
const stopped = new Promise((done) => { server.on('exit', done); });
try {
  const address = await new Promise((done, fail) => {
    server.stdout.on('data', (text) => done(String(text).trim()));
    server.on('exit', (code) => fail(new Error(`cpplus view ended with ${code}`)));
  });
  const result = { server_s: seconds(begin), server_peak_mb: statusMb(server.pid, 'VmHWM') };
  const { page, problems } = await openPage(browser, { viewport: { width: 1280, height: 800 } });
  page.setDefaultTimeout(600000);
  const opened = performance.now();
  await page.goto(address);
  await page.waitForFunction(() => window.cpplusViewer?.cloud.numDrawn > 0);
  result.first_picture_s = seconds(opened);
  await page.waitForFunction(() => {
    const { cloud, stage } = window.cpplusViewer;
    stage.invalidate();
    window.quietLooks = cloud.isLoading ? 0 : (window.quietLooks ?? 0) + 1;
    return window.quietLooks > 5;
  }, null, { polling: 200 });
  result.whole_picture_s = seconds(opened);
  result.points_drawn = await page.evaluate(() => window.cpplusViewer.cloud.numDrawn);
  await page.screenshot({ path: picture });
  const orbit = await page.evaluate((duration) => new Promise((done) => {
    const { stage, cloud } = window.cpplusViewer;
    const { camera, controls } = stage;
    const start = performance.now();
    let frames = 0, drawn = 0;
    const step = () => {
      if (performance.now() - start > duration) {
        return done({ frames_per_s: (1000 * frames) / (performance.now() - start), points_drawn_moving: drawn / frames });
      }
      camera.position.sub(controls.target).applyAxisAngle(stage.up, 0.02).add(controls.target);
      stage.invalidate();
      frames += 1;
      drawn += cloud.numDrawn;
      requestAnimationFrame(step);
    };
    step();
  }), ORBIT_MS);
  Object.assign(result, orbit);
  result.server_mb = statusMb(server.pid, 'RssAnon');
  result.browser_mb = treeMb(process.pid) - result.server_mb - statusMb(process.pid, 'RssAnon');
  if (problems.length) throw new Error(problems.join('\n'));
  console.log(JSON.stringify(Object.fromEntries(Object.entries(result).map(([key, value]) => [key, Math.round(value * 100) / 100]))));
} finally {
  server.kill();
  await browser.close();
  await stopped;
}
