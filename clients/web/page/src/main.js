// The page's parts, and which of them hears what: link -> session, readings, body, panel -> picture.
import { Body } from './body.js';
import { Colouring } from './colouring.js';
import { Hand } from './hand.js';
import { Keys } from './keys.js';
import { Link } from './link.js';
import { $, notice, showBanner } from './page.js';
import { Panel } from './panel.js';
import { Parameters } from './parameters.js';
import { Plots } from './plots.js';
import { Pointer } from './pointer.js';
import { Readings } from './readings.js';
import { Session } from './session.js';
import { Sound } from './sound.js';
import { Tools } from './tools.js';
import { canDraw, View } from './view.js';

if (!canDraw()) {
  showBanner('This browser cannot draw it', 'The picture needs WebGL 2: switch hardware acceleration on in its settings, or try another browser.');
  throw new Error('no WebGL 2');
}

const view = new View($('view')), body = new Body(), tools = new Tools();
const link = new Link();
const hand = new Hand(view, body, tools, link), pointer = new Pointer(view, hand, body);
const plots = new Plots(), sound = new Sound(), readings = new Readings(hand, tools, plots, sound);
const panel = new Panel(link), parameters = new Parameters(link), colouring = new Colouring(body, link);
const session = new Session();
const frame = () => body.isPresent && view.frame(body.sphere);
const keys = new Keys(view, hand, frame);
view.scene.add(body, tools);

// ---- what is heard ----

let scene = null, framed = '';

// Another body, or the same one under another name, is shown whole; else the view stays as it was turned.
function frameAnew() {
  const key = `${scene?.name} ${body.box}`;
  if (!body.isPresent || key === framed) return;
  framed = key;
  frame();
}

link.on('open', () => session.take({ isOpen: true }));
link.on('closed', ({ isDisplaced }) => {
  session.take({ isOpen: false, isDisplaced, isHeard: false, isSilent: false, hasBody: false, run: null });
  hand.takeHolder('nobody', false);
  panel.forgetRecordings();
});
link.on('silent', ({ is_silent: isSilent }) => session.take({ isSilent }));
link.on('scene', (message) => {
  scene = message;
  const rate = message.parameters.find((p) => p.path === 'publish.mesh_rate_hz');
  session.take({ isMeshOff: rate !== undefined && Number(rate.value) === 0 });
  panel.takeScene(message);
  parameters.takeScene(message.parameters);
  colouring.takeScene(message);
  readings.takeScene(message);
  frameAnew();
});
link.on('status', (message) => {
  session.takeRun(message.session);
  session.take({ isHeard: true, scene: message.status.scene });
  panel.takeStatus(message);
  plots.takeStatus(message.status);
});
link.on('topology', (topology) => {
  hand.cancel();
  body.setTopology(topology);
  session.take({ hasBody: true });
  showParts();
  frameAnew();
  hand.onChange();
});
link.on('delta', (delta) => body.takeDelta(delta));
link.on('field', (field) => body.takeField(field));
link.on('force', (force) => readings.take(force));
link.on('recording', (recording) => panel.takeRecording(recording));
link.on('reply', ({ code, text }) => {
  $('reply').textContent = text;
  if (code === 0) return;
  notice(text);
  parameters.show();
  colouring.show();
});
link.on('hand', ({ holder, refused, probe, devices }) => {
  hand.takeHolder(holder, refused);
  panel.takeHand({ probe, devices });
  if (refused) notice('Another device moves this tool: it belongs to whoever moves it, until half a second of stillness.');
});
session.onChange = (kind) => {
  hand.isServed = kind === 'live';
  link.isExpecting = hand.isServed || kind === 'loading';
  body.visible = tools.visible = kind !== 'loading'; // another's
  hand.onChange();
  if (kind !== 'live') hand.cancel();
  if (kind !== 'lost' && kind !== 'silent') return;
  readings.forget();
  panel.forget(kind === 'lost' ? 'not connected' : 'no server');
};

// ---- what is shown ----

function showParts() {
  if (!body.isPresent) return;
  body.edges.visible = $('show-edges').checked;
  body.ghost.visible = $('show-ghost').checked;
  body.fixed.visible = $('show-fixed').checked;
}
$('frame').onclick = frame;
for (const id of ['show-edges', 'show-ghost', 'show-fixed']) $(id).onchange = showParts;
$('sound').onchange = () => sound.toggle($('sound').checked);

view.renderer.setAnimationLoop((now) => {
  hand.update();
  const range = body.update();
  if (range !== undefined) colouring.showLegend(range);
  if (body.isPresent) tools.update({ diagonal: body.diagonal, maxForce: readings.maxForce, isForceShown: $('show-force').checked });
  readings.draw(now);
  pointer.draw(readings.share());
  view.draw();
});

// For tests and the curious: what is drawn, in numbers.
window.softsim = { body, colouring, hand, keys, link, parameters, plots, readings, session, tools, view };
