// A form made from a JSON Schema: the same limits as the file and the command line, stated once.

import { h, newId, put } from "../dom.js";
import { choiceField, flagField, numberField, numbersField, textField } from "./fields.js";
import { faultOfCount, nameOf, resolve } from "./limits.js";

/** `choices`: { key: [words] } for texts. `changed()` is called after each change. */
export class SchemaForm {
  constructor(schema, values, { choices = {}, changed = () => {} } = {}) {
    Object.assign(this, { root: schema, choices, changed: () => changed() });
    this.field = this.object("", schema, values ?? {}, true);
    this.element = h("div", { class: "schema-form" }, this.field.element);
  }

  /** What the form says now; only what is given or differs from the default. */
  get() {
    return this.field.get() ?? {};
  }

  /** All that is wrong, as sentences; marks the fields, too. */
  faults() {
    return this.field.faults();
  }

  make(key, schema, value, required) {
    const found = resolve(schema, this.root);
    if (found.variants && isSwitch(found)) return this.switched(key, found, value);
    if (found.variants) return this.variants(key, found, value, required);
    const inner = found.schema;
    if (inner.type === "object")
      return found.nullable
        ? this.optional(key, inner, value)
        : this.object(key, inner, value ?? {}, required);
    if (inner.type === "array") {
      const items = resolve(inner.items ?? {}, this.root).schema;
      if (items.type === "object") return this.list(key, inner, items, value ?? []);
      return numbersField(key, { ...inner, items }, value, required, this.changed);
    }
    if (inner.enum)
      return choiceField(
        key,
        inner,
        value ?? inner.default,
        inner.enum.map((one) => ({ name: one, value: one })),
        null,
        this.changed,
      );
    if (inner.type === "boolean")
      return found.nullable
        ? this.threeWay(key, inner, value)
        : flagField(key, inner, value, this.changed);
    if (inner.type === "number" || inner.type === "integer")
      return numberField(key, inner, value, required, this.changed);
    return textField(key, inner, value, required, this.changed, this.choices[key] ?? []);
  }

  threeWay(key, schema, value, changed = this.changed) {
    const options = [
      { name: "yes", value: true },
      { name: "no", value: false },
    ];
    return choiceField(key, schema, value ?? undefined, options, "by the mode", changed);
  }

  /** Yes, no or by the mode; with yes, a table of values that have defaults. */
  switched(key, { schema, variants }, value) {
    const given = typeof value === "object" && value !== null;
    const table = variants.find((one) => one.type === "object");
    const inner = this.object("", { ...table, description: undefined }, given ? value : {}, false);
    const body = h("div", { class: "variant", hidden: true }, inner.element);
    const choice = this.threeWay(key, schema, given ? true : value, () => {
      show();
      this.changed();
    });
    const show = () => {
      body.hidden = choice.get() !== true;
    };
    show();
    return {
      element: h("div", {}, choice.element, body),
      get: () => (choice.get() === true ? (inner.get() ?? true) : choice.get()),
      faults: () => [...choice.faults(), ...(choice.get() === true ? inner.faults() : [])],
    };
  }

  /** A group of fields. */
  object(key, schema, values, required) {
    const needed = new Set(schema.required ?? []);
    const kinds = alternativesOf(schema);
    const ordered = this.ordered(schema, needed, values).filter(([name]) => !kinds.includes(name));
    const fields = ordered.map(([name, one]) => {
      const field = this.make(name, one, values[name], needed.has(name));
      return { name, field, fixed: resolve(one, this.root).schema.default, given: name in values };
    });
    const named = schema.additionalProperties ? this.tables(schema, values) : null;
    const kind = kinds.length ? this.alternatives(kinds, schema, values) : null;
    const elements = fields.map(({ field }) => field.element);
    if (kind) elements.splice(fields.filter(({ name }) => needed.has(name)).length, 0, kind.element);
    const body = [elements, named?.element];
    const element = key
      ? h(
          "fieldset",
          { class: "group", data: { key } },
          h("legend", {}, nameOf(key).label),
          schema.description && h("p", { class: "field-hint" }, schema.description),
          body,
        )
      : h("div", { class: "group" }, body);
    return {
      element,
      get: () => {
        const found = {};
        for (const { name, field, fixed, given } of fields) {
          const value = field.get();
          if (value === undefined) continue;
          if (given || needed.has(name) || !same(value, fixed)) found[name] = value;
        }
        Object.assign(found, kind?.get(), named?.get());
        return required || Object.keys(found).length ? found : undefined;
      },
      faults: () => [
        ...fields.flatMap(({ field }) => field.faults()),
        ...(kind?.faults() ?? []),
        ...(named?.faults() ?? []),
      ],
    };
  }

