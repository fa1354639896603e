// SPDX-License-Identifier: BSD-3-Clause
// SPDX-FileCopyrightText: 2026 the softsim authors
//
// The page as a person uses it: it shows the body, a press of the mouse deforms it and is felt, it
// comes back to rest; pause, reset, a parameter, a colour, a recording. What is waited for has no
// limit but one against hanging.
//   node test_page.mjs PAGE_FOLDER ADDRESS PICTURE_FOLDER
import assert from 'node:assert/strict';
import { launch, onScreen, open, until } from './chromium.mjs';

const [pageFolder, address, pictures] = process.argv.slice(2);
const browser = await launch(pageFolder);
const faults = [];
const UPPER_FACE = [0, 0.006, 0.022]; // of the kidney

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

const page = await open(browser, address, { colorScheme: 'light' }, faults);
assert.ok((await drawn(page)) > 0.05, 'a body is drawn');
assert.match(await page.textContent('#scene-name'), /^kidney\.yaml · cnn-energy$/);

await page.click('#record');
await until(page, () => document.getElementById('record').textContent === 'Stop');
const [x, y] = await onScreen(page, UPPER_FACE);
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

// A tool that nobody moves is not shown any more, and may be had again: the first of the two.
await until(page, () => [...softsim.tools.values()].every((tool) => !tool.visible));

// Shift grasps: drawn outward, the hand is pulled back; let go, the body is at rest again.
await page.mouse.move(x, y);
await page.mouse.down();
await until(page, () => softsim.state.force > 0.2);
assert.equal(await page.evaluate(() => softsim.hand.tool.description.probe), 0);
await page.keyboard.down('Shift');
await until(page, () => [...softsim.tools.values()].some((tool) => ((tool.state?.flags ?? 0) & 128) !== 0));
await page.mouse.move(x, y - 60, { steps: 10 });
await until(page, () => [...softsim.tools.values()].some((tool) => ((tool.state?.flags ?? 0) & 128) !== 0 && tool.state.force[2] < -0.3));
assert.ok(await page.evaluate(() => Math.max(...softsim.body.count) > 20), 'a grasp pulls the body');
await page.mouse.up();
await page.keyboard.up('Shift');
await until(page, () => [...softsim.tools.values()].every((tool) => ((tool.state?.flags ?? 0) & 128) === 0 || !tool.visible));
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
const phone = await open(browser, address, { viewport: { width: 390, height: 780 }, colorScheme: 'dark', hasTouch: true }, faults);
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
console.log('test_page: the page shows, pushes, lets go, grasps, pauses, resets, sets and records');
