// What the keys do, and the list of it that `?` shows. They are heard on the picture and where nothing
// else has the focus.
import { deepen } from './pointer.js';
import { $, notice } from './page.js';

const TURN = 0.1, ZOOM = 1.1, STEP_PX = 8;

export class Keys {
  constructor(view, hand, frame) {
    Object.assign(this, { view, hand });
    const click = (id) => () => $(id).click();
    const way = (x, y) => () => this.go(x, y);
    this.rows = [
      { keys: ['Enter'], shown: 'Enter', text: 'press in the middle of the view; once more lets go', act: () => this.press() },
      { keys: ['g'], shown: 'G', text: 'grasp, and release', act: () => this.grasp() },
      { keys: ['+', '='], shown: '+', text: 'deeper', act: () => deepen(hand, 1) },
      { keys: ['-'], shown: '−', text: 'less deep', act: () => deepen(hand, -1) },
      { keys: ['ArrowLeft'], shown: '←', text: 'turn the view; while a key presses, move the tool', act: way(-1, 0) },
      { keys: ['ArrowRight'], shown: '→', act: way(1, 0) },
      { keys: ['ArrowUp'], shown: '↑', act: way(0, -1) },
      { keys: ['ArrowDown'], shown: '↓', act: way(0, 1) },
      { keys: ['i'], shown: 'I', text: 'zoom in', act: () => view.zoom(ZOOM) },
      { keys: ['o'], shown: 'O', text: 'zoom out', act: () => view.zoom(1 / ZOOM) },
      { keys: ['f'], shown: 'F', text: 'the whole body again', act: frame },
      { keys: [' '], shown: 'Space', text: 'pause, resume', act: click('pause') },
      { keys: ['r'], shown: 'R', text: 'reset', act: click('reset') },
      { keys: ['e'], shown: 'E', text: 'edges', act: click('show-edges') },
      { keys: ['s'], shown: 'S', text: 'rest shape', act: click('show-ghost') },
      { keys: ['Escape'], shown: 'Esc', text: 'let go', act: () => hand.end(hand.press?.owner) },
      { keys: ['?'], shown: '?', text: 'this list', act: () => $('help').showModal() },
    ];
    this.list();
    addEventListener('keydown', (event) => this.take(event));
    addEventListener('keyup', (event) => { if (event.key === 'Shift') this.setShift(false); });
    $('help-open').onclick = () => $('help').showModal();
    $('help-close').onclick = () => $('help').close();
  }

  list() {
    let entry = null;
    for (const { shown, text } of this.rows) {
      const key = document.createElement('kbd');
      key.textContent = shown;
      if (text) {
        entry = document.createElement('dt');
        const said = document.createElement('dd');
        said.textContent = text;
        $('keys').append(entry, said);
      }
      entry.append(key);
    }
  }

  take(event) {
    if (event.key === 'Shift') this.setShift(true);
    const isOurs = event.target === this.view.canvas || event.target === document.body;
    const name = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const row = this.rows.find(({ keys }) => keys.includes(name));
    if (!row || !isOurs || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    row.act();
  }

  setShift(isDown) {
    this.hand.isShift = isDown;
    this.hand.onChange();
  }

  isMine() {
    return this.hand.isPressing() && this.hand.press.owner === 'keys';
  }

  press() {
    const { hand, view } = this;
    if (this.isMine()) {
      hand.end('keys');
      return;
    }
    const { clientWidth: width, clientHeight: height } = view.canvas;
    if (!hand.begin('keys', [width / 2, height / 2])) {
      notice(hand.obstacle() ?? 'Nothing to press in the middle of the view: turn the body with the arrows, or see all of it with F.');
    }
  }

  grasp() {
    if (!this.hand.isPressing()) notice('Press first (Enter), then grasp.');
    else this.hand.setGrasp(!this.hand.isLatched);
  }

  go(x, y) {
    if (!this.isMine()) {
      this.view.turn(TURN * x, TURN * y);
      return;
    }
    const [left, top] = this.hand.place;
    this.hand.move('keys', [left + STEP_PX * x, top + STEP_PX * y]);
  }
}
