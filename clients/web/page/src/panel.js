// The panel: the server in plain words, live parameters, colours, recordings.
const VERDICTS = ['good', 'guarded', 'degraded', 'fault'];
const $ = (id) => document.getElementById(id);

// A slider goes by ratio where the range spans more than two decades.
function slider(low, high) {
  const isWide = low > 0 && high / low > 100;
  return {
    toShare: (v) => (isWide ? Math.log(v / low) / Math.log(high / low) : (v - low) / (high - low)),
    toValue: (s) => Number((isWide ? low * (high / low) ** s : low + s * (high - low)).toPrecision(3)),
  };
}

export class Panel {
  constructor(link, { onColour }) {
    this.link = link;
    this.controls = new Map();
    this.isPaused = false;
    this.onColour = onColour;
    $('pause').onclick = () => link.command(this.isPaused ? 'resume' : 'pause');
    $('reset').onclick = () => link.command('reset');
    $('record').onclick = () => link.send(`record ${this.isRecording ? 0 : 1}`);
    $('colour').onchange = () => this.chooseColour($('colour').value);
    this.setColours([]);
  }

  chooseColour(name) {
    const isServers = this.serverFields.includes(name);
    if (this.serverFields.length) this.link.command('set', `publish.field=${isServers ? name : 'none'}`);
    this.onColour(name);
  }

  setColours(fields) {
    const known = ['none', 'displacement', ...fields.filter((f) => f !== 'none' && f !== 'displacement')];
    if (this.known?.join() === known.join()) return;
    this.known = known;
    this.serverFields = fields.filter((f) => f !== 'none' && f !== 'displacement');
    const chosen = $('colour').value || 'none';
    $('colour').replaceChildren(...known.map((name) => new Option(name === 'none' ? 'tissue' : name, name, false, name === chosen)));
  }

  takeScene(scene) {
    $('scene-name').textContent = `${scene.name} · ${scene.model}`;
    const fields = scene.parameters.find((p) => p.path === 'publish.field');
    this.setColours(fields ? fields.unit.split('|') : []);
    const shown = scene.parameters.filter((p) => p.path !== 'publish.field');
    const box = $('parameters');
    if ([...this.controls.keys()].join() !== shown.map((p) => p.path).join()) {
      this.controls.clear();
      box.replaceChildren(...shown.map((p) => this.makeControl(p)));
    }
    for (const parameter of shown) this.controls.get(parameter.path)(parameter);
  }

  makeControl({ path, low, high, unit }) {
    const root = document.createElement('div'), label = document.createElement('label');
    const name = document.createElement('span'), shown = document.createElement('output');
    root.className = 'parameter';
    name.textContent = path;
    label.append(name, shown);
    root.append(label);
    const isChoice = unit.includes('|');
    const control = document.createElement(isChoice ? 'select' : 'input');
    control.id = label.htmlFor = `set-${path}`;
    if (isChoice) {
      control.append(...unit.split('|').map((word) => new Option(word, word)));
      control.onchange = () => this.link.command('set', `${path}=${control.value}`);
      this.controls.set(path, ({ value }) => { control.value = value; });
    } else {
      const scale = slider(low, high);
      Object.assign(control, { type: 'range', min: 0, max: 1, step: 0.001 });
      let timer = 0;
      control.oninput = () => {
        const value = scale.toValue(Number(control.value));
        shown.textContent = `${value} ${unit}`;
        clearTimeout(timer);
        timer = setTimeout(() => { timer = 0; this.link.command('set', `${path}=${value}`); }, 120);
      };
      this.controls.set(path, ({ value }) => {
        if (timer) return;
        shown.textContent = `${value} ${unit}`;
        control.disabled = Number.isNaN(Number(value));
        control.value = scale.toShare(Number(value));
      });
    }
    root.append(control);
    return root;
  }

  takeStatus(status) {
    const verdict = VERDICTS[status.verdict] ?? 'fault';
    $('verdict').dataset.verdict = verdict;
    $('verdict').textContent = verdict;
    $('reason').textContent = status.reason;
    this.isPaused = status.reason.startsWith('paused');
    $('pause').textContent = this.isPaused ? 'Resume' : 'Pause';
    $('pause').setAttribute('aria-pressed', String(this.isPaused));
    const periods = status.probe_periods.reduce((a, b) => a + b, 0), missed = status.probe_missed.reduce((a, b) => a + b, 0);
    const facts = [
      ['Simulation', `${Math.round(status.simulation_rate_hz)} steps a second`],
      ['Step', `${Math.round(status.step_us[0])} µs, at worst ${Math.round(status.step_us[2])}`],
      ['Nodes', `${status.active_nodes} of ${status.nodes} active`],
      ['Haptic loop', `late by ${Math.round(status.lateness_us[0])} µs, p99 ${Math.round(status.lateness_us[1])}`],
      ['Forces', periods ? `${periods - missed} sent, ${missed} missed` : 'no probe yet'],
      ['Energy stored', `${(1e3 * status.elastic_j).toPrecision(3)} mJ`],
      ['Memory', `${(status.bytes_in_use / 1048576).toFixed(1)} MB`],
    ];
    const box = $('facts');
    if (box.children.length !== 2 * facts.length) {
      box.replaceChildren(...facts.flatMap(() => [document.createElement('dt'), document.createElement('dd')]));
    }
    facts.forEach(([name, text], i) => {
      box.children[2 * i].textContent = name;
      box.children[2 * i + 1].textContent = text;
    });
  }

  takeSilence(isSilent) {
    if (!isSilent) return;
    $('verdict').dataset.verdict = 'none';
    $('verdict').textContent = 'silent';
    $('reason').textContent = 'No server speaks: start softsimd SCENE.yaml';
  }

  takeRecording({ is_recording: isRecording, files, fault }) {
    this.isRecording = isRecording;
    $('record').setAttribute('aria-pressed', String(isRecording));
    $('record').textContent = isRecording ? 'Stop' : 'Record';
    if (fault) $('reply').textContent = fault;
    $('recordings').replaceChildren(...files.map((file) => {
      const item = document.createElement('li'), anchor = document.createElement('a');
      anchor.href = `/recordings/${file}${location.search}`;
      anchor.download = anchor.textContent = file;
      item.append(anchor);
      return item;
    }));
  }
}
