// STOP. Loaded first, before and without any module; nothing else of the page is needed for it.
//
// It presses two addresses at once and believes whichever tells of the output: the one of the STOP
// process, which does nothing else, and the panel's own. Bodies are plain text, so that the browser
// asks nobody for permission first.
(function () {
  "use strict";
  const KEY = "labrig-stop-url";
  const PATIENCE_MS = 1000; // then the operator is told what a hand can do
  const LONGEST_MS = 12500; // the STOP process answers within 12 s
  const DOUBLE_MS = 700; // pointer down and the click after it are one press

  let stopUrl = sessionStorage.getItem(KEY);
  let pressedAt = -Infinity;

  function learn(url) {
    if (!url) return;
    stopUrl = url;
    sessionStorage.setItem(KEY, url);
  }

  function show(text, kind) {
    const place = document.getElementById("stop-said");
    if (!place) return;
    place.textContent = text;
    place.dataset.kind = kind;
    place.hidden = false;
  }

  function post(url, why) {
    return fetch(url, {
      method: "POST",
      credentials: "include",
      keepalive: true,
      cache: "no-store",
      body: JSON.stringify({ why: why, name: localStorage.getItem("labrig-operator") || "" }),
      signal: AbortSignal.timeout(LONGEST_MS),
    }).then(function (answer) {
      if (!answer.ok) throw new Error(String(answer.status));
      return answer.json();
    });
  }

  function told(answer, tookMs) {
    if (!answer.output) return [answer.told || "STOP was sent.", "sent"];
    const word = answer.output.toUpperCase();
    if (answer.output === "safe" || answer.output === "armed") {
      const took = answer.took_s == null ? "" : ` after ${answer.took_s.toFixed(2)} s`;
      // an armed output is at 0 V, too, and safe in a moment
      const state = answer.output === "safe" ? "SAFE" : "at 0 V";
      return [`STOP: output ${state}${took}. ${answer.told || ""}`.trim(), "good"];
    }
    const by_hand = "Switch the amplifier off by hand.";
    return [
      `STOP: output ${word} after ${(tookMs / 1000).toFixed(1)} s. ${by_hand} ${answer.told || ""}`.trim(),
      "bad",
    ];
  }

  function press(why) {
    const now = performance.now();
    if (now - pressedAt < DOUBLE_MS) return;
    pressedAt = now;
    show("STOP pressed.", "sent");
    let settled = false;
    let answered = false; // by the panel, which does not read the output itself
    const urls = stopUrl ? [stopUrl, "/api/stop"] : ["/api/stop"];
    const all = urls.map(function (url) {
      return post(url, why).then(function (answer) {
        answered = true;
        if (settled) return;
        settled = Boolean(answer.output) || url === stopUrl || !stopUrl;
        const [text, kind] = told(answer, performance.now() - now);
        show(text, kind);
      });
    });
    setTimeout(function () {
      if (settled) return;
      if (answered) show("STOP was pressed. The output is being set to 0 V and read.", "sent");
      else show("STOP was pressed, nobody has answered yet. Switch the amplifier off by hand.", "bad");
    }, PATIENCE_MS);
    Promise.allSettled(all).then(function (results) {
      if (!settled && results.every((result) => result.status === "rejected")) {
        show("STOP reached nobody: switch the amplifier off by hand.", "bad");
      }
    });
  }

  window.addEventListener(
    "keydown",
    function (event) {
      if (event.key !== "Escape" || event.repeat || event.isComposing) return;
      if (document.body.dataset.mode === "photographs") return; // there is no output
      event.preventDefault();
      press("Esc on the page");
    },
    true,
  );
  // Down, not up: a finger that slips off the button has pressed it all the same.
  for (const kind of ["pointerdown", "click", "submit"]) {
    document.addEventListener(
      kind,
      function (event) {
        if (!event.target.closest || !event.target.closest("#stop-form")) return;
        if (kind !== "pointerdown") event.preventDefault();
        else if (event.button !== 0) return;
        if (kind !== "submit") press("STOP on the page");
      },
      true,
    );
  }

  window.labrigStop = { learn: learn, press: press };
  fetch("/api/status", { credentials: "same-origin", cache: "no-store" })
    .then((answer) => (answer.ok ? answer.json() : {}))
    .then((status) => learn(status.stop_url))
    .catch(function () {}); // the socket's hello tells it, too
})();
