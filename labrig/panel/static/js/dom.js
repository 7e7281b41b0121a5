// Elements in one line each: h("button", { class: "go", onclick: f }, "Go").

const PROPERTIES = new Set([
  "value",
  "checked",
  "disabled",
  "hidden",
  "open",
  "selected",
  "textContent",
]);

/** An element with attributes, listeners (`on...`), properties and children. */
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  fill(element, attributes);
  element.append(...children.flat(Infinity).filter((child) => child != null && child !== false));
  if (tag === "table") nameCells(element);
  return element;
}

/** Give each cell the name of its column: on a phone each row becomes a list of name and value. */
function nameCells(table) {
  const names = [...(table.tHead?.rows[0]?.cells ?? [])].map((one) =>
    one.textContent.replace(/ [\u25B2\u25BC]$/, ""),
  );
  for (const row of table.tBodies[0]?.rows ?? [])
    [...row.cells].forEach((cell, at) => names[at] && (cell.dataset.name = names[at]));
}

/** The same for SVG. */
export function svg(tag, attributes = {}, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  fill(element, attributes);
  element.append(...children.flat(Infinity).filter((child) => child != null && child !== false));
  return element;
}

function fill(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value == null || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "data") Object.assign(element.dataset, value);
    else if (PROPERTIES.has(name) && name in element) element[name] = value;
    else element.setAttribute(name, value === true ? "" : value);
  }
}

/** Put `children` in place of what is there. */
export function put(element, ...children) {
  element.replaceChildren(
    ...children.flat(Infinity).filter((child) => child != null && child !== false),
  );
  return element;
}

/** Change text only when it differs, so that nothing is laid out or read aloud anew for nothing. */
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

let ids = 0;
/** An identifier nobody else has. */
export function newId(stem = "n") {
  ids += 1;
  return `${stem}-${ids}`;
}

/** The colour that a CSS variable has at an element now, light or dark. */
export function colourOf(element, name) {
  const probe = element.ownerDocument.createElement("i");
  probe.style.color = `var(${name})`;
  probe.style.display = "none";
  element.append(probe);
  const colour = getComputedStyle(probe).color;
  probe.remove();
  return colour;
}
