// Notes and photographs of a session: the list, and what adds to it during the run or after it.

import { h, newId, put, setText } from "./dom.js";
import { when } from "./format.js";
import { get, post, query } from "./net.js";

const THUMBNAIL_PX = 240;
const PHOTOGRAPH_MB_MAX = 16;

/** Whether there is a session of the present job, and its file can be read. */
function readable({ job, plan }) {
  return job?.state !== "lost" && Boolean(plan?.session ?? job?.session);
}

/** The card of notes. `session`: its name; null: the one that is run now, or was last. */
export class Notes {
  constructor(app, session = null) {
    this.app = app;
    this.session = session;
    this.list = h("ol", { class: "notes-list" });
    this.none = h("p", { class: "muted" }, "No notes yet.");
    this.fault = h("p", { class: "fault", role: "alert" });
    this.text = h("textarea", { id: newId("note"), rows: 2, maxlength: 10000 });
    this.file = h("input", {
      type: "file",
      accept: "image/jpeg,image/png",
      "aria-label": "photograph to add",
      class: "visually-hidden",
      tabindex: -1,
      onchange: () => this.addFile(),
    });
    const button = (words, work) =>
      h("button", { type: "button", onclick: () => this.act(work) }, words);
    this.buttons = [
      button("Add note", () => this.addText()),
      h("button", { type: "button", onclick: () => this.file.click() }, "Add photograph"),
    ];
    if (session === null && app.status?.mode === "rig")
      this.buttons.push(button("Photograph now", () => this.addFrame()));
    this.element = h(
      "section",
      { class: "card notes", "aria-label": "Notes" },
      h("h2", {}, "Notes"),
      this.none,
      this.list,
      h("div", { class: "field" }, h("label", { for: this.text.id }, "new note"), this.text),
      h("div", { class: "buttons" }, this.buttons, this.file),
      this.fault,
    );
    this.element.hidden = session === null;
    const mayHaveChanged = () => this.show();
    app.control.watchers.add(mayHaveChanged);
    this.forgetControl = () => app.control.watchers.delete(mayHaveChanged);
    this.stop = app.job.watch((dirty) => this.update(dirty));
    this.read();
  }

  destroy() {
    this.stop();
    this.forgetControl();
  }

  update(dirty) {
    if (["notes", "story", "started", "job"].some((type) => dirty.has(type))) this.read();
  }

  async read() {
    const asked = (this.asked = {});
    const none = this.session === null && !readable(this.app.job);
    const found = none
      ? null
      : await get(`/api/notes?${query({ session: this.session })}`).catch(() => null);
    if (asked !== this.asked) return;
    this.element.hidden = !found?.session;
    if (!found?.session) return;
    this.name = found.session;
    put(this.list, found.notes.map((note) => this.item(note)));
    this.none.hidden = found.notes.length > 0;
    this.show();
  }

  show() {
    const why = this.app.control.why();
    for (const button of this.buttons) {
      button.disabled = Boolean(why);
      button.title = why;
    }
  }

  item(note) {
    return h(
      "li",
      {},
      h("span", { class: "notes-head" }, `${when(note.when)} \u00B7 ${note.who || "not stated"}`),
      note.text && h("p", {}, note.text),
      note.photograph && this.photograph(note),
    );
  }

  photograph(note) {
    const address = (more = {}) =>
      `/api/notes/photograph?${query({ session: this.name, identifier: note.identifier, ...more })}`;
    return h(
      "a",
      { href: address(), target: "_blank", rel: "noopener" },
      h("img", {
        src: address({ width: THUMBNAIL_PX }),
        alt: note.text || note.file_name || "photograph",
        loading: "lazy",
      }),
    );
  }

  async act(work) {
    setText(this.fault, "");
    try {
      await this.app.control.act(work);
      await this.read();
    } catch (error) {
      setText(this.fault, error.message);
    }
  }

  /** What goes with each request; without a name the server takes the operator of the session. */
  get given() {
    return { session: this.name, text: this.text.value.trim(), who: this.app.control.name };
  }

  async addText() {
    await post("/api/notes", this.given);
    this.text.value = "";
  }

  async addFrame() {
    await post("/api/notes/camera", this.given);
    this.text.value = "";
  }

  addFile() {
    const [file] = this.file.files;
    if (!file) return;
    this.act(async () => {
      if (file.size > PHOTOGRAPH_MB_MAX * 2 ** 20)
        throw new Error(`${file.name} is larger than ${PHOTOGRAPH_MB_MAX} MB; save it smaller.`);
      const about = query({ ...this.given, name: file.name });
      await post(`/api/notes/photograph?${about}`, file);
      this.text.value = "";
    }).finally(() => (this.file.value = ""));
  }
}
