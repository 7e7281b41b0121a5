// A recorded session on a socket of its own, and its controls.

import { h, newId, put, setText } from "./dom.js";
import { clock } from "./format.js";
import { Job } from "./job.js";
import { Socket } from "./socket.js";

const SEEK_MS = 90; // the server takes at most 20 messages in a second
const SHOWN_AFTER_S = 0.1; // a reading's image is there by then
const SPEEDS = [0.1, 1, 10, 100];

/** Plays `session`; `job` is what is to be shown. */
export class Player {
  constructor(session) {
    this.session = session;
    this.job = new Job();
    this.fault = null;
    this.socket = new Socket(`/ws/replay?session=${encodeURIComponent(session)}`, {
      message: (message) => this.receive(message),
      binary: (...frame) => this.job.applyBinary(...frame),
      alive: (is) => this.job.setAlive(is),
    });
    this.job.clock = this.socket.clock;
    this.job.onSeen = (picture) => this.socket.seen(picture);
  }

  receive(message) {
    if (message.type === "hello" || message.type === "control") return;
    if (message.type === "error") {
      this.fault = message.error;
      this.socket.close();
    }
    const { replay } = this.job;
    this.job.apply(message);
    if (message.type === "story" && !this.job.replay) this.job.replay = replay;
  }

  get at_s() {
    return this.job.replay?.at_s ?? 0;
  }

  get duration_s() {
    return this.job.replay?.duration_s ?? 0;
  }

  play() {
    this.asked_s = null;
    this.socket.send({ do: "play" });
  }

  pause() {
    this.asked_s = null;
    this.socket.send({ do: "pause" });
  }

  speed(speed) {
    this.socket.send({ do: "speed", speed });
  }

  gaps(skip) {
    this.socket.send({ do: "gaps", skip });
  }

  /** While dragging only the last place asked for goes out. */
  seek(at_s) {
    this.wanted = this.asked_s = at_s;
    if (this.timer) return;
    const send = () => {
      this.timer = null;
      if (this.wanted == null) return;
      this.socket.send({ do: "seek", at_s: this.wanted });
      this.wanted = null;
      this.timer = setTimeout(send, SEEK_MS);
    };
    send();
  }

  destroy() {
    clearTimeout(this.timer);
    this.socket.close();
  }
}

/** Readings of a player's session: { at_s, key }, equal keys where place and voltage are equal. */
function readingsOf({ job }) {
  const seen = new Map();
  return (job.replay?.marks ?? [])
    .filter((mark) => mark.kind === "reading")
    .map((mark) => {
      const run = job.planned(mark.run);
      const place = [run?.configuration, run?.position_mm, run?.purpose, mark.voltage_V].join();
      const count = seen.get(place) ?? 0; // the first there beside the first there
      seen.set(place, count + 1);
      return { at_s: mark.at_s + SHOWN_AFTER_S, key: `${place},${count}` };
    });
}

/**
 * Play, pause, speed and a slider for one or more players at once. Several stand side by side at
 * the same position and voltage, whenever that was measured in each.
 */
export class Transport {
  constructor(players) {
    this.players = players;
    this.dragging = false;
    const [slider, list] = [newId("at"), newId("marks")];
    this.play = h(
      "button",
      { type: "button", class: "main", onclick: () => this.toggle() },
      "Play",
    );
    this.time = h("output", { class: "transport-time", for: slider });
    this.slider = h("input", {
      id: slider,
      type: "range",
      min: 0,
      max: 1,
      step: 0.05,
      value: 0,
      list,
      "aria-label": "place in the session, s",
      oninput: () => this.drag(),
      onchange: () => (this.dragging = false),
    });
    this.marks = h("datalist", { id: list });
    this.ticks = h("div", { class: "transport-ticks", "aria-hidden": "true" });
    this.skip = h("input", {
      type: "checkbox",
      checked: true,
      onchange: () => players.forEach((one) => one.gaps(this.skip.checked)),
    });
    this.speeds = SPEEDS.map((speed) =>
      h(
        "button",
        {
          type: "button",
          class: "small",
          "aria-pressed": "false",
          data: { speed },
          onclick: () => players.forEach((one) => one.speed(speed)),
        },
        `${speed}\u00D7`,
      ),
    );
    this.step = [-1, 1].map((way) =>
      h(
        "button",
        { type: "button", class: "small", onclick: () => this.toReading(way) },
        way < 0 ? "\u25C0 reading" : "reading \u25B6",
      ),
    );
    this.fault = h("p", { class: "fault", role: "alert" });
    this.element = h(
      "section",
      { class: "card transport", "aria-label": "replay" },
      this.play,
      h("div", { class: "transport-speeds", role: "group", "aria-label": "speed" }, this.speeds),
      this.step,
      this.time,
      h("label", {}, this.skip, " leave out waits"),
      this.fault,
      h("div", { class: "transport-slider" }, this.slider, this.ticks, this.marks),
    );
    this.stops = players.map((one) => one.job.watch(() => this.update()));
  }

