// The server's clock as a page knows it: from pings, of which the quickest is believed.

const KEEP = 20; // pings; the clocks of page and server drift apart slowly
const DRIFT_S = 0.05; // by which they may have done so over all pings that are kept

/** Time of day in s, on this computer. */
function here_s() {
  return (performance.timeOrigin + performance.now()) / 1000;
}

/** Whether both may be of the same clocks; else one of these was set in between. */
function agree(a, b) {
  return Math.abs(a.offset_s - b.offset_s) <= (a.trip_s + b.trip_s) / 2 + DRIFT_S;
}

/** What the server's clock shows, within half the quickest round trip. */
export class ServerClock {
  constructor() {
    this.pings = []; // { trip_s, offset_s }
  }

  /** What a ping carries. */
  stamp() {
    return here_s();
  }

  /** A pong: `at` is the ping's stamp, `wall_s` the server's time in between. */
  heard({ at, wall_s }) {
    if (at == null || wall_s == null) return;
    const now = here_s();
    const newest = { trip_s: now - at, offset_s: wall_s - (at + now) / 2 };
    this.pings = this.pings.filter((ping) => agree(ping, newest));
    this.pings.push(newest);
    if (this.pings.length > KEEP) this.pings.shift();
    const quickest = this.pings.reduce((a, b) => (b.trip_s < a.trip_s ? b : a));
    this.offset_s = quickest.offset_s; // wrong by half its trip at most
  }

  /** The server's time of day in s; null before the first pong. */
  now_s() {
    return this.offset_s == null ? null : here_s() + this.offset_s;
  }
}
