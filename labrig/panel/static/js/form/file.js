// One configuration file on the page: chosen, shown as a form, checked by the server, saved.

import { h, newId, put, setText } from "../dom.js";
import { get, post, put as send } from "../net.js";
import { SchemaForm } from "./schema.js";

const CHECK_MS = 350; // after the last key

/** `changed()` is called whenever text, errors or the file's name may have changed. */
export class FileForm {
  constructor(kind, schema, { choices = () => ({}), changed = () => {} } = {}) {
    Object.assign(this, {
      kind,
      schema,
      choices,
      changed,
      errors: [],
      text: null,
      touched: false,
      name: null,
    });
    const id = newId("file");
    this.select = h("select", { id, onchange: () => this.load(this.select.value) });
    this.place = h("div");
    this.said = h("div", { class: "file-said", role: "status" });
    this.element = h(
      "details",
      { class: "card file", open: kind === "protocol" },
      h(
        "summary",
        {},
        h("strong", {}, kind === "protocol" ? "Protocol" : "Sheet"),
        " ",
        (this.summary = h("span", { class: "muted" })),
      ),
      h("p", { class: "file-choose" }, h("label", { for: id }, "file "), this.select),
      this.said,
      this.place,
    );
  }

  /** Offer the files of this kind and show one: the one asked for, else the usual one. */
  async offer(files, asked = `${this.kind}.toml`) {
    const names = files.filter((file) => file.kind === this.kind).map((file) => file.name);
    put(
      this.select,
      names.map((name) => h("option", { value: name }, name)),
    );
    if (!names.length) {
      setText(this.said, `There is no ${this.kind} file in the rig's folder.`);
      return;
    }
    await this.load([asked, `${this.kind}.toml`].find((name) => names.includes(name)) ?? names[0]);
  }

  async load(name) {
    if (name === this.adopted?.name) return this.fill(this.adopted, true);
    const file = await get(`/api/files/${encodeURIComponent(name)}`);
    this.fill({ ...file, name }, false);
  }

  /** Offer and show a file that lies elsewhere; saved, it is one of the rig's folder. */
  adopt(file, origin) {
    const names = [...this.select.options].map((option) => option.value);
    const stem = file.name.replace(/\.toml$/, "");
    let name = file.name;
    for (let n = 2; names.includes(name); n += 1) name = `${stem}-${n}.toml`;
    this.select.append(h("option", { value: name }, name));
    this.adopted = { ...file, name, origin };
    this.fill(this.adopted, true);
  }

  fill(file, touched) {
    const { name, text } = file;
    Object.assign(this, { name, text, errors: file.errors ?? [], touched });
    this.origin = file.origin ?? "changed"; // what is said of what is not saved
    this.select.value = name;
    this.values = file.values ?? {};
    this.form = new SchemaForm(this.schema, this.values, {
      choices: this.choices(),
      changed: () => this.edited(),
    });
    put(this.place, this.form.element);
    this.tell();
    this.changed();
  }

  edited() {
    Object.assign(this, { touched: true, origin: "changed" });
    this.text = null;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.check(), CHECK_MS);
    this.tell();
    this.changed();
  }

  /** The form's own limits first, then the server, which knows the rest. */
  async check() {
    this.errors = this.form.faults();
    if (!this.errors.length) {
      const values = this.form.get();
      const asked = (this.asked = {});
      const found = await post("/api/files/check", { kind: this.kind, values }).catch((error) => ({
        ok: false,
        errors: [error.message],
      }));
      if (asked !== this.asked) return;
      this.errors = found.errors ?? [];
      this.text = found.ok ? found.text : null;
      this.values = values;
    }
    this.tell();
    this.changed();
  }

  tell() {
    setText(
      this.summary,
      `${this.name}${this.touched ? `, ${this.origin}` : ""}${this.errors.length ? ", with faults" : ""}`,
    );
    put(
      this.said,
      this.errors.map((error) => h("p", { class: "fault" }, error)),
    );
  }

  get ready() {
    return this.name !== null && this.text !== null && !this.errors.length;
  }

  /** Write what the form says, or a text that was not changed as it is; the file's name. */
  async save(name) {
    const what = this.origin === "changed" ? { values: this.form.get() } : { text: this.text };
    await send(`/api/files/${encodeURIComponent(name)}`, { kind: this.kind, ...what });
    if (this.adopted?.name === name) this.adopted = null;
    Object.assign(this, { name, touched: false });
    if (![...this.select.options].some((option) => option.value === name))
      this.select.append(h("option", { value: name }, name));
    this.select.value = name;
    this.tell();
    return name;
  }
}
