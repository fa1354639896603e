// The server in plain words; pause, reset, recordings.
import { $, children } from './page.js';

const VERDICTS = ['good', 'guarded', 'degraded', 'fault'];

function factsOf(status) {
  const sum = (counts) => counts.reduce((a, b) => a + b, 0);
  const periods = sum(status.probe_periods), missed = sum(status.probe_missed);
  return [
    ['Simulation', `${Math.round(status.simulation_rate_hz)} steps a second`],
    ['Step', `${Math.round(status.step_us[0])} µs, at worst ${Math.round(status.step_us[2])}`],
    ['Nodes', `${status.nodes}, active ${status.active_nodes}`],
    ['Haptic loop', `late by ${Math.round(status.lateness_us[0])} µs, p99 ${Math.round(status.lateness_us[1])}`],
    ['Forces', periods ? `${periods - missed} sent, ${missed} missed` : 'no probe yet'],
    ['Energy stored', `${(1e3 * status.elastic_j).toPrecision(3)} mJ`],
    ['Memory', `${(status.bytes_in_use / 1048576).toFixed(1)} MB`],
  ];
}

export class Panel {
  constructor(link) {
    $('pause').onclick = () => link.command(this.isPaused ? 'resume' : 'pause');
    $('reset').onclick = () => link.command('reset');
    $('record').onclick = () => link.send(`record ${this.isRecording ? 0 : 1}`);
    this.forget('no server');
  }

  // What a server said goes with it.
  forget(why) {
    this.showPaused(false);
    this.showVerdict('none', why, '');
    $('facts').replaceChildren();
    $('reply').textContent = '';
  }

  showVerdict(verdict, text, reason) {
    $('verdict').dataset.verdict = verdict;
    $('verdict').textContent = text;
    $('reason').textContent = reason;
  }

  showPaused(isPaused) {
    this.isPaused = isPaused;
    $('pause').textContent = isPaused ? 'Resume' : 'Pause';
    $('pause').setAttribute('aria-pressed', String(isPaused));
    $('paused').hidden = !isPaused;
  }

  takeScene({ name, model }) {
    $('scene-name').textContent = `${name} · ${model}`;
  }

  takeStatus({ status, paused }) {
    const verdict = VERDICTS[status.verdict] ?? 'fault';
    this.showVerdict(verdict, verdict, status.reason);
    this.showPaused(paused);
    const facts = factsOf(status), boxes = children($('facts'), facts.flatMap(() => ['dt', 'dd']));
    facts.flat().forEach((text, i) => { boxes[i].textContent = text; });
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
