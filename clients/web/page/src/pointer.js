// Mouse, finger and pen on the canvas; the controls for depth and grasp, which a finger has in place of
// the wheel and Shift, and which tell everybody how deep the tool is to go.
import { DEPTH_SHARE } from './hand.js';
import { engineering } from './colours.js';
import { $ } from './page.js';

const PER_NOTCH = 1.15, SPAN = Math.log(DEPTH_SHARE.most / DEPTH_SHARE.least);

export const deepen = (hand, notches) => hand.setDepth(hand.depthShare * PER_NOTCH ** notches);

function hearCanvas({ canvas }, hand, pointer) {
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  canvas.addEventListener('pointerdown', (event) => {
    pointer.isFinger = event.pointerType !== 'mouse';
    if (event.button !== 0 || !event.isPrimary) return;
    hand.isShift = event.shiftKey;
    if (hand.begin(event.pointerId, place(event))) canvas.setPointerCapture(event.pointerId);
  }, { capture: true }); // before the one that turns the view
  canvas.addEventListener('pointermove', (event) => {
    if (hand.press?.owner === event.pointerId) hand.isShift = event.shiftKey;
    hand.move(event.pointerId, place(event));
  });
  for (const kind of ['pointerup', 'pointercancel']) canvas.addEventListener(kind, (event) => hand.end(event.pointerId));
  canvas.addEventListener('wheel', (event) => {
    if (!hand.isPressing()) return;
    deepen(hand, event.deltaY > 0 ? -1 : 1);
    event.preventDefault();
    event.stopImmediatePropagation();
  }, { capture: true, passive: false });
}

// A second finger, while the first presses, makes neither clicks nor slides of its own in browsers.
function hearControls(hand) {
  const slider = $('depth'), button = $('grasp');
  const set = (share) => hand.setDepth(DEPTH_SHARE.least * Math.exp(SPAN * Math.max(0, Math.min(1, share))));
  slider.oninput = () => set(Number(slider.value));
  button.onclick = () => hand.setGrasp(!hand.isLatched);
  const slide = (event) => {
    const box = slider.getBoundingClientRect();
    if (!event.isPrimary) set((event.clientX - box.left) / box.width);
  };
  slider.addEventListener('pointerdown', slide);
  slider.addEventListener('pointermove', slide);
  button.addEventListener('pointerdown', (event) => { if (!event.isPrimary) hand.setGrasp(!hand.isLatched); });
}

export class Pointer {
  constructor(view, hand, body) {
    Object.assign(this, { view, hand, body, isFinger: matchMedia('(hover: none)').matches });
    hearCanvas(view, hand, this);
    hearControls(hand);
    addEventListener('blur', () => { // keys let go elsewhere are not heard
      hand.isShift = false;
      hand.end(hand.press?.owner);
      hand.onChange();
    });
    document.addEventListener('visibilitychange', () => { if (document.hidden) hand.cancel(); });
    hand.onChange = () => this.show();
    this.show();
  }

  show() {
    const { hand, body, isFinger } = this, isPressing = hand.isPressing();
    this.view.orbit.enabled = !isPressing;
    $('grip').hidden = !hand.isServed || hand.isOthers || !(isPressing || isFinger);
    $('hint').hidden = !hand.isServed || hand.isOthers || isPressing;
    $('depth').value = Math.log(hand.depthShare / DEPTH_SHARE.least) / SPAN;
    $('depth-set').textContent = body.isPresent ? engineering(hand.depthShare * body.diagonal, 'm') : '';
    $('grasp').setAttribute('aria-pressed', String(hand.isLatched || (isPressing && hand.isShift)));
  }

  // A ring where the tool is aimed at, wider the more force there is; who else has the tool.
  draw(share) {
    const obstacle = this.hand.isServed ? this.hand.obstacle() : null;
    $('who').hidden = !obstacle;
    if ($('who').textContent !== (obstacle ?? '')) $('who').textContent = obstacle ?? '';
    $('ring').hidden = !this.hand.isPressing();
    if ($('ring').hidden) return;
    const [x, y] = this.hand.place;
    $('ring').style.transform = `translate(${x}px, ${y}px) scale(${1 + 2 * share})`;
  }
}
