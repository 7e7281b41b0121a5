// Title, operator and sample of the session to come, as about.toml states them until they are edited.

import { h, newId, put } from "../dom.js";
import { get } from "../net.js";

const FIELDS = [
  { key: "title", label: "title" },
  { key: "project", label: "project" },
  { key: "operator", label: "operator" },
  { key: "identity", label: "sample" },
  { key: "material", label: "material" },
  { key: "batch", label: "batch" },
  { key: "preparation", label: "preparation" },
];
const OF_SAMPLE = ["identity", "material", "batch", "preparation"];

/** The fields; `values` is null until one is edited: then what the session is to state. */
export class AboutForm {
  constructor() {
    this.touched = false;
    this.stated = {};
    this.fault = h("p", { class: "fault", role: "alert" });
    this.inputs = new Map(
      FIELDS.map(({ key }) => [
        key,
        h("input", {
          id: newId(key),
          autocomplete: "off",
          maxlength: 200,
          class: "wide",
          oninput: () => (this.touched = true),
        }),
      ]),
    );
    const rows = FIELDS.map(({ key, label }) => {
      const input = this.inputs.get(key);
      return h("div", { class: "field" }, h("label", { for: input.id }, label), input);
    });
    this.element = h(
      "section",
      { class: "card new-about" },
      h("h2", {}, "Sample and operator"),
      rows,
      h(
        "p",
        { class: "muted" },
        "From about.toml beside rig.toml. What is changed here is recorded in this session only.",
      ),
      this.fault,
    );
  }

  async begin() {
    const file = await get("/api/about").catch((error) => ({ errors: [error.message] }));
    put(this.fault, file.errors.join(" "));
    this.stated = file.values ?? {};
    const { sample = {}, people = [] } = this.stated;
    const operator = people.find((person) => (person.role ?? "operator") === "operator");
    const shown = { ...this.stated, ...sample, operator: operator?.name };
    for (const [key, input] of this.inputs) input.value = shown[key] ?? "";
    this.touched = false;
  }

  get values() {
    if (!this.touched) return null;
    const text = (key) => this.inputs.get(key).value.trim();
    const sample = { ...this.stated.sample };
    for (const key of OF_SAMPLE) sample[key] = text(key);
    const stated = { ...this.stated, title: text("title"), project: text("project") };
    stated.people = operatedBy(this.stated.people ?? [], text("operator"));
    const named = Object.values(sample).some((value) => value !== "");
    if (named) stated.sample = sample;
    else delete stated.sample;
    return stated;
  }
}

/** The people, the first operator replaced by who is named now. */
function operatedBy(people, name) {
  const isOperator = (person) => (person.role ?? "operator") === "operator";
  const first = people.findIndex(isOperator);
  if (first >= 0 && people[first].name === name) return people;
  const known = people.find((person) => person.name === name);
  const operator = { ...known, name, role: "operator" };
  const others = people.filter((person, index) => index !== first && person !== known);
  return name ? [operator, ...others] : others;
}
