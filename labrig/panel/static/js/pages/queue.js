// The queue: sessions that begin by themselves, one after the other.

import { h, newId, put, setText } from "../dom.js";
import { about } from "../format.js";
import { get, post } from "../net.js";

const STATES = {
  waiting: "waits",
  running: "running",
  completed: "completed",
  stopped: "not completed",
};

/** Show the queue, and what adds to it. */
export function mount(place, app) {
  const page = new QueuePage(app);
  place.append(page.element);
  page.begin().catch((error) => setText(page.fault, error.message));
  return page;
}

class QueuePage {
  constructor(app) {
    this.app = app;
    this.fault = h("p", { class: "fault", role: "alert" });
    this.state = h("p", { class: "queue-state", role: "status" });
    this.table = h("div", {
      class: "scroll",
      tabindex: 0,
      role: "region",
      "aria-label": "sessions of the queue",
    });
    this.start = this.button("Start the queue", () => post("/api/queue/start"), "main");
    this.hold = this.button("Begin no further session", () => post("/api/queue/hold"));
    this.add = new AddForm(app, (body) => this.act(() => post("/api/queue/add", body)));
    this.element = h(
      "div",
      { class: "queue" },
      h("h1", {}, "Queue"),
      h(
        "section",
        { class: "card" },
        this.state,
        this.fault,
        this.table,
        h("div", { class: "buttons" }, this.hold, this.start),
      ),
      this.add.element,
    );
    const controlled = () => this.show();
    app.control.watchers.add(controlled);
    const stop = app.job.watch((dirty) => {
      if (["queue", "job", "story", "alive"].some((kind) => dirty.has(kind))) this.show();
    });
    this.destroy = () => {
      stop();
      app.control.watchers.delete(controlled);
    };
    this.show();
  }

  async begin() {
    this.app.job.apply(await get("/api/queue"));
    await this.add.begin();
  }

  button(text, work, kind = "") {
    return h("button", { type: "button", class: kind, onclick: () => this.act(work) }, text);
  }

  async act(work) {
    setText(this.fault, "");
    try {
      this.app.job.apply(await this.app.control.act(work));
    } catch (error) {
      setText(this.fault, error.message);
    }
  }

  show() {
    const { job, control } = this.app;
    const { entries = [], going = false, text = "" } = job.queue ?? {};
    const why = control.why();
    const waiting = entries.filter((entry) => entry.state === "waiting");
    const running = entries.some((entry) => entry.state === "running");
    setText(this.state, text || sentence(going, running, waiting.length));
    this.start.hidden = going;
    this.hold.hidden = !going;
    this.start.disabled = Boolean(why) || !waiting.length || job.going;
    this.hold.disabled = this.add.button.disabled = Boolean(why);
    this.start.title = why || (job.going ? "Something is going on already." : "");
    put(this.table, entries.length ? this.tableOf(entries, waiting, why) : []);
  }

  tableOf(entries, waiting, why) {
    const head = ["session", "protocol", "sheet", "takes", "state", ""].map((name) =>
      h("th", { scope: "col" }, name || h("span", { class: "visually-hidden" }, "change")),
    );
    const rows = entries.map((entry) =>
      h(
        "tr",
        { data: { state: entry.state } },
        h("th", { scope: "row" }, entry.session),
        h("td", {}, entry.protocol),
        h("td", {}, entry.sheet),
        h("td", {}, entry.estimate_s == null ? "\u2013" : about(entry.estimate_s)),
        h("td", {}, h("strong", {}, STATES[entry.state]), entry.text ? ` \u2014 ${entry.text}` : ""),
        h("td", { class: "queue-do" }, this.buttonsOf(entry, waiting, why)),
      ),
    );
    return h("table", {}, h("thead", {}, h("tr", {}, head)), h("tbody", {}, rows));
  }

  buttonsOf(entry, waiting, why) {
    const place = waiting.indexOf(entry);
    const make = (label, text, path, body, disabled) =>
      h(
        "button",
        {
          type: "button",
          class: "small",
          "aria-label": `${label} ${entry.session}`,
          disabled: Boolean(why) || disabled,
          onclick: () => this.act(() => post(path, { id: entry.id, ...body })),
        },
        text,
      );
    const last = waiting.length - 1;
    return [
      place >= 0 && make("earlier:", "\u2191", "/api/queue/move", { by: -1 }, place === 0),
      place >= 0 && make("later:", "\u2193", "/api/queue/move", { by: 1 }, place === last),
      entry.state !== "running" && make("remove", "Remove", "/api/queue/remove", {}, false),
    ];
  }
}

function sentence(going, running, waiting) {
  const left = waiting === 1 ? "1 session waits" : `${waiting} sessions wait`;
  if (going) return `The queue continues by itself; ${left}.`;
  if (running) return `This session is the last for now; ${left}.`;
  return waiting ? `${left}. All are checked before the first begins.` : "The queue is empty.";
}

/** Which protocol, sheet and clock; the session gets a name where none is given. */
class AddForm {
  constructor(app, add) {
    this.protocol = h("select", { id: newId("protocol") });
    this.sheet = h("select", { id: newId("sheet") });
    this.session = h("input", {
      id: newId("session"),
      class: "wide",
      autocomplete: "off",
      placeholder: "a name with the day",
    });
    this.clock = h(
      "select",
      { id: newId("clock") },
      h("option", { value: "virtual" }, "virtual: as fast as it can"),
      h("option", { value: "real" }, "real time"),
    );
    this.button = h("button", { type: "button", onclick: () => add(this.body()) }, "Add");
    this.simulated = app.status?.simulated;
    this.element = h(
      "section",
      { class: "card queue-add" },
      h("h2", {}, "Add a session"),
      field("protocol", this.protocol),
      field("sheet", this.sheet),
      field("session file", this.session),
      this.simulated && field("simulated rig\u2019s clock", this.clock),
      h("div", { class: "buttons" }, this.button),
    );
  }

  async begin() {
    const { files } = await get("/api/files");
    for (const kind of ["protocol", "sheet"]) {
      const names = files.filter((file) => file.kind === kind).map((file) => file.name);
      put(
        this[kind],
        names.map((name) => h("option", { value: name }, name)),
      );
      if (names.includes(`${kind}.toml`)) this[kind].value = `${kind}.toml`;
    }
  }

  body() {
    const body = { protocol: this.protocol.value, sheet: this.sheet.value };
    if (this.session.value.trim()) body.session = this.session.value.trim();
    if (this.simulated) body.clock = this.clock.value;
    this.session.value = "";
    return body;
  }
}

function field(name, input) {
  return h("div", { class: "field" }, h("label", { for: input.id }, name), input);
}
