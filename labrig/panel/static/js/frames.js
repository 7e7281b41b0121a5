// One rhythm for all that is drawn: a frame of the browser costs as much for one change as for many.

const TICK_MS = 33; // 30 times a second: two frames of a usual screen
const SLACK_MS = 8; // a screen's frames do not come when we would like them
const URGENT_MS = 10; // after a tick: an image need not wait for the next one
const HIDDEN_MS = 300; // a hidden page gets no frames

let waiting = new Set();
let later = null; // while works run: what they ask for that has run in this tick already
let done = null;
const evenHidden = new WeakSet();
let last = -Infinity;
let asked = false;
let urgent = false; // whether something that waits is
let fallback = null;

/**
 * Run `work` with the next tick, together with all others, once. Asked for within a tick it runs in
 * that one. `isUrgent` brings the tick forward. A hidden page has no ticks; there `whenHidden` works
 * run by a timer.
 */
export function nextFrame(work, { whenHidden = false, isUrgent = false } = {}) {
  if (whenHidden) evenHidden.add(work);
  urgent ||= isUrgent;
  if (done?.has(work)) later.add(work);
  else waiting.add(work);
  if (!done) ask();
}

/** Do not run it. */
export function forgetFrame(work) {
  waiting.delete(work);
  later?.delete(work);
}

function ask() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(tick);
  fallback = setTimeout(tickHidden, HIDDEN_MS);
}

/** At each frame of the screen, while something waits: a timer would miss every other one. */
function tick() {
  const now = performance.now();
  if (now - last < (urgent ? URGENT_MS : TICK_MS - SLACK_MS)) {
    requestAnimationFrame(tick);
    return;
  }
  clearTimeout(fallback);
  asked = urgent = false;
  last = now;
  run(() => true);
}

function tickHidden() {
  run((work) => evenHidden.has(work));
  if (asked) fallback = setTimeout(tickHidden, HIDDEN_MS);
}

function run(wanted) {
  [done, later] = [new Set(), new Set()];
  for (const work of waiting) {
    if (!wanted(work)) continue;
    waiting.delete(work);
    done.add(work);
    try {
      work();
    } catch (error) {
      reportError(error); // the others are drawn all the same
    }
  }
  waiting = new Set([...waiting, ...later]);
  done = later = null;
  if (waiting.size) ask();
}
