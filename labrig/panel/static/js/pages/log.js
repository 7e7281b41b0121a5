// What was done at panels, and by whom.

import { h, put } from "../dom.js";
import { when } from "../format.js";
import { get } from "../net.js";

/** Show the actions, newest first. */
export function mount(place) {
  const body = h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "actions" });
  place.append(h("h1", {}, "Log of actions"), h("section", { class: "card" }, body));
  get("/api/log?limit=500").then(
    ({ actions }) => {
      const rows = actions
        .toReversed()
        .map(({ wall, who, what }) =>
          h(
            "tr",
            {},
            h("td", { class: "one-line" }, when(wall)),
            h("td", { class: "one-line" }, who),
            h("td", {}, what),
          ),
        );
      const head = h(
        "tr",
        {},
        ["when", "who", "what"].map((name) => h("th", { scope: "col" }, name)),
      );
      put(
        body,
        rows.length
          ? h("table", {}, h("thead", {}, head), h("tbody", {}, rows))
          : h("p", { class: "muted" }, "Nothing was done yet."),
      );
    },
    (error) => put(body, h("p", { class: "fault" }, error.message)),
  );
  return {};
}
