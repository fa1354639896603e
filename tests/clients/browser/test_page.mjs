// SPDX-License-Identifier: BSD-3-Clause
// SPDX-FileCopyrightText: 2026 the softsim authors
//
// The page as a person uses it, with a mouse, a finger and keys: it shows the body, a press deforms it
// and is felt, it comes back to rest; grasp, pause, reset, a parameter, a colour, a recording. What is
// waited for has no limit but one against hanging.
//   node test_page.mjs PAGE_FOLDER ADDRESS PICTURE_FOLDER
import assert from 'node:assert/strict';
import { again, drawn, launch, onScreen, open, press, rest, until } from './chromium.mjs';

const [pageFolder, address, pictures] = process.argv.slice(2);
const browser = await launch(pageFolder);
const faults = [];
const UPPER_FACE = [0, 0.006, 0.022]; // of the kidney
const GRASPING = 128;

const shown = (page, id) => until(page, (name) => !document.getElementById(name).hidden, id);
const hidden = (page, id) => until(page, (name) => document.getElementById(name).hidden, id);
const isFelt = () => softsim.readings.force > 0.2;
const grasped = (page, isWanted) => until(page, ([flag, wanted]) => {
  const states = [...softsim.tools.of.values()].filter((tool) => tool.visible).map((tool) => tool.state);
  return wanted === states.some((state) => (state.flags & flag) !== 0);
}, [GRASPING, isWanted]);

const page = await open(browser, address, { colorScheme: 'light' }, faults);
assert.ok((await drawn(page)) > 0.05, 'a body is drawn');
assert.match(await page.textContent('#scene-name'), /^kidney\.yaml · cnn-energy$/);
const [x, y] = await onScreen(page, UPPER_FACE);

async function pressesWithTheMouse() {
  await press(page, [x, y], isFelt);
  await until(page, () => Math.max(...softsim.body.count) > 20);
  await until(page, () => softsim.plots.histories.get(0).samples.some((s) => s[1] > 0.2));
  await page.mouse.move(x + 15, y, { steps: 5 });
  await page.selectOption('#colour', 'displacement');
  await shown(page, 'legend');
  await page.screenshot({ path: `${pictures}/press.png` });
  await page.evaluate(() => {
    window.shown = [];
    softsim.link.on('status', ({ status }) => window.shown.push([status.verdict, status.reason, document.getElementById('reason').textContent]));
  });
  await page.mouse.up();
  await rest(page);
  await until(page, () => window.shown.some(([, reason]) => reason === 'probe 0 went silent: its force is ramped to zero'));
  assert.ok(await page.evaluate(() => window.shown.every(([verdict, reason, told]) => verdict !== 0 || !/went silent/.test(reason) || told === '')), 'letting go is no news');
}

// A Shift that is let go while another window has the keys is let go.
async function forgetsShift() {
  await page.focus('#view');
  await page.keyboard.down('Shift');
  assert.equal(await page.evaluate(() => softsim.hand.isShift), true);
  await page.evaluate(() => dispatchEvent(new Event('blur')));
  assert.equal(await page.evaluate(() => softsim.hand.isShift), false);
  await page.keyboard.up('Shift');
}

// A grasp is drawn outward, and the hand is pulled back; a tool that nobody moved any more may be had
// again: the first of the two.
async function graspsWithShift() {
  await until(page, () => [...softsim.tools.of.values()].every((tool) => !tool.visible));
  await again(async () => {
    await press(page, [x, y], isFelt);
    assert.equal(await page.evaluate(() => softsim.hand.tool.description.probe), 0);
    await page.keyboard.down('Shift');
    await grasped(page, true);
    await page.mouse.move(x, y - 60, { steps: 10 });
    await until(page, () => softsim.hand.tool.state.force[2] < -0.3);
  }, async () => {
    await page.mouse.up();
    await page.keyboard.up('Shift');
    await rest(page);
  });
  assert.ok(await page.evaluate(() => Math.max(...softsim.body.count) > 20), 'a grasp pulls the body');
  await page.mouse.up();
  await page.keyboard.up('Shift');
  await grasped(page, false);
  await rest(page);
}

