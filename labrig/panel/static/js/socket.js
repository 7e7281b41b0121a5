// A WebSocket that comes back, tells messages from pictures and signals, and notices silence.

import { ServerClock } from "./server_clock.js";

const PING_MS = 1000;
const SILENT_MS = 3500; // nothing, not even a pong: whatever the page shows may be old
const AGAIN_MS = [200, 500, 1000, 2000];

/** Split a binary frame: its header and what follows. */
export function unpack(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  return { header, start: 4 + length };
}

/**
 * Keeps `path` open. Calls `on.message`, `on.binary(header, buffer, start)`, `on.alive(true|false)`,
 * and `on.failed()`, where there is one, each time that it could not be opened again.
 */
export class Socket {
  constructor(path, on) {
    this.path = path;
    this.on = on;
    this.tries = 0;
    this.alive = null;
    this.clock = new ServerClock();
    this.heard = performance.now();
    this.timer = setInterval(() => this.watch(), PING_MS);
    this.open();
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const path = typeof this.path === "function" ? this.path() : this.path;
    const socket = new WebSocket(`${scheme}//${location.host}${path}`);
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.heard = performance.now();
      this.ping();
    };
    socket.onmessage = (event) => this.receive(event.data);
    socket.onclose = () => {
      if (this.socket !== socket || this.closed) return;
      if (this.alive === false) this.on.failed?.();
      this.tell(false);
      const wait = AGAIN_MS[Math.min(this.tries, AGAIN_MS.length - 1)];
      this.tries += 1;
      this.again = setTimeout(() => this.open(), wait);
    };
  }

  receive(data) {
    this.heard = performance.now();
    this.tries = 0;
    this.tell(true);
    if (typeof data === "string") {
      const message = JSON.parse(data);
      if (message.type === "pong") this.clock.heard(message);
      else this.on.message(message);
    } else {
      const { header, start } = unpack(data);
      this.on.binary(header, data, start);
    }
  }

  ping() {
    this.send({ do: "ping", at: this.clock.stamp() });
  }

  /** An image is drawn: the next one may come. */
  seen(picture) {
    this.send({ do: "seen", image: picture.image });
  }

  watch() {
    this.ping();
    if (performance.now() - this.heard < SILENT_MS) return;
    this.tell(false);
    // A socket that is open but silent is given up: the next one is told the whole story.
    if (
      performance.now() - this.heard > 3 * SILENT_MS &&
      this.socket.readyState !== WebSocket.CONNECTING
    ) {
      this.heard = performance.now();
      const old = this.socket;
      clearTimeout(this.again);
      this.open();
      old.close();
    }
  }

  tell(alive) {
    if (alive === this.alive) return;
    this.alive = alive;
    this.on.alive(alive);
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  close() {
    this.closed = true;
    clearInterval(this.timer);
    clearTimeout(this.again);
    this.socket.close();
  }
}
