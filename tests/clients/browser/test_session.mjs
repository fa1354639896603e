// SPDX-License-Identifier: BSD-3-Clause
// SPDX-FileCopyrightText: 2026 the softsim authors
//
// The page while servers come and go, and beside another browser: what it shows is what is.
//   node test_session.mjs PAGE_FOLDER BIN_DIR SCENE_FOLDER WORK_FOLDER PICTURE_FOLDER
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { blank, drawn, launch, onScreen, open, press, rest, until } from './chromium.mjs';

const [pageFolder, bin, scenes, work, pictures] = process.argv.slice(2);
const UPPER_FACE = [0, 0.006, 0.022]; // of the kidney
const running = new Set();
process.on('exit', () => running.forEach((child) => child.kill('SIGKILL')));

function run(program, ...args) {
  const child = spawn(`${bin}/${program}`, args);
  running.add(child);
  child.gone = new Promise((done) => { child.on('exit', () => { running.delete(child); done(); }); });
  return child;
}
// Starts a program; resolves when it says `said`, to it and the match.
function start(said, program, ...args) {
  const child = run(program, ...args);
  return new Promise((done, fail) => {
    let text = '';
    const take = (data) => {
      text += data;
      const match = text.match(said);
      if (match) done({ child, match });
    };
    child.stdout.on('data', take);
    child.stderr.on('data', take);
    child.gone.then(() => fail(new Error(`${program} ended: ${text}`)));
  });
}
const serve = async (scene) => (await start(/softsimd: ready/, 'softsimd', scene)).child;
async function kill(child) {
  child.kill('SIGKILL');
  await child.gone;
}

let { child: web, match } = await start(/open (http:\S+) in a browser/, 'softsim-web', '--port', '0');
const address = match[1];
const browser = await launch(pageFolder);
const faults = [];
const kind = (page, wanted) => until(page, (name) => document.body.dataset.session === name, wanted);
const drawnAnew = async (page) => until(page, (before) => softsim.view.frames > before + 1, await page.evaluate(() => softsim.view.frames));
const text = (page, id) => page.textContent(`#${id}`);
const kidney = `${scenes}/kidney.yaml`;

// Before there is a server the page says so, and how to start one.
const page = await blank(browser, { viewport: { width: 1000, height: 640 } });
page.on('pageerror', (error) => faults.push(error.message));
await page.goto(address);
await kind(page, 'silent');
assert.equal(await text(page, 'banner-head'), 'No server yet');
assert.match(await text(page, 'banner-todo'), /^softsimd .*\.yaml$/);
await page.screenshot({ path: `${pictures}/no-server.png` });
let server = await serve(kidney);
await kind(page, 'live');
await until(page, () => softsim.tools.of.size > 0);
assert.equal(await page.isVisible('#banner'), false);

// A browser that cannot draw says so.
const blind = await blank(browser);
await blind.addInitScript(() => { HTMLCanvasElement.prototype.getContext = () => null; });
await blind.goto(address);
await until(blind, () => document.getElementById('banner-text').textContent.includes('WebGL 2'));
await blind.close();

// A server that dies under the hand: nothing of it stays as if it were live.
const [x, y] = await onScreen(page, UPPER_FACE);
await press(page, [x, y], () => softsim.readings.force > 0.2 && Math.max(...softsim.body.count) > 20);
await kill(server);
await kind(page, 'silent');
assert.equal(await page.title(), 'softsim: no server');
assert.equal(await text(page, 'force-now'), '–');
assert.equal(await text(page, 'verdict'), 'no server');
assert.equal(await text(page, 'banner-head'), 'The server has stopped');
assert.equal(await text(page, 'banner-todo'), `softsimd ${kidney}`);
assert.equal(await page.evaluate(() => softsim.plots.histories.size), 0);
assert.equal(await page.isDisabled('#pause'), true);
await page.screenshot({ path: `${pictures}/server-gone.png` });
// Dented, or at rest again where the hand was let go of before that.
assert.ok(await page.evaluate(() => softsim.body.isPresent && softsim.body.visible), 'the last that was seen');
await page.mouse.up();

// Started again with the same mesh: the old dent is not the new server's.
server = await serve(kidney);
await kind(page, 'live');
await rest(page);
await kill(server);

