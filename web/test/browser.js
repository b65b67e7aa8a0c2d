// What both page tests share: a headless Chromium of the system, driven by playwright-core.
import { existsSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const web = dirname(dirname(fileURLToPath(import.meta.url)));
const SKIPPED = 77;

function skip(why) {
  console.log(`skipped: ${why}`);
  process.exit(SKIPPED);
}

/** Starts Chromium; ends the test as skipped where it or playwright-core is missing. */
export async function startBrowser() {
  const executablePath = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);
  if (!executablePath) skip('no Chromium (apt install chromium)');
  if (!existsSync(join(web, 'node_modules', 'playwright-core'))) skip('no playwright-core (run npm ci in web/)');
  const { chromium } = await import('playwright-core');
  return chromium.launch({
    executablePath,
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
  });
}

/** A page that collects everything that goes wrong in it. */
export async function openPage(browser, options) {
  const page = await browser.newPage(options);
  const problems = [];
  page.on('console', (message) => { if (message.type() === 'error') problems.push(message.text()); });
  page.on('pageerror', (error) => problems.push(String(error)));
  page.on('requestfailed', (request) => problems.push(`${request.url()}: ${request.failure()?.errorText}`));
  return { page, problems };
}

/** Share of the pixels of a PNG screenshot for which `wanted(r, g, b)` holds, counted by the browser itself. */
export async function shareOfPixels(page, png, wanted) {
  return page.evaluate(async ([data, source]) => {
    const test = new Function(`return ${source}`)();
    const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${data}`)).blob());
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const { data: rgba } = context.getImageData(0, 0, image.width, image.height);
    let count = 0;
    for (let i = 0; i < rgba.length; i += 4) count += test(rgba[i], rgba[i + 1], rgba[i + 2]) ? 1 : 0;
    return count / (rgba.length / 4);
  }, [png.toString('base64'), String(wanted)]);
}
