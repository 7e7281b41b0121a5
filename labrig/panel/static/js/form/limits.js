// What a JSON Schema allows of one value, in words and as a check. No page has limits of its own.

import { plain } from "../format.js";

const UNITS = {
  mm: "mm",
  s: "s",
  V: "V",
  mN: "mN",
  deg: "\u00B0",
  hz: "Hz",
  N: "N",
  m: "m",
  kB: "kB",
  mA: "mA",
  days: "days",
};

/** A schema with its `$ref` followed and `null` taken out: { schema, nullable, variants }. */
export function resolve(schema, root) {
  if (schema.$ref) {
    const found = schema.$ref
      .split("/")
      .slice(1)
      .reduce((at, key) => at[key], root);
    return resolve({ ...found, ...without(schema, "$ref") }, root);
  }
  if (!schema.anyOf) return { schema, nullable: false, variants: null };
  const rest = schema.anyOf.filter((one) => one.type !== "null");
  const nullable = rest.length < schema.anyOf.length;
  const outer = without(schema, "anyOf");
  if (rest.length > 1)
    return { schema: outer, nullable, variants: rest.map((one) => resolve(one, root).schema) };
  const inner = resolve(rest[0], root);
  return { schema: { ...inner.schema, ...outer }, nullable, variants: inner.variants };
}

function without(object, key) {
  const { [key]: _, ...rest } = object;
  return rest;
}

/** 'sample_at_s' as { label: 'sample at', unit: 's' }. */
export function nameOf(key) {
  const per = key.match(/^(.*)_per_([A-Za-z]+)$/);
  if (per) return { label: per[1].replaceAll("_", " "), unit: `per ${per[2]}` };
  if (key === "per_m") return { label: "curvature", unit: "per m" };
  const parts = key.split("_");
  const unit = parts.length > 1 ? UNITS[parts.at(-1)] : null;
  const words = unit ? parts.slice(0, -1) : parts;
  return { label: words.join(" "), unit: unit ?? "" };
}

/** 'more than 0, at most 3600 s': the bounds a schema states. */
export function boundsOf(schema, unit = "") {
  const given = [
    [schema.exclusiveMinimum, "more than"],
    [schema.minimum, "at least"],
    [schema.exclusiveMaximum, "less than"],
    [schema.maximum, "at most"],
  ];
  const parts = given
    .filter(([value]) => value != null)
    .map(([value, words]) => `${words} ${plain(value)}`);
  return parts.length ? `${parts.join(", ")}${unit ? ` ${unit}` : ""}` : "";
}

/** Why a number is not allowed; empty when it is. */
export function faultOfNumber(value, schema, unit = "") {
  if (!Number.isFinite(value)) return "Give a number.";
  if (schema.type === "integer" && !Number.isInteger(value)) return "Give a whole number.";
  const out =
    (schema.exclusiveMinimum != null && value <= schema.exclusiveMinimum) ||
    (schema.minimum != null && value < schema.minimum) ||
    (schema.exclusiveMaximum != null && value >= schema.exclusiveMaximum) ||
    (schema.maximum != null && value > schema.maximum);
  return out ? `${plain(value)} is not allowed: ${boundsOf(schema, unit)}.` : "";
}

/** Why a list has too few or too many entries. */
export function faultOfCount(count, schema) {
  if (schema.minItems != null && count < schema.minItems)
    return `Give at least ${schema.minItems}.`;
  if (schema.maxItems != null && count > schema.maxItems) return `Give at most ${schema.maxItems}.`;
  return "";
}

/** A number as typed: comma or point, any minus; NaN when it is none. */
export function parseNumber(text) {
  const plainText = text.trim().replace("\u2212", "-");
  return plainText === "" ? NaN : Number(plainText);
}
