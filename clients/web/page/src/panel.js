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
    this.mouse = { probe: null, isHeld: false }; // the last that a browser held
    this.forget('no server');
    this.forgetRecordings();
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
    this.showVerdict(verdict, verdict, this.isLetGo(status) ? '' : status.reason);
    this.showPaused(paused);
    const facts = factsOf(status), boxes = children($('facts'), facts.flatMap(() => ['dt', 'dd']));
    facts.flat().forEach((text, i) => { boxes[i].textContent = text; });
  }

  takeHand({ probe, devices }) {
    if (probe >= 0) this.mouse.probe = probe;
    else if (devices.includes(this.mouse.probe)) this.mouse.probe = null;
    this.mouse.isHeld = probe >= 0;
  }

  // Is all that there is to say that a browser has let go of its tool? Which is no news.
  isLetGo({ verdict, reason }) {
    return verdict === 0 && !this.mouse.isHeld && reason.startsWith(`probe ${this.mouse.probe} went silent`);
  }

  forgetRecordings() {
    this.takeRecording({ is_recording: false, files: [], fault: '', lost: 0 });
  }

  takeRecording({ is_recording: isRecording, files, fault, lost, is_temporary: isTemporary }) {
    this.isRecording = isRecording;
    $('record').setAttribute('aria-pressed', String(isRecording));
    $('record').textContent = isRecording ? 'Stop' : 'Record';
    if (fault) $('reply').textContent = fault;
    $('recording-note').textContent = [
      isRecording && lost > 0 ? `The disk is too slow: ${lost} messages are lost so far.` : '',
      isTemporary && files.length ? 'Recordings go when softsim-web ends: save what you keep, or give it --record-dir.' : '',
    ].join(' ').trim();
    $('recordings').replaceChildren(...files.map((file) => {
      const item = document.createElement('li'), anchor = document.createElement('a');
      anchor.href = `/recordings/${file}${location.search}`;
      anchor.download = anchor.textContent = file;
      item.append(anchor);
      return item;
    }));
  }
}