async function recordsTo() {
  await page.click('#record');
  await until(page, () => document.querySelectorAll('#recordings a').length === 1);
  const [status, size] = await page.evaluate(async () => {
    const answer = await fetch(document.querySelector('#recordings a').href);
    return [answer.status, (await answer.arrayBuffer()).byteLength];
  });
  assert.equal(status, 200);
  assert.ok(size > 10000, 'a recording holds what was sent');
}

async function commands() {
  await page.click('#pause');
  await until(page, () => document.getElementById('pause').textContent === 'Resume');
  await page.click('#pause');
  await until(page, () => document.getElementById('pause').textContent === 'Pause');
  await page.click('#reset');
  await until(page, () => document.getElementById('reply').textContent.startsWith('reset'));
}

// The range stands at the slider; what is not within it is said so and not sent; what is, is set.
async function parameters() {
  const number = page.locator('[id="number-haptic.max_force_n"]');
  const box = page.locator('.parameter', { has: number });
  assert.match(await box.textContent(), /^Max force\s*N\s*0\.01\s*8$/);
  await number.fill('9');
  await number.press('Enter');
  await until(page, () => /Max force: 9 is not within 0\.01 to 8 N/.test(document.getElementById('notice').textContent));
  assert.match(await box.textContent(), /not within 0\.01 to 8 N/);
  assert.equal(await number.getAttribute('aria-invalid'), 'true');
  await number.fill('7.5');
  await number.press('Enter');
  await until(page, () => document.getElementById('reply').textContent.startsWith('haptic.max_force_n = 7.5'));
  assert.equal(await number.getAttribute('aria-invalid'), 'false');
  await page.evaluate(() => {
    const slider = document.getElementById('set-haptic.max_force_n');
    slider.value = 1;
    slider.dispatchEvent(new Event('input'));
  });
  await until(page, () => document.getElementById('reply').textContent.startsWith('haptic.max_force_n = 8'));
  for (const id of ['show-edges', 'show-ghost']) await page.check(`#${id}`);
}

// All of it without a mouse, by what the list of keys says.
async function worksByKeys() {
  await page.focus('#view');
  await page.keyboard.press('f');
  await page.keyboard.press('?');
  await until(page, () => document.getElementById('help').open);
  const listed = await page.locator('#keys kbd').allTextContents();
  for (const key of ['Enter', 'G', '+', '−', '←', '→', '↑', '↓', 'I', 'O', 'Esc']) assert.ok(listed.includes(key), `${key} is listed`);
  await page.keyboard.press('Escape');
  await until(page, () => !document.getElementById('help').open);
  await page.focus('#view');
  assert.notEqual(await page.evaluate(() => getComputedStyle(document.getElementById('view')).boxShadow), 'none', 'the focus is seen');
  const eye = () => page.evaluate(() => softsim.view.camera.position.clone().sub(softsim.view.orbit.target).toArray());
  const before = await eye();
  await page.keyboard.press('ArrowLeft');
  const turned = await eye();
  assert.ok(Math.hypot(...turned.map((c, d) => c - before[d])) > 0.05 * Math.hypot(...before), 'an arrow turns');
  assert.ok(Math.abs(Math.hypot(...turned) / Math.hypot(...before) - 1) < 1e-3, 'at the same distance');
  await page.keyboard.press('o');
  assert.ok(Math.hypot(...(await eye())) > 1.05 * Math.hypot(...before), 'O is further');
  for (let i = 0; i < 2; ++i) await page.keyboard.press('i');
  assert.ok(Math.hypot(...(await eye())) < 0.95 * Math.hypot(...before), 'I is nearer');
  await page.click('#frame');
  assert.ok(Math.hypot(...(await eye()).map((c, d) => c - before[d])) < 1e-3 * Math.hypot(...before), 'the whole body again');
  const depth = () => page.evaluate(() => parseFloat(document.getElementById('depth-set').textContent));
  const shallow = await depth();
  await again(async () => {
    await page.focus('#view');
    await page.keyboard.press('Enter');
    await until(page, isFelt);
    const place = await page.evaluate(() => softsim.hand.place[0]);
    await page.keyboard.press('ArrowRight');
    await until(page, (left) => softsim.hand.place[0] > left, place); // an arrow moves the tool
    await page.keyboard.press('g');
    await grasped(page, true);
    await page.screenshot({ path: `${pictures}/keys.png` });
    await page.keyboard.press('g');
    await grasped(page, false);
    await page.keyboard.press('Enter');
    await rest(page);
  }, async () => {
    if (await page.evaluate(() => softsim.hand.isPressing())) await page.keyboard.press('Enter');
    await rest(page);
    await page.keyboard.press('f');
  });
  await page.keyboard.press('+');
  assert.ok((await depth()) > 1.1 * shallow, '+ is deeper');
  await page.keyboard.press('-');
  assert.ok(Math.abs((await depth()) - shallow) < 0.02 * shallow, '- is as before');
}

