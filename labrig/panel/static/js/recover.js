// The button that makes a whole session of what a crash has left; the original stays as it is.

import { h, put } from "./dom.js";
import { post, query } from "./net.js";

/** `done()` is called when a file was written. `said` is where it is told what was saved. */
export function recoverButton(app, name, said, done = () => {}) {
  const press = async () => {
    button.disabled = true;
    put(said, `recovering ${name}\u2026`);
    try {
      const found = await app.control.act(() => post("/api/library/recover", { name }));
      tell(said, found);
      if (found.output) done();
    } catch (error) {
      put(said, h("span", { class: "fault" }, error.message));
    }
    button.disabled = false;
  };
  const button = h("button", { type: "button", class: "small", onclick: press }, "Recover");
  return button;
}

/** Where `recoverButton` tells what was saved. */
export function recoveredPlace() {
  return h("p", { class: "recovered", role: "status" });
}

function tell(said, { output, text, notes }) {
  put(
    said,
    [text, ...notes].join(" "),
    output && [" ", h("a", { href: `#/session?${query({ name: output })}` }, `Open ${output}`)],
  );
}
