// The moment that is shown: plays, stops, jumps.

export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];

export class Clock extends EventTarget {
  constructor(duration) {
    super();
    this.duration = duration;
    this.t = 0;
    this.speed = 1;
    this.playing = false;
    this.last = 0;
  }

  seek(t) {
    this.t = Math.min(Math.max(t, 0), this.duration);
    this.dispatchEvent(new Event('moved'));
  }

  play() {
    if (this.playing) return;
    if (this.t >= this.duration) this.t = 0;
    this.playing = true;
    this.last = performance.now();
    this.dispatchEvent(new Event('changed'));
    requestAnimationFrame((now) => this.tick(now));
  }

  pause() {
    if (!this.playing) return;
    this.playing = false;
    this.dispatchEvent(new Event('changed'));
    this.dispatchEvent(new Event('moved'));
  }

  toggle() {
    if (this.playing) this.pause(); else this.play();
  }

  tick(now) {
    if (!this.playing) return;
    const passed = Math.max(now - this.last, 0) / 1000;
    this.last = now;
    // A tab that slept must not leap over what was to be seen.
    this.seek(this.t + Math.min(passed, 0.25) * this.speed);
    if (this.t >= this.duration) this.pause();
    else requestAnimationFrame((next) => this.tick(next));
  }

  setSpeed(speed) {
    this.speed = speed;
    this.dispatchEvent(new Event('changed'));
  }

  slower() {
    this.setSpeed(SPEEDS[Math.max(SPEEDS.indexOf(this.speed) - 1, 0)]);
  }

  faster() {
    this.setSpeed(SPEEDS[Math.min(SPEEDS.indexOf(this.speed) + 1, SPEEDS.length - 1)]);
  }
}
