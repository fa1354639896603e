// The colour of the body and its legend. The server publishes one field, whichever browser asked for it
// last: what it says is what is shown. The displacement alone is reckoned here, and is a choice of this
// page's own while the server publishes nothing.
import { drawBar, engineering } from './colours.js';
import { $ } from './page.js';

const NONE = 'none', OWN = [NONE, 'displacement'];
const WORDS = { none: 'tissue', displacement: 'displacement', energy: 'energy density' };
const word = (name) => WORDS[name] ?? name;

export class Colouring {
  constructor(body, link) {
    Object.assign(this, { body, link, published: NONE, own: NONE, names: [] });
    $('colour').onchange = () => this.choose($('colour').value);
    this.takeScene({ field: NONE, parameters: [] });
  }

  shown() {
    return this.published === NONE ? this.own : this.published;
  }

  choose(name) {
    const isOwn = OWN.includes(name), wanted = isOwn ? NONE : name;
    if (isOwn) this.own = name;
    if (wanted !== this.published) this.link.command('set', `publish.field=${wanted}`);
    else this.show();
  }

  // What a scene cannot be asked for is no choice of it.
  takeScene({ field, parameters }) {
    const choices = parameters.find((p) => p.path === 'publish.field')?.unit.split('|') ?? [];
    const names = [...new Set([...OWN, ...choices, field])];
    if (names.join() !== this.names.join()) $('colour').replaceChildren(...names.map((name) => new Option(word(name), name)));
    this.names = names;
    this.published = field;
    this.show();
  }

  // Where a choice was refused it goes back to what is.
  show() {
    $('colour').value = this.shown();
    this.body.setColouring(this.shown());
  }

  showLegend(range) {
    $('legend').hidden = !range;
    if (!range) return;
    $('legend-name').textContent = word(this.body.colouring);
    $('legend-low').textContent = engineering(range.low, range.unit);
    $('legend-high').textContent = engineering(range.high, range.unit);
    drawBar($('legend-bar'), range.low, range.high);
  }
}
