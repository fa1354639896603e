import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { Body } from './body.js';
import { drawBar, engineering } from './colours.js';
import { Hand } from './hand.js';
import { Link } from './link.js';
import { Panel } from './panel.js';
import { Plots } from './plots.js';
import { Sound } from './sound.js';
import { Tool } from './tools.js';

const $ = (id) => document.getElementById(id);
const canvas = $('view');
const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
const scene = new THREE.Scene();
const camera = new THREE.PerspectiveCamera(35, 1, 0.001, 10);
const orbit = new OrbitControls(camera, canvas);
const body = new Body();
const tools = new Map();
const link = new Link();
const hand = new Hand(canvas, camera, body, tools, link);
const plots = new Plots($('plot-time'), $('plot-depth'), $('plot-step'));
const sound = new Sound();
const panel = new Panel(link, { onColour: (name) => { body.setColouring(name); } });
const state = { maxForce: 8, frames: 0, isFramed: false, force: 0 };

orbit.enableDamping = true;
scene.add(body, new THREE.HemisphereLight(0xffffff, 0x98a2ae, 1.9));
const sun = new THREE.DirectionalLight(0xffffff, 1.9), fill = new THREE.DirectionalLight(0xcfe4ff, 1.1);
camera.add(sun, fill);
sun.position.set(-0.6, 1, 0.6);
fill.position.set(1, -0.2, 0.8);
scene.add(camera);

// ---- camera ----

function frameBody() {
  if (!body.isPresent) return;
  const { center, radius } = body.sphere;
  const distance = (1.15 * radius) / Math.sin((Math.PI / 360) * camera.fov) / Math.min(1, camera.aspect);
  orbit.target.copy(center);
  camera.up.set(0, 0, 1);
  camera.position.copy(center).add(new THREE.Vector3(-0.55, -0.75, 0.62).normalize().multiplyScalar(distance));
  camera.near = distance / 200;
  camera.far = distance * 20;
  camera.updateProjectionMatrix();
  orbit.update();
}

function fit() {
  const { clientWidth: width, clientHeight: height } = canvas.parentElement;
  renderer.setPixelRatio(Math.min(devicePixelRatio || 1, 2));
  renderer.setSize(width, height, false);
  camera.aspect = width / Math.max(1, height);
  camera.updateProjectionMatrix();
}
new ResizeObserver(fit).observe(canvas.parentElement);
fit();

// ---- from the server ----

let noticeTimer = 0;
function notice(text) {
  $('notice').textContent = text;
  $('notice').hidden = false;
  clearTimeout(noticeTimer);
  noticeTimer = setTimeout(() => { $('notice').hidden = true; }, 4000);
}

link.on('topology', (topology) => {
  const wasFramed = state.isFramed && topology.nodes === body.nodes;
  body.setTopology(topology);
  if (!wasFramed) frameBody();
  state.isFramed = true;
  applyShown();
});
link.on('delta', (delta) => body.takeDelta(delta));
link.on('field', (field) => body.takeField(field));
link.on('scene', (description) => {
  panel.takeScene(description);
  const limit = description.parameters.find((p) => p.path === 'haptic.max_force_n');
  if (limit) state.maxForce = Number(limit.value);
  const key = JSON.stringify(description.tools);
  if (key === state.toolsKey) return;
  state.toolsKey = key;
  for (const tool of tools.values()) {
    scene.remove(tool);
    tool.dispose();
  }
  tools.clear();
  for (const tool of description.tools) {
    tools.set(tool.probe, new Tool(tool));
    scene.add(tools.get(tool.probe));
  }
  hand.cancel();
});
// The tool whose force is plotted: the mouse's while it is there, else the first that moves.
function felt() {
  if (hand.tool?.visible) return hand.tool;
  return [...tools.values()].find((tool) => tool.visible) ?? null;
}
link.on('force', (force) => {
  const tool = tools.get(force.probe);
  if (!tool || !body.isPresent) return;
  tool.take(force, body.diagonal, state.maxForce);
  tool.update($('show-force').checked);
  if (tool === felt()) {
    plots.takeSamples(force.samples);
    state.force = Math.hypot(...force.force);
    $('force-now').textContent = `${state.force.toFixed(2)} N`;
    $('depth-now').textContent = `${(1e3 * Math.max(0, force.indentation)).toFixed(1)} mm`;
  }
});
link.on('status', ({ status }) => {
  panel.takeStatus(status);
  plots.takeStatus(status);
});
link.on('silent', ({ is_silent: isSilent }) => panel.takeSilence(isSilent));
link.on('recording', (recording) => panel.takeRecording(recording));
link.on('reply', ({ code, text }) => {
  $('reply').textContent = text;
  if (code !== 0) notice(text);
});
link.on('hand', ({ holder, refused }) => {
  state.isOthers = holder === 'another browser';
  if (refused) notice('Another device holds this probe: it belongs to whoever moves it, until half a second of stillness.');
});
link.on('closed', () => {
  panel.takeSilence(true);
  $('reason').textContent = 'softsim-web does not answer; trying again';
});