// Another body of as many nodes, twice as large, is shown whole.
const distance = () => page.evaluate(() => softsim.view.camera.position.distanceTo(softsim.view.orbit.target));
const before = await distance();
const mesh = readFileSync(`${scenes}/kidney.obj`, 'utf8').replace(/^v (.*)$/gm, (_, place) => `v ${place.trim().split(/\s+/).map((c) => 2 * Number(c)).join(' ')}`);
writeFileSync(`${work}/large.obj`, mesh);
writeFileSync(`${work}/large.yaml`, readFileSync(kidney, 'utf8').replace('kidney.obj', 'large.obj').replace('[0, -0.017, 0], radius_m: 0.015', '[0, -0.034, 0], radius_m: 0.03'));
server = await serve(`${work}/large.yaml`);
await until(page, () => document.getElementById('scene-name').textContent.startsWith('large.yaml'));
await until(page, (least) => softsim.view.camera.position.distanceTo(softsim.view.orbit.target) > least, 1.9 * before);
await kill(server);

// Two browsers show the field that the server publishes, whoever asked for it; a new server's too.
server = await serve(kidney);
const other = await open(browser, address, {}, faults);
await until(page, () => document.getElementById('scene-name').textContent.startsWith('kidney.yaml'));
const shows = async (name, isLegend) => {
  for (const each of [page, other]) {
    await each.bringToFront();
    await until(each, ([field, wanted]) => document.getElementById('colour').value === field && softsim.body.colouring === field &&
      document.getElementById('legend').hidden !== wanted, [name, isLegend]);
  }
};
await shows('none', false);
await page.selectOption('#colour', 'potential');
await shows('potential', true);
await other.selectOption('#colour', 'none');
await shows('none', false);
await page.selectOption('#colour', 'potential');
await shows('potential', true);
await kill(server);
server = await serve(kidney);
await shows('none', false);
await other.close();

// A pause is told and undone whatever else the verdict's reason says.
await page.bringToFront();
await page.locator('[id="number-publish.max_bytes_per_s"]').fill('10000');
await page.locator('[id="number-publish.max_bytes_per_s"]').press('Enter');
await until(page, () => document.getElementById('reason').textContent.includes('max_bytes_per_s'));
await page.click('#pause');
await until(page, () => document.getElementById('pause').textContent === 'Resume' && !document.getElementById('paused').hidden &&
  document.getElementById('reason').textContent.includes('max_bytes_per_s'));
await page.screenshot({ path: `${pictures}/paused.png` });
await page.click('#pause');
await until(page, () => document.getElementById('pause').textContent === 'Pause' && document.getElementById('paused').hidden);

// A tool that another program moves is not to be had, and that is told.
await kill(server);
writeFileSync(`${work}/one.yaml`, readFileSync(kidney, 'utf8').replace('mesh: kidney.obj', `mesh: ${scenes}/kidney.obj`).replace(/.*probe: 1.*\n/, ''));
server = await serve(`${work}/one.yaml`);
await until(page, () => document.body.dataset.session === 'live' && document.getElementById('who').hidden && softsim.tools.of.size === 1);
const bridge = run('softsim-bridge', '--device', 'sim', '--script', 'slide', '--offset-m', '0,0.006,0.0273');
await until(page, () => document.getElementById('who').textContent.startsWith('Another program moves the tool'));
await kill(bridge);
await until(page, () => document.getElementById('who').hidden);

// A scene that sends no mesh: the body before it is not its own, and the banner says so.
await kill(server);
writeFileSync(`${work}/no-mesh.yaml`, readFileSync(`${work}/one.yaml`, 'utf8').replace(/publish: .*/, 'publish: {mesh_rate_hz: 0}'));
server = await serve(`${work}/no-mesh.yaml`);
await until(page, () => document.getElementById('scene-name').textContent.startsWith('no-mesh.yaml') && document.body.dataset.session === 'loading');
await until(page, () => document.getElementById('banner-head').textContent === 'The server sends no body');
assert.deepEqual(await page.evaluate(() => [softsim.body.visible, softsim.tools.visible]), [false, false]);
do { // a page that was held up takes the server for gone for a moment, and shows what it had
  await drawnAnew(page);
} while ((await drawn(page)) >= 0.001);
await page.mouse.move(x, y);
await page.mouse.down();
assert.equal(await page.evaluate(() => softsim.hand.press), null, 'there is nothing to press at');
await page.mouse.up();
await page.screenshot({ path: `${pictures}/no-mesh.png` });

