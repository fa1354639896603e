// The force that is felt, as a number, a plot and a tone. Forces are kept from the first on, also before
// there is a body or a tool to show them at.
import { $ } from './page.js';

const PLOT_MS = 50;

export class Readings {
  constructor(hand, tools, plots, sound) {
    Object.assign(this, { hand, tools, plots, sound, newest: new Map(), probe: null, force: 0, maxForce: 8, plotted: 0 });
    this.forget();
  }

  forget() {
    this.newest.clear();
    this.plots.forget();
    this.tools.forget();
    this.probe = null;
    this.show();
  }

  takeScene({ tools, parameters }) {
    const limit = parameters.find((p) => p.path === 'haptic.max_force_n');
    if (limit) this.maxForce = Number(limit.value);
    if (!this.tools.describe(tools)) return;
    this.hand.cancel();
    for (const force of this.newest.values()) this.tools.take(force);
  }

  take(force) {
    this.newest.set(force.probe, force);
    this.plots.takeSamples(force.probe, force.samples);
    this.tools.take(force);
  }

  // Of the hand's own tool while it is there, else of the first that moves, else of the last one.
  choose() {
    const own = this.hand.tool?.isStill() === false ? this.hand.tool : this.tools.moved();
    this.probe = own?.description.probe ?? this.probe ?? this.newest.keys().next().value ?? null;
    return own !== null;
  }

  share() {
    return Math.min(1, this.force / this.maxForce);
  }

  show() {
    const state = this.choose() ? this.newest.get(this.probe) : null;
    this.force = state ? Math.hypot(...state.force) : 0;
    $('force-now').textContent = state ? `${this.force.toFixed(2)} N` : '–';
    $('depth-now').textContent = state ? `${(1e3 * Math.max(0, state.indentation)).toFixed(1)} mm` : '–';
    this.sound.set(this.share());
  }

  draw(now) {
    this.show();
    if (now - this.plotted < PLOT_MS) return;
    this.plots.draw(this.probe);
    this.plotted = now;
  }
}
