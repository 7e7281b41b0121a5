// A page without a script of its own: sentences and tables that the server returns for it.

import { h, put } from "./dom.js";
import { get } from "./net.js";

/** Show what `GET /api/pages/NAME` returns. */
export function mount(place, app, asked, { name, title }) {
  const body = h("div", { role: "status" }, h("p", { class: "muted" }, "reading\u2026"));
  place.append(h("h1", {}, title), body);
  get(`/api/pages/${encodeURIComponent(name)}`)
    .then(({ sentences = [], tables = [] }) =>
      put(
        body,
        sentences.map((text) => h("p", { class: "data-sentence" }, String(text))),
        tables.map((one) => table(one)),
      ),
    )
    // what cannot be shown is told as well as what cannot be read
    .catch((error) => put(body, h("p", { class: "fault" }, error.message)));
  return {};
}

/** A card with one table; names of columns and a title are optional. */
export function table({ title = "", columns = [], rows = [] }) {
  const numeric = (at) => rows.length > 0 && rows.every((row) => typeof row[at] === "number");
  const head = columns.map((one, at) =>
    h("th", { scope: "col", class: numeric(at) ? "num" : "" }, String(one)),
  );
  const cell = (value) =>
    h("td", { class: typeof value === "number" ? "num" : "" }, String(value ?? "\u2013"));
  return h(
    "section",
    { class: "card scroll", tabindex: 0, role: "region", "aria-label": title || "table" },
    title && h("h2", {}, title),
    h(
      "table",
      {},
      columns.some(Boolean) && h("thead", {}, h("tr", {}, head)),
      h(
        "tbody",
        {},
        rows.map((row) => h("tr", {}, row.map(cell))),
      ),
    ),
  );
}