  /** Exactly one of several groups: which, and below it what belongs to it. */
  alternatives(keys, schema, values) {
    const groups = keys.map((key) => {
      const inner = resolve(schema.properties[key], this.root).schema;
      const field = this.object(key, inner, values[key] ?? {}, true);
      return { key, name: nameOf(key).label, field };
    });
    const given = keys.find((key) => values[key] != null);
    const options = groups.map(({ key, name }) => ({ name, value: key }));
    const show = () => {
      for (const { key, field } of groups) field.element.hidden = key !== choice.get();
    };
    const changed = () => {
      show();
      this.changed();
    };
    const choice = choiceField("kind", {}, given, options, given ? null : "choose", changed, true);
    show();
    const chosen = () => groups.find(({ key }) => key === choice.get());
    return {
      element: h(
        "div",
        { class: "alternatives" },
        choice.element,
        groups.map(({ field }) => field.element),
      ),
      get: () => (chosen() ? { [chosen().key]: chosen().field.get() } : {}),
      faults: () => [...choice.faults(), ...(chosen()?.field.faults() ?? [])],
    };
  }

  /** What is needed first, then the groups in use, then single values, then the rest. */
  ordered(schema, needed, values) {
    const rank = ([name, one]) => {
      if (needed.has(name)) return 0;
      const found = resolve(one, this.root);
      if (found.schema.type !== "object" || found.variants) return 2;
      return found.nullable && values[name] != null ? 1 : found.nullable ? 4 : 3;
    };
    return Object.entries(schema.properties ?? {}).sort((a, b) => rank(a) - rank(b));
  }

  /** A group that may be left out. */
  optional(key, schema, value) {
    const inner = this.object("", schema, value ?? {}, true);
    const box = h("input", { type: "checkbox", checked: value != null, data: { key } });
    const body = h(
      "div",
      { hidden: value == null },
      schema.description && h("p", { class: "field-hint" }, schema.description),
      inner.element,
    );
    box.addEventListener("change", () => {
      body.hidden = !box.checked;
      this.changed();
    });
    const element = h(
      "fieldset",
      { class: "group optional", data: { key } },
      h("legend", {}, h("label", {}, box, ` ${nameOf(key).label}`)),
      body,
    );
    return {
      element,
      get: () => (box.checked ? inner.get() : undefined),
      faults: () => (box.checked ? inner.faults() : []),
    };
  }

  /** Groups one after the other, with 'add' and 'remove'. */
  list(key, schema, items, values) {
    const name = nameOf(key).label;
    const entries = [];
    const place = h("div", { class: "entries" });
    const fault = h("p", { class: "field-fault" });
    const show = () =>
      put(
        place,
        entries.map((entry) => entry.row),
      );
    const add = (value) => {
      const field = this.object("", items, value, true);
      const entry = { field };
      const drop = () => {
        entries.splice(entries.indexOf(entry), 1);
        show();
        this.changed();
      };
      entry.row = h(
        "div",
        { class: "entry", role: "group", "aria-label": name },
        field.element,
        h("button", { type: "button", class: "small", onclick: drop }, "Remove"),
      );
      entries.push(entry);
    };
    values.forEach(add);
    show();
    const more = () => {
      add({});
      show();
      this.changed();
      entries.at(-1).row.querySelector("input, select")?.focus();
    };
    const element = h(
      "fieldset",
      { class: "group list", data: { key } },
      h("legend", {}, name),
      place,
      fault,
      h("button", { type: "button", class: "small", onclick: more }, `Add to ${name}`),
    );
    return {
      element,
      get: () => entries.map(({ field }) => field.get()),
      faults: () => {
        const count = faultOfCount(entries.length, schema);
        fault.textContent = count;
        return [
          ...(count ? [`${name}: ${count}`] : []),
          ...entries.flatMap(({ field }) => field.faults()),
        ];
      },
    };
  }

