// One field for each kind of value a schema can ask for. A field has `element`, `get()` (undefined:
// not given) and `faults()`, a list of sentences; it calls `changed` when the operator has changed it.

import { h, newId, setText } from "../dom.js";
import { boundsOf, faultOfCount, faultOfNumber, nameOf, parseNumber } from "./limits.js";

/** Label, control, unit, and below them what it is for, its limits, and what is wrong. */
export function labelled(key, schema, control, { required = false } = {}) {
  const { label, unit } = nameOf(key);
  const id = newId("field");
  const [hintId, faultId] = [`${id}-hint`, `${id}-fault`];
  control.id = id;
  control.setAttribute("aria-describedby", `${hintId} ${faultId}`);
  control.dataset.key = key;
  if (required) control.setAttribute("aria-required", "true");
  const fault = h("span", { class: "field-fault", id: faultId });
  const items = schema.type === "array" ? (schema.items ?? {}) : schema;
  const each = schema.type === "array" ? "each " : "";
  const bounds = boundsOf(items, unit);
  const hint = [schema.description, bounds && `${each}${bounds}`].filter(Boolean).join("; ");
  const element = h(
    "div",
    { class: "field" },
    h("label", { for: id }, label, required && h("span", { class: "muted" }, " (needed)")),
    h(
      "span",
      { class: "field-control" },
      control,
      unit && h("span", { class: "field-unit" }, unit),
    ),
    h("span", { class: "field-hint", id: hintId }, hint),
    fault,
  );
  const show = (faults) => {
    setText(fault, faults.join(" "));
    if (faults.length) control.setAttribute("aria-invalid", "true");
    else control.removeAttribute("aria-invalid");
    return faults.map((text) => `${label}: ${text}`);
  };
  return { element, show, unit };
}

/** A number; left empty it is not given. Text, since a wheel must not turn a voltage. */
export function numberField(key, schema, value, required, changed) {
  const input = h("input", {
    inputmode: "decimal",
    autocomplete: "off",
    value: value ?? "",
    oninput: changed,
    placeholder: schema.default ?? "",
  });
  const frame = labelled(key, schema, input, { required });
  return {
    element: frame.element,
    get: () => (input.value.trim() === "" ? undefined : parseNumber(input.value)),
    faults: () => {
      if (input.value.trim() === "") return frame.show(required ? ["A value is needed."] : []);
      const fault = faultOfNumber(parseNumber(input.value), schema, frame.unit);
      return frame.show(fault ? [fault] : []);
    },
  };
}

/** Numbers with commas or blanks between them. */
export function numbersField(key, schema, value, required, changed) {
  const shown = (list) => list.join(", ");
  const input = h("input", {
    class: "wide",
    autocomplete: "off",
    value: value ? shown(value) : "",
    oninput: changed,
    placeholder: shown(schema.default ?? []),
  });
  const frame = labelled(key, schema, input, { required });
  const parse = () =>
    input.value
      .split(/[,;\s]+/)
      .filter(Boolean)
      .map(parseNumber);
  return {
    element: frame.element,
    get: () => (input.value.trim() === "" && !required ? undefined : parse()),
    faults: () => {
      const list = parse();
      if (!list.length && !required) return frame.show([]);
      const faults = list
        .map((one) => faultOfNumber(one, schema.items ?? {}, frame.unit))
        .filter(Boolean);
      return frame.show([...faults, faultOfCount(list.length, schema)].filter(Boolean).slice(0, 2));
    },
  };
}

/** One of some words; `empty` is what no choice is called, null where there must be one. */
export function choiceField(key, schema, value, options, empty, changed, required = false) {
  const select = h("select", { onchange: changed });
  if (empty !== null) select.append(h("option", { value: "" }, empty));
  options.forEach(({ name }, index) => select.append(h("option", { value: String(index) }, name)));
  const at = options.findIndex((option) => option.value === value);
  select.value = at < 0 ? (empty === null ? "0" : "") : String(at);
  const frame = labelled(key, schema, select, { required });
  return {
    element: frame.element,
    get: () => (select.value === "" ? undefined : options[Number(select.value)].value),
    faults: () => frame.show(required && select.value === "" ? ["Choose one."] : []),
  };
}

/** Yes or no. */
export function flagField(key, schema, value, changed) {
  const input = h("input", {
    type: "checkbox",
    checked: value ?? schema.default ?? false,
    onchange: changed,
  });
  const frame = labelled(key, schema, input);
  return { element: frame.element, get: () => input.checked, faults: () => frame.show([]) };
}

/** Words; with `choices` a list to choose from that allows others, too. */
export function textField(key, schema, value, required, changed, choices = []) {
  const list = choices.length ? newId("choices") : null;
  const input = h("input", { value: value ?? "", oninput: changed, autocomplete: "off", list });
  const frame = labelled(key, schema, input, { required });
  if (list)
    frame.element.append(
      h(
        "datalist",
        { id: list },
        choices.map((choice) => h("option", { value: choice })),
      ),
    );
  return {
    element: frame.element,
    get: () => (input.value === "" ? undefined : input.value),
    faults: () => frame.show(required && input.value.trim() === "" ? ["A value is needed."] : []),
  };
}
