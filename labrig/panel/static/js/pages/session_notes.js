// The notes of one session.

import { h } from "../dom.js";
import { query } from "../net.js";
import { Notes } from "../notes.js";

/** Show the notes of the session named in the address, or of the present one. */
export function mount(place, app, asked) {
  const name = asked.get("session");
  const notes = new Notes(app, name);
  place.append(
    h("h1", {}, "Notes"),
    name && h("p", {}, h("a", { href: `#/session?${query({ name })}` }, name)),
    notes.element,
  );
  return notes;
}
