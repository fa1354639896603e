// SPDX-License-Identifier: BSD-3-Clause
// SPDX-FileCopyrightText: 2026 the softsim authors
//
// One picture of the page with the mouse pressing on the body, or the frames of a film of it.
//   node take_pictures.mjs PAGE_FOLDER ADDRESS OUT [OPTION=VALUE]...
// colour=NAME  size=WxH  dark  phone  edges  ghost  at=X,Y,Z (m)  view=X,Y,Z (whence)  grasp=DX,DY
// (pixels)  depth=N (turns of the wheel)  film=FRAMES (OUT is then a folder)
import { launch, onScreen, open, until } from './chromium.mjs';

const [pageFolder, address, out, ...words] = process.argv.slice(2);
const given = Object.fromEntries(words.map((word) => word.split('=')));
const numbers = (text) => text.split(/[x,]/).map(Number);
const [width, height] = numbers(given.size ?? '1000x640');
const browser = await launch(pageFolder);
const faults = [];
const page = await open(browser, address, {
  viewport: { width, height }, hasTouch: 'phone' in given, deviceScaleFactor: 'phone' in given ? 1.5 : 1, isMobile: 'phone' in given,
  colorScheme: 'dark' in given ? 'dark' : 'light',
}, faults);
const pause = (ms) => page.waitForTimeout(ms);

if (given.view) {
  await page.evaluate(([x, y, z]) => {
    const { camera, orbit } = softsim.view;
    const far = camera.position.distanceTo(orbit.target);
    camera.position.set(x, y, z).setLength(far).add(orbit.target);
    orbit.update();
  }, numbers(given.view));
}
if (given.colour) await page.selectOption('#colour', given.colour);
for (const name of ['edges', 'ghost']) if (name in given) await page.check(`#show-${name}`);
await pause(300);
const [x, y] = await onScreen(page, numbers(given.at ?? '0,0,0'));

async function press() {
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 0; i < Number(given.depth ?? 0); ++i) await page.mouse.wheel(0, -100);
  await until(page, () => softsim.readings.force > 0.05);
}

async function film(frames) {
  const { x: left, y: top, width: across, height: down } = await page.locator('#view').boundingBox();
  const clip = { x: left + 60, y: top + 0.18 * down, width: across - 120, height: 0.64 * down }; // no words
  const path = (i) => `${out}/${String(i).padStart(3, '0')}.png`;
  for (let i = 0; i < frames; ++i) {
    const share = i / frames; // presses, slides to and fro, lets go
    if (i === Math.round(0.08 * frames)) await press();
    if (share > 0.25 && share < 0.75) await page.mouse.move(x + 70 * Math.sin(4 * Math.PI * (share - 0.25)), y);
    if (i === Math.round(0.8 * frames)) await page.mouse.up();
    await pause(30);
    await page.screenshot({ path: path(i), clip });
  }
}

if (given.film) {
  await film(Number(given.film));
} else {
  await press();
  await pause(2000);
  if (given.grasp) {
    const [dx, dy] = numbers(given.grasp);
    await page.keyboard.down('Shift');
    await pause(400);
    await page.mouse.move(x + dx, y + dy, { steps: 20 });
    await until(page, () => [...softsim.tools.of.values()].some((tool) => tool.state && (tool.state.flags & 128) !== 0));
    await pause(1500);
  }
  // As it is when nothing is let in by and by (8), or late (16).
  await until(page, () => [...softsim.tools.of.values()].some((tool) => tool.state && (tool.state.flags & 25) === 1));
  await page.evaluate(() => document.getElementById('panel').scrollTo(0, 0));
  await page.screenshot({ path: out });
}
await page.mouse.up();
await browser.close();
if (faults.length > 0) {
  console.error(faults.join('\n'));
  process.exit(1);
}