  destroy() {
    this.stops.forEach((stop) => stop());
  }

  get longest() {
    return Math.max(...this.players.map((one) => one.duration_s), 0);
  }

  get playing() {
    return this.players.some((one) => one.job.replay?.playing);
  }

  toggle() {
    const playing = this.playing;
    this.players.forEach((one) => (playing ? one.pause() : one.play()));
  }

  drag() {
    this.dragging = true;
    this.seek(Number(this.slider.value));
  }

  /** The first goes there; the others to where they measured what it measured there last. */
  seek(at_s) {
    const [first, ...others] = this.players;
    first.seek(Math.min(at_s, first.duration_s));
    const reading = readingsOf(first).findLast((one) => one.at_s <= at_s + 0.02);
    for (const one of others) {
      const same = readingsOf(one).find(({ key }) => key === reading?.key);
      if (same) one.seek(same.at_s + (at_s - reading.at_s));
      else if (!reading) one.seek(Math.min(at_s, one.duration_s));
    }
  }

  /** To the reading before or after, of those that every session has. */
  toReading(way) {
    const [first] = this.players;
    const times = this.common().map((reading) => reading.at_s);
    // where it stands still it is on its way to the last place asked for, whatever it has told
    const at = this.playing ? first.at_s : (first.asked_s ?? first.at_s);
    const found =
      way > 0 ? times.find((time) => time > at + 0.02) : times.findLast((time) => time < at - 0.02);
    if (found !== undefined) this.seek(found);
  }

  common() {
    const [mine, ...others] = this.players.map(readingsOf);
    const keys = others.map((readings) => new Set(readings.map((one) => one.key)));
    return mine.filter((one) => keys.every((each) => each.has(one.key)));
  }

  /** Several begin together at the first reading that all of them have. */
  align() {
    const ready = this.players.every((one) => one.job.replay?.marks?.length && one.job.plan);
    if (this.aligned || this.players.length < 2 || !ready) return;
    this.aligned = true;
    const [reading] = this.common();
    if (reading) this.seek(reading.at_s);
  }

  update() {
    setText(
      this.fault,
      this.players
        .map((one) => one.fault)
        .filter(Boolean)
        .join(" "),
    );
    const [first] = this.players;
    const { replay } = first.job;
    if (!replay) return;
    this.align();
    setText(this.play, this.playing ? "Pause" : "Play");
    this.slider.max = this.longest;
    if (!this.dragging) this.slider.value = replay.at_s;
    setText(this.time, `${clock(replay.at_s)} of ${clock(this.longest)}`);
    for (const button of this.speeds)
      button.setAttribute("aria-pressed", String(Number(button.dataset.speed) === replay.speed));
    if (this.marked === replay.marks) return;
    this.marked = replay.marks;
    const runs = replay.marks.filter((mark) => mark.kind === "run");
    put(
      this.marks,
      runs.map((mark) => h("option", { value: mark.at_s, label: mark.text })),
    );
    put(
      this.ticks,
      runs.map((mark) => {
        const tick = h("i", { title: mark.text });
        tick.style.left = `${(100 * mark.at_s) / Math.max(this.longest, 1e-9)}%`;
        return tick;
      }),
    );
  }
}
