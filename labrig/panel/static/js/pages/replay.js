// A recorded session, played through the same view as a run.

import { h, setText } from "../dom.js";
import { LiveView } from "../live/view.js";
import { query } from "../net.js";
import { Player, Transport } from "../player.js";
import { outputOf } from "../words.js";

/** Play the session named in the address. */
export function mount(place, app, asked) {
  const session = asked.get("session");
  const player = new Player(session);
  const transport = new Transport([player]);
  const view = new LiveView(player.job);
  const recorded = h("strong", { class: "recorded" });
  const stop = player.job.watch(() => {
    const output = outputOf({ ...player.job, job: null, alive: true });
    setText(recorded, `recorded output: ${output.word}`);
    recorded.dataset.state = output.state;
  });
  place.append(
    h(
      "div",
      { class: "runbar" },
      h("h1", {}, "Replay ", h("a", { href: `#/session?${query({ name: session })}` }, session)),
      h("span", { class: "runbar-gap" }),
      recorded,
    ),
    transport.element,
    view.element,
  );
  return {
    view,
    player,
    destroy() {
      stop();
      transport.destroy();
      view.destroy();
      player.destroy();
    },
  };
}
