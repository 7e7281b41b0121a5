// The page's beginning: the bar, the socket, and whichever page the address asks for.

import { AnalysisJobs } from "./analysis.js";
import { Control, controlView } from "./control.js";
import { h, put, setText, svg } from "./dom.js";
import { Job } from "./job.js";
import { get, setClient } from "./net.js";
import { Socket } from "./socket.js";
import { outputOf, goingOf, SHAPES } from "./words.js";

const CLIENT = "labrig-client";
const at = (id) => document.getElementById(id);

const app = {
  job: new Job(),
  control: new Control(),
  analyses: new AnalysisJobs(),
  status: null,
  fault: netFault,
};
window.labrig = app; // for whoever measures the page

function netFault(text) {
  const place = at("net-said");
  place.hidden = !text;
  place.dataset.kind = "bad";
  setText(place, text ?? "");
}

// ------------------------------------------------------------------------------------ the socket

function welcome(hello) {
  // A panel that was started again: this page may only speak with the STOP process it was told of.
  if (app.status && app.status.stop_url !== hello.stop_url) return again();
  app.status = hello.status;
  sessionStorage.setItem(CLIENT, hello.client);
  setClient(hello.client);
  window.labrigStop?.learn(hello.stop_url);
  app.job.model = hello.status?.model ?? null;
  app.control.arrived(hello.client);
  if (hello.status?.control) app.control.set(hello.status.control);
  document.body.dataset.mode = hello.mode;
  showMenu(hello.status.pages);
  if (!location.hash) location.replace(firstPage(hello.status));
  app.welcomed = true;
  dispatchEvent(new Event("labrig-hello"));
}

/** Load this page again; it hears nothing more, so that it still knows what it held. */
function again() {
  app.socket.close();
  location.reload();
}

/** The address to begin with; a panel that was started with a session begins with that one. */
function firstPage({ first, pages, session }) {
  const name = first ?? pages.find((page) => page.menu)?.name ?? "";
  return `#/${name}${session ? `?session=${encodeURIComponent(session)}` : ""}`;
}

function receive(message) {
  if (message.type === "hello") welcome(message);
  else if (message.type === "control") app.control.set(message);
  else if (message.type === "analysis") app.analyses.set(message.jobs);
  else app.job.apply(message);
}

async function alive(is) {
  app.job.setAlive(is);
  if (is) return netFault(null);
  netFault(
    "The panel does not answer: what is shown may be old. The run goes on without it; STOP still works.",
  );
  await askWhyNot();
}

/** A panel that was started again may know another token. */
async function askWhyNot() {
  const status = await get("/api/status").catch((error) => error);
  if (status.status === 401)
    netFault(
      "This page is not let in: open the address that labrig panel has printed, with its token.",
    );
}

// --------------------------------------------------------------------------------------- the bar

function showBar() {
  const { job } = app;
  const output = outputOf(job);
  const lamp = at("output");
  if (lamp.dataset.state !== output.state) {
    lamp.dataset.state = output.state;
    put(
      lamp.querySelector("svg"),
      svg("path", { d: SHAPES[output.state], "fill-rule": "evenodd" }),
    );
  }
  setText(lamp.querySelector(".lamp-word"), output.word);
  setText(lamp.querySelector(".lamp-why"), output.why);
  const going = goingOf(job);
  setText(at("going").querySelector(".going-word"), going.word);
  setText(at("going").querySelector(".going-why"), going.why);
  const asks = job.prompt ? "\u25B6 " : "";
  const title = `${asks}${output.word} \u00B7 ${going.word} \u2014 labrig`;
  if (document.title !== title) document.title = title;
}

function themeButton() {
  const root = document.documentElement;
  const names = { auto: "Theme: system", light: "Theme: light", dark: "Theme: dark" };
  const order = ["auto", "light", "dark"];
  const set = (theme) => {
    root.dataset.theme = theme;
    localStorage.setItem("labrig-theme", theme);
    at("theme").textContent = names[theme];
    dispatchEvent(new Event("labrig-theme"));
  };
  const kept = localStorage.getItem("labrig-theme");
  set(order.includes(kept) ? kept : "auto");
  at("theme").addEventListener("click", () =>
    set(order[(order.indexOf(root.dataset.theme) + 1) % 3]),
  );
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () =>
    dispatchEvent(new Event("labrig-theme")),
  );
}

// ------------------------------------------------------------------------------------- the pages

const pages = new Map(); // name -> what the server lists of it
let page = null;
let turn = 0;

/** The server lists the pages: the menu's links, and where each page's module is. */
function showMenu(listed) {
  pages.clear();
  for (const one of listed) pages.set(one.name, one);
  const links = listed
    .filter((one) => one.menu)
    .map((one) => h("a", { href: `#/${one.name}` }, one.title));
  for (const old of document.querySelectorAll(".tabs a")) old.remove();
  at("tabs").prepend(...links);
  markLink();
}

function markLink() {
  const [name] = location.hash.split("?");
  for (const link of document.querySelectorAll(".tabs a")) {
    if (link.hash === name) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
}

async function show() {
  const [name, asked] = (location.hash.slice(2) || "").split("?");
  const listed = pages.get(name);
  if (!listed) return pages.size ? noPage(name) : undefined;
  const mine = ++turn;
  const module = await import(listed.script).catch((error) => error);
  if (mine !== turn) return; // another page was chosen meanwhile
  if (module instanceof Error)
    return netFault(`The page ${listed.title} cannot be loaded: ${module.message}`);
  page?.destroy?.();
  const place = at("page");
  place.className = `page page-${name}`;
  markLink();
  put(place);
  page = module.mount(place, app, new URLSearchParams(asked), listed);
  app.page = page;
}

function noPage(name) {
  turn += 1;
  page?.destroy?.();
  page = app.page = null;
  put(at("page"), h("p", { class: "card" }, `There is no page "${name}" here: choose one from the menu.`));
}

addEventListener("hashchange", () => {
  at("page").focus({ preventScroll: true });
  scrollTo(0, 0);
  show();
});
addEventListener("labrig-hello", () => {
  if (!page) show();
});

themeButton();
controlView(app.control, at("control"), netFault);
app.job.watch(showBar);
showBar();
const known = () => {
  const client = sessionStorage.getItem(CLIENT);
  return client ? `/ws?client=${encodeURIComponent(client)}` : "/ws";
};
app.socket = new Socket(known, {
  message: receive,
  binary: (...frame) => app.job.applyBinary(...frame),
  alive,
  failed: askWhyNot,
});
app.job.clock = app.socket.clock;
app.job.onSeen = (picture) => app.socket.seen(picture);
