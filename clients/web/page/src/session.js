// Whom the page talks to, in plain words: a banner while there is nothing live to see, with what to do.
//   connecting, lost (no softsim-web), displaced (by another page), silent (no server), loading (no body
//   of this run's yet, or none ever), live
import { $, showBanner } from './page.js';

const command = (scene) => `softsimd ${scene || 'server/scenes/kidney.yaml'}`;

const SAID = {
  connecting: () => ['Connecting', 'Looking for softsim-web.'],
  lost: ({ address }) => ['softsim-web does not answer', 'This page goes on by itself once it runs again at the same address:',
    `softsim-web --port ${new URL(address).port || 80}`],
  displaced: () => ['Another page has taken this place', 'softsim-web serves 32 at a time, and this one had done nothing for longest. Click or press a key to take a place again.'],
  silent: ({ scene }) => (scene
    ? ['The server has stopped', 'This page goes on by itself once it runs again:', command(scene)]
    : ['No server yet', 'Start one in a terminal; its body appears here by itself:', command()]),
  loading: ({ isMeshOff }) => (isMeshOff
    ? ['The server sends no body', 'Its publish.mesh_rate_hz is 0: set it to 60 in its scene.']
    : ['Receiving the body', 'A moment: the server sends it every two seconds.']),
};

export class Session {
  constructor() {
    Object.assign(this, { isOpen: null, isDisplaced: false, isSilent: false, isHeard: false, hasBody: false, scene: '', isMeshOff: false, run: null });
    this.onChange = () => {}; // of its kind
    this.show();
  }

  kind() {
    if (this.isOpen === null) return 'connecting';
    if (!this.isOpen) return this.isDisplaced ? 'displaced' : 'lost';
    if (this.isSilent || !this.isHeard) return this.isSilent ? 'silent' : 'connecting';
    return this.hasBody && !this.isMeshOff ? 'live' : 'loading';
  }

  // Another start of the server has its surface sent after its first status.
  takeRun(run) {
    this.take({ run, hasBody: this.hasBody && (this.run === null || this.run === run) });
  }

  take(what) {
    const was = this.kind();
    Object.assign(this, what);
    this.show();
    if (this.kind() !== was) this.onChange(this.kind());
  }

  show() {
    const kind = this.kind(), isLive = kind === 'live', hasServer = isLive || kind === 'loading';
    document.title = `softsim: ${{ live: 'live', silent: 'no server', lost: 'gone', displaced: 'displaced' }[kind] ?? 'waiting'}`;
    document.body.dataset.session = kind;
    for (const part of ['pause', 'reset']) $(part).disabled = !hasServer;
    $('record').disabled = !this.isOpen;
    $('settings').inert = !hasServer;
    $('banner').hidden = isLive;
    if (!isLive) showBanner(...SAID[kind]({ scene: this.scene, isMeshOff: this.isMeshOff, address: location.href }));
  }
}
