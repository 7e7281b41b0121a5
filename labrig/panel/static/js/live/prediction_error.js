// By how much the model's prediction misses what is measured, as one line.

import { number, signed, volts } from "../format.js";

/** `model` as in the message `curve`; empty when there is no prediction. */
export function errorText(model) {
  if (!model) return "";
  if (!model.points_px?.length) return model.why ?? "";
  const found = [];
  if (model.distance_mm != null) found.push(`${number(model.distance_mm, 2)} mm RMS distance`);
  if (model.force_error_mN != null)
    found.push(`force ${signed(model.force_error_mN, 2)} mN at ${volts(model.voltage_V)}`);
  return found.length ? `prediction error: ${found.join(", ")}` : "prediction error: not known yet";
}