// ---- pointer, wheel, keys ----

canvas.addEventListener('pointerdown', (event) => {
  if (event.button !== 0 || !event.isPrimary) return;
  if (hand.begin(event)) {
    orbit.enabled = false;
    canvas.setPointerCapture(event.pointerId);
    if (state.isOthers) notice('Another browser holds the probe.');
  }
}, { capture: true });
canvas.addEventListener('pointermove', (event) => hand.move(event));
for (const kind of ['pointerup', 'pointercancel']) {
  canvas.addEventListener(kind, () => {
    hand.end();
    orbit.enabled = true;
  });
}
canvas.addEventListener('wheel', (event) => {
  if (hand.wheel(event)) {
    event.preventDefault();
    event.stopImmediatePropagation();
  }
}, { capture: true, passive: false });
addEventListener('blur', () => hand.end());
document.addEventListener('visibilitychange', () => { if (document.hidden) hand.cancel(); });

function turn(across, up) {
  const offset = camera.position.clone().sub(orbit.target);
  const place = new THREE.Spherical().setFromVector3(new THREE.Vector3(offset.y, offset.z, offset.x));
  place.theta += across;
  place.phi = Math.max(0.05, Math.min(Math.PI - 0.05, place.phi + up));
  const turned = new THREE.Vector3().setFromSpherical(place);
  camera.position.copy(orbit.target).add(new THREE.Vector3(turned.z, turned.x, turned.y));
}
const click = (id) => $(id).click();
const KEYS = {
  ' ': () => click('pause'), r: () => click('reset'), f: frameBody, e: () => click('show-edges'), g: () => click('show-ghost'),
  ArrowLeft: () => turn(-0.1, 0), ArrowRight: () => turn(0.1, 0), ArrowUp: () => turn(0, -0.1), ArrowDown: () => turn(0, 0.1),
};
addEventListener('keydown', (event) => {
  if (event.key === 'Shift') hand.isShift = true;
  const act = KEYS[event.key];
  if (!act || event.ctrlKey || event.metaKey || event.altKey || (event.target !== canvas && event.target !== document.body)) return;
  event.preventDefault();
  act();
});
addEventListener('keyup', (event) => { if (event.key === 'Shift') hand.isShift = false; });

// ---- what is shown ----

function applyShown() {
  if (!body.isPresent) return;
  body.edges.visible = $('show-edges').checked;
  body.ghost.visible = $('show-ghost').checked;
  body.fixed.visible = $('show-fixed').checked;
}
for (const id of ['show-edges', 'show-ghost', 'show-fixed']) $(id).onchange = applyShown;
$('sound').onchange = () => sound.toggle($('sound').checked);

function showLegend(range) {
  $('legend').hidden = !range;
  if (!range) return;
  $('legend-name').textContent = body.colouring;
  $('legend-low').textContent = engineering(range.low, range.unit);
  $('legend-high').textContent = engineering(range.high, range.unit);
  drawBar($('legend-bar'), range.low, range.high);
}

function showCursor() {
  const isPressed = Boolean(hand.press && !hand.press.left && hand.place);
  $('cursor').hidden = !isPressed;
  if (!isPressed) return;
  const share = Math.min(1, state.force / state.maxForce);
  $('cursor').style.transform = `translate(${hand.place[0]}px, ${hand.place[1]}px) scale(${1 + 2 * share})`;
}

const dark = matchMedia('(prefers-color-scheme: dark)');
function applyTheme() {
  scene.background = new THREE.Color(dark.matches ? 0x12181e : 0xeef1f4);
}
dark.addEventListener('change', applyTheme);
applyTheme();

let plotted = 0;
renderer.setAnimationLoop((now) => {
  hand.update();
  orbit.update();
  const range = body.update();
  if (range !== undefined) showLegend(range);
  for (const tool of tools.values()) tool.update($('show-force').checked);
  const isFelt = [...tools.values()].some((tool) => tool.visible);
  if (!isFelt) state.force = 0;
  sound.set(Math.min(1, state.force / state.maxForce));
  showCursor();
  if (now - plotted > 50) {
    plots.draw();
    plotted = now;
  }
  renderer.render(scene, camera);
  ++state.frames;
  if (body.isPresent && document.title !== 'softsim: live') document.title = 'softsim: live';
});

// For tests and the curious: what is drawn, in numbers.
window.softsim = { body, camera, hand, link, orbit, plots, renderer, state, tools };
