"""B and EIBM with which a model with effects predicts what `labrig fit` says of the means.

What acts in time alone may change no mean that was measured: a lag looks like less EIBM. Its model
then has other B and EIBM than the base model, and how well they are known depends on how well it
is. Predictions would be as good as those of the base model, by chance better or worse. So they are
kept as they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from model.discrepancy.search.form_share import in_time
from model.discrepancy.thresholds import SAME_MEANS_SHARE
from model.discrepancy.verdict.measured_places import Seen, seen_at
from model.discrepancy.verdict.prediction_error import cells, floor, variance
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray
from model.sheet.configured_sheet import Along, ConfiguredSheet
from model.sheet.sheet_model import SheetModel

ROUNDS = 6  # of Newton's steps
CLOSE = 1e-11  # of the data's standard deviation, at which there is nothing to go
STEP = 1e-4  # relative, for derivatives
LEAST_OWN = 0.1  # of an EIBM's variance: what is not B's


def with_means_of(
    plain: SheetModel, model: SheetModel, reported: MixedModelFit
) -> SheetModel | None:
    """Return a model with the B and EIBM that give it a base model's mean forces and curves.

    At the conditions that were measured, as nearly as they can. None where what acts in time alone
    leaves others, as a delay between force and picture does. `reported` is what the model is of.
    """
    timely = all(in_time(one.effect) for one in reported.found)
    units, sheets = floor(variance(reported), cells(reported)), dict(model.sheets)
    for name, data_vector in zip(
        reported.problem.forward.names, reported.problem.forward.data_vectors, strict=True
    ):
        places = [
            (float(one.position_m), float(one.voltage_V)) for one in data_vector.seen
            if not (one.free or one.zero or one.tilt_rad)
        ]  # fmt: skip
        if not places or plain.sheet(name).eibm.keys() != sheets[name].eibm.keys():
            continue  # nothing but free shapes
        begun = replace(model, sheets={**sheets, name: _begun(plain.sheet(name), sheets[name])})
        asked = list(dict.fromkeys(places))
        matched = _Matched(
            begun, name, asked, 1e-3 * units.force_rmse_mN, 1e-3 * units.curve_rmse_mm
        )
        sheets[name] = matched.to(plain)
        missed = _miss(replace(model, sheets=sheets), plain, name, asked) if timely else 0.0
        if not missed <= SAME_MEANS_SHARE:  # so written, what is no number is no match
            return None
    return replace(model, sheets=sheets)


def theta_of(model: SheetModel, reported: MixedModelFit) -> FloatArray:
    """Return a fit's base parameters with the B and EIBM of a model."""
    theta = reported.theta.copy()
    names, parts = reported.problem.forward.names, reported.problem.bases.parts
    for name, part in zip(names, parts, strict=True):
        sheet = model.sheet(name)
        theta[part.stiffness] = np.log(sheet.B.value)
        for volts, (place, sign) in part.eibm.items():
            theta[place] = sign * float(sheet.eibm[volts].values[0]) / sheet.B.value
    return theta


def _miss(
    model: SheetModel, plain: SheetModel, name: str, places: Sequence[tuple[float, float]]
) -> float:
    """Return the RMS difference of predictions, as a share of a base model's uncertainty.

    Forces fix B, shapes fix Me/B, so these two are varied independently.
    """
    one, here = plain.sheet(name), seen_at(plain, name, places)
    stiffer = one.B.sigma / one.B.value
    force2 = sum((stiffer * seen.F_N) ** 2 for seen in here)
    curve2 = 0.0
    for volts, along in one.eibm.items():
        relative = float(along.sigma[0] / along.values[0])
        more = float(np.sqrt(max(relative**2 - stiffer**2, LEAST_OWN * relative**2)))
        stronger = Along(along.s_m, (1.0 + more) * along.values, along.sigma, along.unit)
        other = replace(one, eibm={**one.eibm, volts: stronger})
        moved = seen_at(replace(plain, sheets={**plain.sheets, name: other}), name, places)
        more_force2, more_curve2 = _squares(here, moved)
        force2, curve2 = force2 + more_force2, curve2 + more_curve2
    missed_force2, missed_curve2 = _squares(here, seen_at(model, name, places))
    return float(np.sqrt(missed_force2 / force2 + missed_curve2 / curve2))


def _squares(some: Sequence[Seen], others: Sequence[Seen]) -> tuple[float, float]:
    """Return the squared differences of forces, N^2, and of curves, m^2, of all places."""
    pairs = list(zip(some, others, strict=True))
    force2 = sum((b.F_N - a.F_N) ** 2 for a, b in pairs)
    curve2 = sum(np.mean((b.x_m - a.x_m) ** 2 + (b.y_m - a.y_m) ** 2) for a, b in pairs)
    return force2, float(curve2)


def _begun(plain: ConfiguredSheet, own: ConfiguredSheet) -> ConfiguredSheet:
    """Return a sheet with the values of another one, and its own uncertainties."""
    eibm = {v: replace(along, values=plain.eibm[v].values) for v, along in own.eibm.items()}
    return replace(plain, B=replace(own.B, value=plain.B.value), eibm=eibm)


class _Matched:
    """A configuration whose B and EIBM are changed."""

    def __init__(
        self, model: SheetModel, name: str, places: Sequence[tuple[float, float]], unit_N: float,
        unit_m: float,
    ) -> None:  # fmt: skip
        self.model, self.name, self.places = model, name, places
        self.unit_N, self.unit_m = unit_N, unit_m

    def to(self, plain: SheetModel) -> ConfiguredSheet:
        """Return the sheet that predicts what another model does."""
        wanted, voltages = self._seen(plain), list(self.model.sheet(self.name).eibm)
        factors = np.ones(1 + len(voltages))
        moves = STEP * np.eye(len(factors))
        for _ in range(ROUNDS):
            here = self._seen(self._with(factors))
            by = [(self._seen(self._with(factors + move)) - here) / STEP for move in moves]
            columns = np.stack(by, axis=1)
            step = np.linalg.lstsq(columns, wanted - here, rcond=None)[0]
            factors = factors + step
            if np.max(np.abs(columns @ step), initial=0.0) < CLOSE:
                break
        return self._with(factors).sheet(self.name)

    def _with(self, factors: FloatArray) -> SheetModel:
        """Return the model with B and the EIBMs times these."""
        one, (stiffer, *stronger) = self.model.sheet(self.name), factors.tolist()
        eibm = {
            volts: Along(along.s_m, more * along.values, along.sigma, along.unit)
            for (volts, along), more in zip(one.eibm.items(), stronger, strict=True)
        }
        own = replace(one, B=replace(one.B, value=stiffer * one.B.value), eibm=eibm)
        return replace(self.model, sheets={**self.model.sheets, self.name: own})

    def _seen(self, model: SheetModel) -> FloatArray:
        """Return the means that are predicted, in units of their standard deviations."""
        rows = list[FloatArray]()
        for one in seen_at(model, self.name, self.places):
            curve = np.concatenate([one.x_m, one.y_m]) / np.sqrt(len(one.s_m))
            if np.isfinite(self.unit_N):
                rows.append(np.array([one.F_N / self.unit_N]))
            if np.isfinite(self.unit_m):
                rows.append(curve / self.unit_m)
        return np.concatenate(rows)
