// A guide: numbered steps under one another, one of them the present one.

import { h } from "./dom.js";

/** `parts`: [title, what it is for, ...elements]. `at(index)` says which one is due. */
export function steps(parts) {
  const rows = parts.map(([title, why, ...content], index) =>
    h(
      "li",
      { class: "card step" },
      h(
        "h2",
        {},
        h("span", { class: "step-number" }, String(index + 1)),
        title,
        h("span", { class: "step-now" }),
      ),
      h("p", { class: "step-why" }, why),
      content,
    ),
  );
  const at = (now) => {
    rows.forEach((row, index) => {
      row.dataset.step = index < now ? "done" : index === now ? "now" : "later";
      if (index === now) row.setAttribute("aria-current", "step");
      else row.removeAttribute("aria-current");
      row.querySelector(".step-now").textContent =
        index < now ? "done" : index === now ? "now" : "";
    });
  };
  return { element: h("ol", { class: "steps" }, rows), at };
}
