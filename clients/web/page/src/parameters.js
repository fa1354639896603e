// Live parameters of the server: a slider and a number each, with the range they may have.
import { $, notice } from './page.js';

const WAIT_MS = 120; // between the slider's last move and the command
const MESH_RATE = 'publish.mesh_rate_hz';
// The field is the colour's; a mesh is begun and ended by a restart alone.
const isSettable = ({ path, value }) => path !== 'publish.field' && !(path === MESH_RATE && Number(value) === 0);
const short = (value) => (Math.abs(value) >= 1e5 ? value.toExponential().replace('e+', 'e') : String(value));

// The slider's own range: the parameter's, or where that spans more than six decades or begins at 0 far
// below it, the hundredth to the hundredfold of the value it was first seen with. By ratio where it
// spans two decades.
export function sliderOf(low, high, value) {
  const isVast = value > 0 && (low > 0 ? high / low > 1e6 : high > 100 * value);
  const [least, most] = isVast ? [Math.max(low, value / 100), Math.min(high, value * 100)] : [low, high];
  const isWide = least > 0 && most / least > 100;
  return {
    least, most,
    toShare: (v) => (isWide ? Math.log(Math.max(v, least) / least) / Math.log(most / least) : (v - least) / (most - least)),
    toValue: (s) => Number((isWide ? least * (most / least) ** s : least + s * (most - least)).toPrecision(3)),
  };
}

function element(tag, properties, ...inside) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...inside);
  return made;
}

// "haptic.max_force_n" in words, and its unit where the server names none.
const UNITS = [['n_s_per_m', 'N s/m'], ['n_per_s', 'N/s'], ['n_per_m3', 'N/m³'], ['n_per_m', 'N/m'], ['per_s', '1/s'], ['hz', 'Hz'], ['pa', 'Pa'], ['j', 'J'], ['n', 'N'], ['m', 'm']];
export function describe(path, unit) {
  const name = path.slice(path.indexOf('.') + 1), found = UNITS.find(([end]) => name.endsWith(`_${end}`));
  const stem = found && !name.endsWith('bytes_per_s') ? name.slice(0, -found[0].length - 1) : name.replace(/_per_s$/, '');
  const words = stem.replaceAll(/[._]/g, ' ');
  return { title: words[0].toUpperCase() + words.slice(1), unit: unit || (found ? found[1] : '') };
}

// The parameters that are shown, with titles that differ, and why one has no number now. A value of its
// own name in another unit is given in that one alone; else it is given by regions or elements.
export function controlsOf(parameters) {
  const isNumber = ({ value }) => !Number.isNaN(Number(value));
  const shown = parameters.filter(isSettable).map((p) => {
    const choices = p.unit.includes('|') ? p.unit.split('|') : null;
    return { ...p, choices, ...describe(p.path, choices ? '' : p.unit) };
  });
  return shown.map((p) => {
    const namesakes = shown.filter(({ title }) => title === p.title), given = namesakes.find(isNumber);
    return {
      ...p,
      low: p.path === MESH_RATE ? Math.min(1, Number(p.value)) : p.low,
      title: namesakes.length > 1 ? `${p.title} in ${p.unit}` : p.title,
      why: given ? `given in ${given.unit}` : 'differs by region',
    };
  });
}

export class Parameters {
  constructor(link) {
    this.link = link;
    this.controls = new Map(); // by path: what takes a parameter as the server has it
  }

  takeScene(parameters) {
    const shown = controlsOf(parameters);
    const key = shown.map((p) => [p.path, p.low, p.high, p.unit, p.choices].join()).join();
    if (key !== this.key) {
      this.key = key;
      this.controls.clear();
      $('parameters').replaceChildren(...shown.map((p) => this.makeControl(p)));
    }
    this.shown = shown;
    this.show();
  }

  // As the server has them, also after it refused a change.
  show() {
    for (const parameter of this.shown ?? []) this.controls.get(parameter.path)(parameter);
  }

  set(path, value) {
    this.link.command('set', `${path}=${value}`);
  }

  makeControl(parameter) {
    return parameter.choices ? this.makeChoice(parameter) : this.makeNumber(parameter);
  }

  makeChoice({ path, title, choices }) {
    const control = element('select', { id: `set-${path}` }, ...choices.map((name) => new Option(name, name)));
    control.onchange = () => this.set(path, control.value);
    this.controls.set(path, ({ value }) => { control.value = value; });
    return element('div', { className: 'parameter', title: path }, element('label', { htmlFor: control.id }, title), control);
  }

  makeNumber({ path, title, low, high, unit, value }) {
    const scale = sliderOf(low, high, Number(value)), range = `${short(low)} to ${short(high)} ${unit}`.trim();
    const label = element('label', { htmlFor: `set-${path}` }, title);
    const number = element('input', { type: 'text', inputMode: 'decimal', id: `number-${path}` });
    const slider = element('input', { type: 'range', id: `set-${path}`, min: 0, max: 1, step: 0.001 });
    const told = element('span', { className: 'told' });
    number.setAttribute('aria-label', `${title}, ${range}`);
    const [least, most] = [scale.least, scale.most].map((end) => element('span', {}, short(end)));
    const ends = element('div', { className: 'ends' }, least, told, most);
    const tell = (isGood) => {
      const isWhole = scale.least === low && scale.most === high;
      told.textContent = isGood ? (isWhole ? '' : `allowed ${range}`) : `not within ${range}`;
      number.setAttribute('aria-invalid', String(!isGood));
    };
    const isWithin = (v) => v >= low && v <= high;
    let timer = 0;
    slider.oninput = () => {
      const wanted = scale.toValue(Number(slider.value));
      number.value = short(wanted);
      tell(true);
      clearTimeout(timer);
      timer = setTimeout(() => { timer = 0; this.set(path, wanted); }, WAIT_MS);
    };
    number.onchange = () => {
      const wanted = number.value.trim() === '' ? NaN : Number(number.value);
      tell(isWithin(wanted));
      if (isWithin(wanted)) this.set(path, wanted);
      else notice(`${title}: ${number.value || 'nothing'} is not within ${range}.`);
    };
    this.controls.set(path, ({ value: now, why }) => {
      if (timer || document.activeElement === number) return;
      const isNumber = !Number.isNaN(Number(now));
      number.value = isNumber ? short(Number(now)) : '–';
      number.disabled = !isNumber;
      slider.hidden = least.hidden = most.hidden = !isNumber;
      slider.value = scale.toShare(Number(now));
      tell(!isNumber || isWithin(Number(now)));
      if (!isNumber) told.textContent = why;
    });
    return element('div', { className: 'parameter', title: path },
      element('div', { className: 'row' }, label, element('span', { className: 'quantity' }, number, element('span', {}, unit))), slider, ends);
  }
}
