// Numbers and times as people read them.

const MINUS = "\u2212";

/** A number with so many decimals and a true minus; a dash when it is not known. */
export function number(value, decimals = 2) {
  if (value == null || !Number.isFinite(value)) return "\u2013";
  const text = Math.abs(value).toFixed(decimals);
  return value < 0 && Number(text) !== 0 ? MINUS + text : text;
}

/** With its sign, unless it is zero. */
export function signed(value, decimals = 2) {
  const text = number(value, decimals);
  return value > 0 && Number(text) !== 0 ? `+${text}` : text;
}

/** Without needless zeros: 5, 2.5, -0.05. */
export function plain(value) {
  if (value == null || !Number.isFinite(value)) return "\u2013";
  return String(Number(value.toPrecision(6))).replace("-", MINUS);
}

/** A voltage by which readings are grouped: +2 V. */
export function volts(value) {
  return value > 0 ? `+${plain(value)} V` : `${plain(value)} V`;
}

/** Three significant digits: 1.28e-6 as 1.28 with its own power left to the caller. */
export function digits(value, count = 3) {
  if (value == null || !Number.isFinite(value)) return "\u2013";
  return String(Number(value.toPrecision(count))).replace("-", MINUS);
}

/** A value and the ends of its interval, with two significant digits of the half width. */
export function withInterval({ value, interval90: [low, high] }) {
  const half = 0.5 * (high - low);
  const decimals = half > 0 ? Math.min(6, Math.max(0, 1 - Math.floor(Math.log10(half)))) : 3;
  return [value, low, high].map((one) => number(one, decimals));
}

/** 0:19, 12:05, 1:02:05. */
export function clock(seconds) {
  if (seconds == null || !Number.isFinite(seconds)) return "\u2013";
  const whole = Math.max(0, Math.floor(seconds));
  const [h, m, s] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  const two = (n) => String(n).padStart(2, "0");
  return h ? `${h}:${two(m)}:${two(s)}` : `${m}:${two(s)}`;
}

/** 'about 45 s', 'about 12 min', 'about 1.5 h'. */
export function about(seconds) {
  if (seconds == null) return "\u2013";
  if (seconds < 90) return `about ${Math.round(seconds)} s`;
  if (seconds < 5400) return `about ${Math.round(seconds / 60)} min`;
  return `about ${plain(Math.round(seconds / 360) / 10)} h`;
}

/** '20 s ago', '3 min ago', 'about 1.5 h ago'; empty when the time is not known. */
export function ago(wall, now_ms = Date.now()) {
  const seconds = (now_ms - new Date(wall).getTime()) / 1000;
  if (!wall || !Number.isFinite(seconds)) return "";
  if (seconds < 60) return `${Math.max(0, Math.round(seconds))} s ago`;
  if (seconds < 5400) return `${Math.round(seconds / 60)} min ago`;
  return `${about(seconds)} ago`;
}

/** A wall time, in the reader's own zone, as 2026-11-21 14:05. */
export function when(wall) {
  if (!wall) return "\u2013";
  const date = new Date(wall);
  if (Number.isNaN(date.getTime())) return wall;
  const two = (n) => String(n).padStart(2, "0");
  const day = `${date.getFullYear()}-${two(date.getMonth() + 1)}-${two(date.getDate())}`;
  return `${day} ${two(date.getHours())}:${two(date.getMinutes())}`;
}

/** The same with the zone, for where a time of day stands once: 2026-11-21 14:05 (UTC+1). */
export function whenInZone(wall) {
  const minutes = -new Date(wall).getTimezoneOffset();
  if (!wall || Number.isNaN(minutes)) return when(wall);
  const [hours, rest] = [Math.floor(Math.abs(minutes) / 60), Math.abs(minutes) % 60];
  const shift = minutes ? `${minutes < 0 ? MINUS : "+"}${hours}` : "";
  return `${when(wall)} (UTC${shift}${rest ? `:${rest}` : ""})`;
}

/** What the times of a session count from, and by which clock. */
export function timesOf(wall, clock_kind) {
  const since = wall ? `times since the start, ${whenInZone(wall)}` : "times since the start";
  return clock_kind === "virtual" ? `${since}, by the session\u2019s own, virtual clock` : since;
}

/** Size of a file. */
export function bytes(count) {
  if (count == null) return "\u2013";
  const units = ["B", "kB", "MB", "GB"];
  let power = 0;
  while (count >= 1000 && power < 3) [count, power] = [count / 1000, power + 1];
  return `${count < 10 && power ? count.toFixed(1) : Math.round(count)} ${units[power]}`;
}

/** The mark of a voltage's sign, so that it is not told by colour alone. */
export function shapeOf(voltage) {
  return voltage > 0 ? "\u25B2" : voltage < 0 ? "\u25BC" : "\u25CF";
}

/** Mean, scatter (of single readings) and count; scatter is null for fewer than two. */
export function statistics(values) {
  const count = values.length;
  if (!count) return { mean: null, scatter: null, count };
  const mean = values.reduce((sum, value) => sum + value, 0) / count;
  if (count < 2) return { mean, scatter: null, count };
  const square = values.reduce((sum, value) => sum + (value - mean) ** 2, 0);
  return { mean, scatter: Math.sqrt(square / (count - 1)), count };
}
