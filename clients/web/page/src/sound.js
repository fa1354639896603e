// The force as a soft tone: louder and a little higher the harder it is. Only when asked for.
export class Sound {
  constructor() {
    this.isOn = false;
  }

  toggle(isOn) {
    this.isOn = isOn;
    if (isOn && !this.context) {
      this.context = new AudioContext();
      this.tone = new OscillatorNode(this.context, { type: 'sine', frequency: 110 });
      this.gain = new GainNode(this.context, { gain: 0 });
      this.tone.connect(this.gain).connect(this.context.destination);
      this.tone.start();
    }
    this.set(0);
  }

  // `share` of the largest force, 0 to 1.
  set(share) {
    if (!this.context) return;
    const now = this.context.currentTime;
    this.gain.gain.setTargetAtTime(this.isOn ? 0.12 * share : 0, now, 0.03);
    this.tone.frequency.setTargetAtTime(110 + 220 * share, now, 0.05);
  }
}