  /** Tables by a name of their own, such as the configurations of a sheet. */
  tables(schema, values) {
    const inner = resolve(schema.additionalProperties, this.root).schema;
    const known = new Set(Object.keys(schema.properties ?? {}));
    const entries = [];
    const place = h("div");
    const show = () =>
      put(
        place,
        entries.map((entry) => entry.row),
      );
    const add = (name, value) => {
      const id = newId("name");
      const title = h("input", {
        id,
        value: name,
        oninput: this.changed,
        autocomplete: "off",
        "aria-required": "true",
      });
      const entry = { title, field: this.object("", inner, value, true) };
      const drop = () => {
        entries.splice(entries.indexOf(entry), 1);
        show();
        this.changed();
      };
      entry.row = h(
        "fieldset",
        { class: "group table" },
        h(
          "legend",
          {},
          h("label", { for: id }, inner.title ?? "table", " "),
          title,
          " ",
          h("button", { type: "button", class: "small", onclick: drop }, "Remove"),
        ),
        entry.field.element,
      );
      entries.push(entry);
    };
    for (const [name, value] of Object.entries(values)) if (!known.has(name)) add(name, value);
    show();
    const more = () => {
      add("", {});
      show();
      entries.at(-1).title.focus();
    };
    return {
      element: h(
        "div",
        {},
        place,
        h(
          "button",
          { type: "button", class: "small", onclick: more },
          `Add a ${(inner.title ?? "table").toLowerCase()}`,
        ),
      ),
      get: () =>
        Object.fromEntries(entries.map(({ title, field }) => [title.value.trim(), field.get()])),
      faults: () => {
        const names = entries.map(({ title }) => title.value.trim());
        const wrong = names.some(
          (name, at) => !name || names.indexOf(name) !== at || known.has(name),
        );
        return [
          ...(wrong ? ["Every table needs a name of its own."] : []),
          ...entries.flatMap(({ field }) => field.faults()),
        ];
      },
    };
  }

  /** One of several kinds of value: choose the kind, then give it. */
  variants(key, { schema, variants, nullable }, value, required) {
    const kinds = variants.map((one) => ({
      name:
        one.const !== undefined
          ? String(one.const)
          : one.type === "object"
            ? (one.title ?? "table").toLowerCase()
            : `one ${one.type}`,
      value: one,
    }));
    const start = value === undefined ? schema.default : value;
    const kind = choiceField(
      key,
      schema,
      variants.find((one) => fits(start, one)),
      kinds,
      nullable ? "none" : null,
      () => choose(),
    );
    const place = h("div", { class: "variant" });
    let inner = null;
    const build = (initial) => {
      const one = kind.get();
      inner =
        one && one.const === undefined
          ? this.make(`${key}`, { ...one, title: undefined }, initial, true)
          : null;
      put(place, inner?.element);
    };
    const choose = () => {
      build(undefined);
      this.changed();
    };
    build(start);
    return {
      element: h("div", {}, kind.element, place),
      get: () => (inner ? inner.get() : kind.get()?.const),
      faults: () => [...kind.faults(), ...(inner?.faults() ?? [])],
    };
  }
}

/** Keys of which a table has exactly one. */
function alternativesOf({ oneOf = [] }) {
  return oneOf.flatMap(({ required }) => required ?? []);
}

/** Whether a key is true, false, a table of its own, or left out. */
function isSwitch({ variants, nullable }) {
  const types = variants.map((one) => one.type).sort();
  return nullable && types.join() === "boolean,object";
}

function fits(value, schema) {
  if (value == null) return false;
  if (schema.const !== undefined) return value === schema.const;
  if (schema.type === "object") return typeof value === "object";
  return typeof value === (schema.type === "integer" ? "number" : schema.type);
}

function same(a, b) {
  return JSON.stringify(a) === JSON.stringify(b);
}
