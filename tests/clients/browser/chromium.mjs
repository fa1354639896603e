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

// A page that shows the body and knows the tools; what goes wrong in it is added to `faults`.
export async function open(browser, address, options, faults = []) {
  const page = await browser.newPage({ viewport: { width: 1000, height: 640 }, ...options });
  page.setDefaultTimeout(HANG_MS);
  page.on('pageerror', (error) => faults.push(error.message));
  page.on('console', (message) => { if (message.type() === 'error') faults.push(message.text()); });
  await page.goto(address);
  await page.waitForFunction(() => document.title === 'softsim: live');
  await page.waitForFunction(() => softsim.tools.size > 0);
  return page;
}

export const until = (page, claim, argument = null) => page.waitForFunction(claim, argument, { timeout: HANG_MS });

// Where a point of the body at rest (metres) is on the screen.
export const onScreen = (page, point) => page.evaluate(([x, y, z]) => {
  const { camera, body } = softsim;
  const place = body.sphere.center.clone().set(x, y, z).project(camera);
  const box = document.getElementById('view').getBoundingClientRect();
  return [box.left + ((place.x + 1) / 2) * box.width, box.top + ((1 - place.y) / 2) * box.height];
}, point);
