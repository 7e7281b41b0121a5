// At what rate images come, and how old the one on the screen is, in words.

const OVER_MS = 2000;
const STALE_S = 1; // an image older than this is no live image
const REPLAY_STALE_MS = 1000;

/** Seconds as one reads them at a glance: 0.08, 1.5, 12. */
function seconds(value) {
  return value < 1 ? value.toFixed(2) : value < 10 ? value.toFixed(1) : value.toFixed(0);
}

/** Of the images drawn in the last two seconds. */
export class ImageRate {
  constructor() {
    this.drawn = [];
  }

  forget() {
    this.drawn = [];
  }

  add(now_ms) {
    this.drawn.push(now_ms);
    this.keep(now_ms);
  }

  keep(now_ms) {
    while (this.drawn.length && this.drawn[0] < now_ms - OVER_MS) this.drawn.shift();
  }

  /** Images per second; 0 when there is at most one. */
  hz(now_ms) {
    this.keep(now_ms);
    const { drawn } = this;
    if (drawn.length < 2) return 0;
    return (1000 * (drawn.length - 1)) / (drawn.at(-1) - drawn[0]);
  }

  /** What the page says; `age_s` null: the image has no time of day. */
  said(now_ms, age_s) {
    const hz = this.hz(now_ms);
    const newest = this.drawn.at(-1) ?? -Infinity;
    const stale = age_s == null ? now_ms - newest > REPLAY_STALE_MS : age_s > STALE_S;
    const old = age_s == null ? "" : `${seconds(age_s)} s old`;
    if (stale) return { text: old, stale };
    const rate = `${hz.toFixed(hz < 9.95 ? 1 : 0)} images/s`;
    return { text: old ? `${rate}, ${old}` : rate, stale };
  }
}