// A second finger sets depth and grasp while the first one presses.
async function worksByFingers(phone) {
  const touch = await phone.context().newCDPSession(phone);
  const send = (type, ...points) => touch.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([id, px, py]) => ({ id, x: px, y: py })) });
  const on = async (id, share = 0.5) => {
    const box = await phone.locator(`#${id}`).boundingBox();
    return [1, box.x + share * box.width, box.y + box.height / 2];
  };
  await phone.bringToFront();
  const first = [0, ...(await onScreen(phone, UPPER_FACE))];
  const shallow = await phone.evaluate(() => softsim.hand.depthShare);
  await again(async () => {
    await send('touchStart', first);
    await until(phone, isFelt);
    await shown(phone, 'grip');
    await send('touchStart', first, await on('depth', 0.8));
    await until(phone, (least) => softsim.hand.depthShare > 1.1 * least, shallow);
    await send('touchEnd', await on('depth', 0.8));
    if (!(await phone.evaluate(() => softsim.hand.isLatched))) {
      await send('touchStart', first, await on('grasp'));
      await send('touchEnd', await on('grasp'));
    }
    await grasped(phone, true);
  }, async () => {
    await send('touchEnd');
    await rest(phone);
  });
  await phone.screenshot({ path: `${pictures}/touch.png` });
  await send('touchEnd');
  await rest(phone);
}

// Who else has the tool is told at once, and pressing does nothing; a late browser has what was felt.
async function watches() {
  const phone = await open(browser, address, { viewport: { width: 390, height: 780 }, colorScheme: 'dark', hasTouch: true, isMobile: true }, faults);
  assert.ok((await drawn(phone)) > 0.03, 'a body is drawn on a phone');
  await until(phone, () => softsim.plots.histories.has(0));
  const [told, age] = await phone.evaluate(() => {
    const { samples, last } = softsim.plots.histories.get(0);
    return [last - samples[0][0], performance.now() / 1000];
  });
  assert.ok(told > age || age > 8, `${told} s of forces are told to a page of ${age} s`);
  const width = await phone.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(width <= 390, `the page is ${width} wide on a phone of 390`);
  await hidden(phone, 'who');
  await page.bringToFront();
  await press(page, [x, y], () => document.getElementById('who').textContent.startsWith('Another browser holds the tool'), phone);
  await shown(phone, 'who');
  await phone.screenshot({ path: `${pictures}/phone.png` });
  await phone.touchscreen.tap(...(await onScreen(phone, UPPER_FACE)));
  assert.equal(await phone.evaluate(() => softsim.hand.press), null, 'who watches does not press');
  await page.mouse.up();
  await hidden(phone, 'who');
  await rest(page);
  return phone;
}

await page.click('#record');
await until(page, () => document.getElementById('record').textContent === 'Stop');
await pressesWithTheMouse();
await graspsWithShift();
await forgetsShift();
await recordsTo();
await worksByKeys();
const phone = await watches();
await worksByFingers(phone);
await page.bringToFront();
await commands();
await parameters();
assert.deepEqual(faults, []);
await browser.close();
console.log('test_page: the page shows, pushes, lets go, grasps, by mouse, keys and fingers; pauses, resets, sets and records');