// What is drawn anew leaves nothing of the old behind on the graphics card.
const memory = async () => {
  await until(page, () => softsim.view.renderer.info.memory.geometries > 0); // a page that was held up draws late
  await drawnAnew(page);
  return page.evaluate(() => ({ ...softsim.view.renderer.info.memory }));
};
await kill(server);
server = await serve(kidney);
await kind(page, 'live');
await until(page, () => softsim.tools.of.size === 2);
await rest(page);
const held = await memory();
await kill(server);
await kind(page, 'silent');
server = await serve(kidney);
await kind(page, 'live');
await rest(page);
assert.deepEqual(await memory(), held);

// What a slow disk loses is told while it does.
const recording = (lost) => page.evaluate((count) => {
  softsim.link.tell('recording', { is_recording: true, files: [], fault: '', lost: count, is_temporary: true });
  return document.getElementById('recording-note').textContent;
}, lost);
assert.equal(await recording(0), '');
assert.match(await recording(12), /12 messages are lost/);
await page.evaluate(() => softsim.link.tell('recording', { is_recording: false, files: [], fault: '', lost: 0, is_temporary: true }));

// softsim-web started again at the same port knows neither the hand nor the recordings of its last run:
// one browser held the tool, another watched, a recording was done and one under way.
await page.click('#record');
await until(page, () => document.getElementById('record').textContent === 'Stop');
await page.click('#record');
await until(page, () => document.querySelectorAll('#recordings a').length === 1);
assert.match(await text(page, 'recording-note'), /^Recordings go when softsim-web ends/); // it was given no folder
await page.click('#record');
await until(page, () => document.getElementById('record').textContent === 'Stop');
const watcher = await open(browser, address);
await page.bringToFront();
await press(page, [x, y], () => document.getElementById('who').textContent.startsWith('Another browser holds the tool'), watcher);
await kill(web);
for (const each of [page, watcher]) {
  await kind(each, 'lost');
  assert.deepEqual([await text(each, 'record'), await each.locator('#recordings a').count(), await each.evaluate(() => softsim.hand.isOthers)], ['Record', 0, false]);
}
({ child: web } = await start(/in a browser/, 'softsim-web', '--port', new URL(address).port));
for (const each of [page, watcher]) {
  await each.bringToFront();
  await kind(each, 'live');
  assert.equal(await text(each, 'record'), 'Record');
  assert.equal(await each.locator('#recordings a').count(), 0, 'no links that lead nowhere');
  await until(each, () => document.getElementById('who').hidden);
}
await page.mouse.up();
await rest(watcher);
await press(watcher, [x, y], () => softsim.readings.force > 0.2);
await watcher.mouse.up();
await rest(watcher);
await watcher.close();
await page.bringToFront();

// In a room of 32 the page that has done nothing for longest gives way, says so, and comes back when it is
// used; not before, since it would displace another.
const others = await open(browser, address);
await others.evaluate(() => { globalThis.crowd = Array.from({ length: 32 }, () => new WebSocket(new URL('/ws', location.href.replace('http', 'ws')))); });
await page.bringToFront();
await kind(page, 'displaced');
assert.equal(await text(page, 'banner-head'), 'Another page has taken this place');
await page.waitForTimeout(1500); // longer than a lost connection waits for its next try
await kind(page, 'displaced');
await page.mouse.click(2, 2);
await kind(page, 'live');
await others.close();

// Without softsim-web the page says that, not that the server is gone: also where it only falls silent,
// as one behind a network that broke.
web.kill('SIGSTOP');
await kind(page, 'lost');
assert.equal(await text(page, 'verdict'), 'not connected');
web.kill('SIGCONT');
await kind(page, 'live');
await kill(web);
await kind(page, 'lost');
assert.equal(await text(page, 'banner-head'), 'softsim-web does not answer');
assert.equal(await text(page, 'banner-todo'), `softsim-web --port ${new URL(address).port}`);
assert.equal(await page.isDisabled('#record'), true);
await page.screenshot({ path: `${pictures}/lost.png` });

assert.deepEqual(faults, []);
await browser.close();
await kill(server);
console.log('test_session: the page says who is there, starts afresh with a new server and a new softsim-web, follows its field and its pause');
