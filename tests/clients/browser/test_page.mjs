// SPDX-License-Identifier: BSD-3-Clause
// SPDX-FileCopyrightText: 2026 the softsim authors
//
// The page as a person uses it: it shows the body, a press of the mouse deforms it and is felt, it
// comes back to rest; pause, reset, a parameter, a colour, a recording. What is waited for has no
// limit but one against hanging.
//   node test_page.mjs PAGE_FOLDER ADDRESS PICTURE_FOLDER
import assert from 'node:assert/strict';
import { pathToFileURL } from 'node:url';

const [pageFolder, address, pictures] = process.argv.slice(2);
const { chromium } = await import(pathToFileURL(`${pageFolder}/node_modules/playwright-core/index.mjs`));
const HANG_MS = 240000;

const browser = await chromium.launch({
  executablePath: '/usr/bin/chromium',
  args: ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update',
    '--disable-sync', '--disable-dev-shm-usage', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
});
const faults = [];

async function open(options) {
  const page = await browser.newPage({ viewport: { width: 1000, height: 640 }, ...options });
  page.setDefaultTimeout(HANG_MS);
  page.on('pageerror', (error) => faults.push(error.message));
  page.on('console', (message) => { if (message.type() === 'error') faults.push(message.text()); });
  await page.goto(address);
  await page.waitForFunction(() => document.title === 'softsim: live');
  await page.waitForFunction(() => softsim.tools.size > 0);
  return page;
}

const until = (page, claim) => page.waitForFunction(claim, null, { timeout: HANG_MS });

// Where the upper face of the kidney is on the screen.
async function target(page) {
  return page.evaluate(() => {
    const { camera, body } = softsim;
    const place = body.sphere.center.clone();
    place.set(0, 0.006, 0.022).project(camera);
    const box = document.getElementById('view').getBoundingClientRect();
    return [box.left + ((place.x + 1) / 2) * box.width, box.top + ((1 - place.y) / 2) * box.height];
  });
}

// Pixels of the canvas that are not the background.
const drawn = (page) => page.evaluate(() => {
  const { canvas } = { canvas: document.getElementById('view') };
  const copy = document.createElement('canvas');
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const context = copy.getContext('2d');
  context.drawImage(canvas, 0, 0);
  const { data } = context.getImageData(0, 0, copy.width, copy.height);
  let count = 0;
  for (let i = 0; i < data.length; i += 4) {
    count += Math.abs(data[i] - data[0]) + Math.abs(data[i + 1] - data[1]) + Math.abs(data[i + 2] - data[2]) > 40;
  }
  return count / (data.length / 4);
});

const page = await open({ colorScheme: 'light' });
assert.ok((await drawn(page)) > 0.05, 'a body is drawn');
assert.match(await page.textContent('#scene-name'), /^kidney\.yaml · cnn-energy$/);

await page.click('#record');
await until(page, () => document.getElementById('record').textContent === 'Stop');
const [x, y] = await target(page);
await page.mouse.move(x, y);
await page.mouse.down();
await until(page, () => softsim.state.force > 0.2 && Math.max(...softsim.body.count) > 20);
await until(page, () => softsim.plots.samples.some((s) => s[1] > 0.2));
await page.mouse.move(x + 15, y, { steps: 5 });
await page.selectOption('#colour', 'displacement');
await until(page, () => !document.getElementById('legend').hidden);
await page.screenshot({ path: `${pictures}/press.png` });
await page.mouse.up();
await until(page, () => softsim.body.count.every((c) => Math.abs(c) <= 2));
await until(page, () => softsim.hand.press === null);
await page.click('#record');
await until(page, () => document.querySelectorAll('#recordings a').length === 1);
const fetched = await page.evaluate(async () => {
  const answer = await fetch(document.querySelector('#recordings a').href);
  return [answer.status, (await answer.arrayBuffer()).byteLength];
});
assert.equal(fetched[0], 200);
assert.ok(fetched[1] > 10000, 'a recording holds what was sent');

await page.click('#pause');
await until(page, () => document.getElementById('pause').textContent === 'Resume');
await page.click('#pause');
await until(page, () => document.getElementById('pause').textContent === 'Pause');
await page.click('#reset');
await until(page, () => document.getElementById('reply').textContent.startsWith('reset'));
await page.evaluate(() => {
  const slider = document.getElementById('set-haptic.max_force_n');
  slider.value = 0.5;
  slider.dispatchEvent(new Event('input'));
});
await until(page, () => document.getElementById('reply').textContent.startsWith('haptic.max_force_n = '));
for (const id of ['show-edges', 'show-ghost']) await page.check(`#${id}`);
await page.keyboard.press('Escape');

// A second browser watches while the first one holds the probe; a phone and the dark page draw.
const phone = await open({ viewport: { width: 390, height: 780 }, colorScheme: 'dark', hasTouch: true });
assert.ok((await drawn(phone)) > 0.03, 'a body is drawn on a phone');
const width = await phone.evaluate(() => document.documentElement.scrollWidth);
assert.ok(width <= 390, `the page is ${width} wide on a phone of 390`);
await page.bringToFront();
await page.mouse.move(x, y);
await page.mouse.down();
await until(phone, () => softsim.state.isOthers === true);
await phone.screenshot({ path: `${pictures}/phone.png` });
await page.mouse.up();
await until(phone, () => softsim.state.isOthers === false);

assert.deepEqual(faults, []);
await browser.close();
console.log('test_page: the page shows, pushes, lets go, pauses, resets, sets and records');
