// Small plots on canvases: force over time with its greatest values, force against indentation,
// step time and lateness.
import { $ } from './page.js';

const SPAN_S = 10, GAP_S = 0.3, STEPS = 240; // a minute of statuses

function begin(canvas) {
  const ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight || canvas.height / ratio;
  if (canvas.width !== Math.round(width * ratio)) {
    if (!canvas.dataset.height) canvas.dataset.height = canvas.getAttribute('height');
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(Number(canvas.dataset.height) * ratio);
    canvas.style.height = `${canvas.dataset.height}px`;
  }
  const context = canvas.getContext('2d');
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height: Number(canvas.dataset.height ?? height) };
}

const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// 1, 2 or 5 times a power of ten, at least `value`.
function round(value) {
  const power = 10 ** Math.floor(Math.log10(Math.max(value, 1e-9)));
  return [1, 2, 5, 10].map((m) => m * power).find((m) => m >= value * 0.999);
}

function frame({ context, width, height }, top, unit, bottomText) {
  context.strokeStyle = style('--line');
  context.fillStyle = style('--quiet');
  context.font = '11px system-ui, sans-serif';
  context.lineWidth = 1;
  context.beginPath();
  for (const y of [0.5, height / 2, height - 14.5]) {
    context.moveTo(0, Math.round(y) + 0.5);
    context.lineTo(width, Math.round(y) + 0.5);
  }
  context.stroke();
  context.textAlign = 'left';
  context.fillText(`${Number(top.toPrecision(3))} ${unit}`, 2, 11);
  context.textAlign = 'right';
  context.fillText(bottomText, width - 2, height - 3);
}

// Samples in parts: what was between two far apart nobody knows.
export function unbroken(samples) {
  const parts = [];
  samples.forEach((sample, i) => {
    if (i === 0 || sample[0] - samples[i - 1][0] > GAP_S) parts.push([]);
    parts[parts.length - 1].push(sample);
  });
  return parts;
}

function line({ context }, parts, colour, width = 1.5) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.lineJoin = 'round';
  context.beginPath();
  for (const points of parts) points.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
  context.stroke();
}

export class Plots {
  constructor() {
    this.canvases = { time: $('plot-time'), depth: $('plot-depth'), step: $('plot-step') };
    this.forget();
  }

  forget() {
    this.histories = new Map(); // by probe: { last, samples: [time, force, greatest, indentation] }
    this.steps = []; // [step p99 us, lateness p99 us]
  }

  takeSamples(probe, values) {
    const history = this.histories.get(probe) ?? { last: 0, samples: [] };
    this.histories.set(probe, history);
    for (let i = 0; i < values.length; i += 4) {
      if (values[i] < history.last - SPAN_S) history.samples.length = 0; // another run
      history.last = values[i];
      if (values[i] > 0) history.samples.push([values[i], values[i + 1], values[i + 2], values[i + 3]]);
    }
    while (history.samples.length && history.samples[0][0] < history.last - SPAN_S) history.samples.shift();
  }

  takeStatus(status) {
    this.steps.push([status.step_us[1] ?? 0, status.lateness_us[1] ?? 0]);
    if (this.steps.length > STEPS) this.steps.shift();
  }

  // The forces of one probe.
  draw(probe) {
    const history = this.histories.get(probe) ?? { last: 0, samples: [] };
    this.drawForces(history.samples, history.last);
    this.drawSteps();
  }

  drawForces(samples, last) {
    const force = style('--force'), top = round(Math.max(0.1, ...samples.map((s) => s[2])));
    const time = begin(this.canvases.time), depth = begin(this.canvases.depth);
    const y = (plot, value) => (plot.height - 15) * (1 - value / top) + 0.5;
    const x = (t) => time.width * (1 + (t - last) / SPAN_S);
    const parts = unbroken(samples), points = (place) => parts.map((part) => part.map(place));
    frame(time, top, 'N', 'last 10 s');
    line(time, points((s) => [x(s[0]), y(time, s[2])]), `${force}66`, 1);
    line(time, points((s) => [x(s[0]), y(time, s[1])]), force);
    const deepest = round(1e3 * Math.max(1e-4, ...samples.map((s) => s[3])));
    frame(depth, top, 'N', `${Number(deepest.toPrecision(3))} mm`);
    line(depth, points((s) => [(depth.width * Math.max(0, 1e3 * s[3])) / deepest, y(depth, s[1])]), style('--accent'));
  }

  drawSteps() {
    const step = begin(this.canvases.step), most = round(Math.max(10, ...this.steps.flat()));
    const point = (k) => (s, i) => [(step.width * i) / (STEPS - 1), (step.height - 15) * (1 - s[k] / most) + 0.5];
    frame(step, most, 'µs', 'last minute');
    line(step, [this.steps.map(point(0))], style('--accent'));
    line(step, [this.steps.map(point(1))], style('--quiet'), 1);
  }
}
