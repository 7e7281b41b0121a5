// Two sessions side by side: what they are, their mean forces, and both played together.

import { shapeFor } from "../chart/draw.js";
import { h, put, setText } from "../dom.js";
import { number, plain, shapeOf, volts } from "../format.js";
import { Picture } from "../live/picture.js";
import { Strips } from "../live/strips.js";
import { get, query } from "../net.js";
import { Player, Transport } from "../player.js";
import { Chart } from "../plot.js";
import { factsOf } from "./session.js";

const COLOURS = { 1: "--plus", "-1": "--minus", 0: "--zero" };

/** Compare the sessions `a` and `b` of the address. */
export function mount(place, app, asked) {
  const [a, b] = [asked.get("a"), asked.get("b")];
  const tables = h("div", { class: "compare-tables" }, h("p", { class: "muted" }, "reading\u2026"));
  const players = [new Player(a), new Player(b)];
  const transport = new Transport(players);
  const charts = [];
  const sides = players.map((player, index) => side(player, index ? "B" : "A"));
  place.append(
    h("h1", {}, "A ", link(a), " beside B ", link(b)),
    tables,
    transport.element,
    h(
      "div",
      { class: "compare-live" },
      sides.map((one) => one.element),
    ),
  );
  get(`/api/library/compare?${query({ a, b })}`).then(
    (found) => put(tables, facts(found), forces(found, charts)),
    (error) => put(tables, h("p", { class: "fault" }, error.message)),
  );
  return {
    players,
    destroy() {
      transport.destroy();
      for (const one of [...sides, ...players, ...charts]) one.destroy();
    },
  };
}

function link(name) {
  return h("a", { href: `#/session?${query({ name })}` }, name);
}

function side(player, letter) {
  const [picture, strips] = [new Picture(player.job), new Strips(player.job)];
  const head = h("h2", {}, `${letter} \u00B7 ${player.session} `, h("span", { class: "muted" }));
  const stop = player.job.watch((dirty) => {
    picture.update(dirty);
    strips.update(dirty);
    const run = player.job.planned(player.job.now_run);
    setText(
      head.lastChild,
      run
        ? `run ${run.run + 1}, ${run.configuration}${run.position_mm == null ? ", free" : `, ${plain(run.position_mm)} mm`}`
        : "",
    );
  });
  return {
    element: h("div", { class: "compare-side" }, head, picture.element, strips.element),
    destroy() {
      stop();
      picture.destroy();
      strips.destroy();
    },
  };
}

function facts({ a, b }) {
  const [of_a, of_b] = [new Map(factsOf(a)), new Map(factsOf(b))];
  const names = [...new Set([...of_a.keys(), ...of_b.keys()])];
  const rows = names.map((name) =>
    h(
      "tr",
      {},
      h("th", { scope: "row" }, name),
      h("td", {}, of_a.get(name) ?? "\u2013"),
      h("td", {}, of_b.get(name) ?? "\u2013"),
    ),
  );
  const head = h(
    "tr",
    {},
    h("th", { scope: "col" }, "what"),
    h("th", { scope: "col" }, `A ${a.name}`),
    h("th", { scope: "col" }, `B ${b.name}`),
  );
  return h(
    "section",
    { class: "card scroll", tabindex: 0, role: "region", "aria-label": "both sessions" },
    h("table", {}, h("thead", {}, head), h("tbody", {}, rows)),
  );
}

function forces({ rows }, charts) {
  const configurations = [...new Set(rows.map((row) => row.configuration))];
  const drawn = configurations.map((name) =>
    chart(
      name,
      rows.filter((row) => row.configuration === name),
    ),
  );
  charts.push(...drawn.map((one) => one.chart));
  return h(
    "section",
    { class: "card" },
    h(
      "h2",
      {},
      "Mean force over position ",
      h("span", { class: "muted" }, "filled A, hollow B; bars: scatter of one reading"),
    ),
    h(
      "div",
      { class: "plots" },
      drawn.map((one) => one.element),
    ),
    h(
      "div",
      { class: "scroll compare-forces", tabindex: 0, role: "region", "aria-label": "mean forces" },
      table(rows),
    ),
  );
}

function chart(name, rows) {
  const levels = [...new Set(rows.map((row) => row.voltage_V))].sort((x, y) => y - x);
  const drawn = new Chart({
    label: `mean forces of the ${name} sheet`,
    x: { name: "position p", symbol: "p", unit: "mm", decimals: 2 },
    y: { name: "force F", symbol: "F", unit: "mN", decimals: 3 },
    zero: true,
    leastX: 1,
    leastY: 0.05,
  });
  const series = levels.flatMap((level) =>
    ["a", "b"].map((which) => ({
      name: `${which.toUpperCase()}, ${volts(level)}`,
      colour: COLOURS[Math.sign(level)],
      shape: shapeFor(level),
      hollow: which === "b",
      dashed: which === "b",
      line: true,
      width: 1.25,
      points: rows
        .filter((row) => row.voltage_V === level && row[which])
        .map((row) => [row.position_mm ?? 0, row[which].force_mN, row[which].scatter_mN]),
    })),
  );
  drawn.show(series);
  return { chart: drawn, element: h("figure", {}, h("figcaption", {}, name), drawn.element) };
}

function table(rows) {
  const head = ["sheet", "position", "drive", "A, mN", "B, mN", "B \u2212 A, mN", "in scatters"];
  const cells = rows.map((row) => {
    const { a, b } = row;
    const off = a && b ? b.force_mN - a.force_mN : null;
    const scatter = a && b ? Math.hypot(a.scatter_mN ?? 0, b.scatter_mN ?? 0) : 0;
    return h(
      "tr",
      {},
      h("th", { scope: "row" }, row.configuration),
      h("td", { class: "num" }, row.position_mm == null ? "free" : `${plain(row.position_mm)} mm`),
      h("td", {}, `${shapeOf(row.voltage_V)} ${volts(row.voltage_V)}`),
      [a, b].map((mean) =>
        h(
          "td",
          { class: "num" },
          mean ? `${number(mean.force_mN, 3)} \u00B1 ${number(mean.scatter_mN, 3)}` : "\u2013",
        ),
      ),
      h("td", { class: "num" }, number(off, 3)),
      h("td", { class: "num" }, scatter ? number(off / scatter, 1) : "\u2013"),
    );
  });
  return h(
    "table",
    {},
    h(
      "thead",
      {},
      h(
        "tr",
        {},
        head.map((one, index) =>
          h("th", { scope: "col", class: index > 2 || index === 1 ? "num" : "" }, one),
        ),
      ),
    ),
    h("tbody", {}, cells),
  );
}
