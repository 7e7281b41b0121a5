// The rows of the strip charts: those of the session's channels, in the units that the plan names.

// What every session has, before anything is planned.
const EVERY = [
  { key: "drive_V", name: "drive", unit: "V", column: "drive_V", factor: 1 },
  { key: "force_mN", name: "force", unit: "mN", column: "force_N", factor: 1000 },
];
// How a row is drawn; `least`: the smallest span of its axis.
const STYLES = {
  drive_V: { decimals: 2, sign: true, least: 0.5, colour: "--trace-drive" },
  force_mN: { decimals: 3, least: 0.2, colour: "--trace-force" },
  current_mA: { decimals: 1, least: 1, colour: "--trace-current" },
};
const OTHER = { decimals: 3, least: 0.02, colour: "--trace-other" };

/** { key, name, title, unit, column, factor, decimals, sign, least, colour } of each channel. */
export function stripRows(plan) {
  return (plan?.channels ?? EVERY).map((row) => ({
    ...row,
    title: titleOf(row.name),
    ...(STYLES[row.key] ?? OTHER),
  }));
}

function titleOf(name) {
  const words = name.replaceAll("_", " ");
  return words[0].toUpperCase() + words.slice(1);
}

/** The value of a reading in a row's unit; null where it has none. */
export function valueOf(reading, row) {
  const value = reading.values?.[row.column];
  return value == null ? null : row.factor * value;
}
