// SPDX-License-Identifier: BSD-3-Clause
// SPDX-FileCopyrightText: 2026 the softsim authors
//
// A headless Chromium with the page of softsim-web open in it: shared by the test and the pictures.
import { pathToFileURL } from 'node:url';

const HANG_MS = 240000; // no limit of the page's, but one against hanging

export async function launch(pageFolder) {
  const { chromium } = await import(pathToFileURL(`${pageFolder}/node_modules/playwright-core/index.mjs`));
  return chromium.launch({
    executablePath: '/usr/bin/chromium',
    args: ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update',
      '--disable-sync', '--disable-dev-shm-usage', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
  });
}

export async function blank(browser, options = {}) {
  const page = await browser.newPage(options);
  page.setDefaultTimeout(HANG_MS);
  return page;
}

// A page that shows the body and knows the tools; what goes wrong in it is added to `faults`.
export async function open(browser, address, options, faults = []) {
  const page = await blank(browser, { viewport: { width: 1000, height: 640 }, ...options });
  page.on('pageerror', (error) => faults.push(error.message));
  page.on('console', (message) => { if (message.type() === 'error') faults.push(message.text()); });
  await page.goto(address);
  await page.waitForFunction(() => document.title === 'softsim: live');
  await page.waitForFunction(() => softsim.tools.of.size > 0);
  await page.waitForFunction((before) => softsim.view.frames > before + 1, await page.evaluate(() => softsim.view.frames));
  return page;
}

let patience = HANG_MS;
export const until = (page, claim, argument = null) => page.waitForFunction(claim, argument, { timeout: patience });

// A page that the machine holds up for longer than the server's patience is let go of, and its user
// begins anew: what `attempt` waits for may take TRIES of them.
const TRIES = 6;
export async function again(attempt, letGo) {
  const before = patience;
  for (let tries = 1; ; ++tries) {
    patience = HANG_MS / TRIES;
    try {
      return await attempt();
    } catch (error) {
      if (tries === TRIES || error.name !== 'TimeoutError') throw error;
    } finally {
      patience = before;
    }
    await letGo();
  }
}

// Presses at [x, y] until `claim` holds in `at`.
export const press = (page, [x, y], claim, at = page) => again(async () => {
  await page.mouse.move(x, y);
  await page.mouse.down();
  await until(at, claim);
}, () => page.mouse.up());

// Where a point of the body at rest (metres) is on the screen.
export const onScreen = (page, point) => page.evaluate(([x, y, z]) => {
  const { view: { camera }, body } = softsim;
  const place = body.sphere.center.clone().set(x, y, z).project(camera);
  const box = document.getElementById('view').getBoundingClientRect();
  return [box.left + ((place.x + 1) / 2) * box.width, box.top + ((1 - place.y) / 2) * box.height];
}, point);

// Pixels of the picture that are not its background, as a share.
export const drawn = (page) => page.evaluate(() => {
  const canvas = document.getElementById('view'), copy = document.createElement('canvas');
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

// A body that stands as it was made, and nobody's tool.
export const rest = async (page) => {
  await until(page, () => softsim.hand.press === null);
  await until(page, () => softsim.body.count.every((c) => Math.abs(c) <= 2));
};
