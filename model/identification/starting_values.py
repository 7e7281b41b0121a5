"""Where a fit begins: the initial curvature, and rough values of the base parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress

import numpy as np

from model.identification.base_model import weighs
from model.identification.data.curve_smoothing import smooth
from model.identification.likelihood.common_errors.drive_rise import RISE
from model.identification.likelihood.contact_solution import ConfigurationModel
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.linearisation import BaseParameters, Bases
from model.identification.observations import Observed
from model.identification.paper import Sample, loaded
from model.measurements import FloatArray, ModelError, SheetGeometry, length_scale
from model.mechanics.field import Field

LOOP_RAD = 2.0 * np.pi
USUAL_BEND_PER_M = 20.0  # Me/B, to begin with where there are no curves
# by configuration: places of its parameters in the vector of an earlier fit, and that vector
Earlier = Mapping[str, tuple[BaseParameters, FloatArray]]


def rest_field(sheet: SheetGeometry, observed: Observed) -> tuple[Field, bool]:
    """k0, and whether it is known (else: a rough value, to be refined by the data)."""
    length = sheet.free_length_m
    if sheet.initial_curvature is None:
        return Field.constant(_measured_curvature(observed, 0.0), length), False
    field = Field.linear(*sheet.initial_curvature, length)
    if abs(float(field.integral(length))) > LOOP_RAD:
        raise ModelError(
            f"the initial curvature of configuration '{sheet.configuration}' makes the sheet a loop"
            f" ({float(field.integral(length)):.1f} rad over {length * 1e3:g} mm);"
            " check its unit (per m)"
        )
    return field, True


def _measured_curvature(observed: Observed, voltage_V: float) -> float:
    curves = [
        smooth(o.curve, observed.sheet, o.name, terms=2)
        for o in observed.observations
        if o.curve is not None and o.voltage_V == voltage_V
    ]
    if not curves:
        raise ModelError(
            f"the initial curvature of configuration '{observed.sheet.configuration}' is to be"
            " measured, but there is no curve at 0 V"
        )
    return float(np.mean([c.coefficients[0] for c in curves]))


def start(
    observed: Sequence[Observed],
    forward: ForwardModel,
    bases: Bases,
    known: Sequence[bool],
    earlier: Earlier | None = None,
) -> FloatArray:
    """Return base parameters to begin with; a `ModelError` where the data are too few for them.

    A configuration's are those of an earlier fit, where it had them all, else rough.
    """
    theta = np.zeros(bases.size)
    for one, configuration_model, part, stated in zip(
        observed, forward.configuration_models, bases.parts, known, strict=True
    ):
        for i, (mean, _) in part.prior.items():
            theta[i] = mean
        _check_forces(one, part, stated=stated)
        before = (earlier or {}).get(one.sheet.configuration)
        if before is not None and _has_all(part, before[0]):
            _carry_over(theta, part, *before)
        else:
            _first_guess(theta, one, configuration_model, part, stated=stated)
    if bases.rise is not None:
        theta[bases.rise : bases.rise + len(RISE)] = [mean for mean, _ in RISE]
    if not np.all(np.isfinite(theta)):
        raise ModelError("no rough values of B and EIBM could be found; check forces and curves")
    return theta


def with_measured_eibm(
    observed: Sequence[Observed], forward: ForwardModel, bases: Bases, theta: FloatArray
) -> FloatArray:
    """Return base parameters with the EIBM along the sheet as the measured curvatures have it, (8).

    A fit from an even EIBM may end elsewhere where the sheet is bent to a ring.
    """
    theta = theta.copy()
    for one, configuration_model, part in zip(
        observed, forward.configuration_models, bases.parts, strict=True
    ):
        s_m, B = configuration_model.s_m, float(np.exp(theta[part.stiffness]))
        rest = configuration_model.rest
        bends: dict[int, list[FloatArray]] = {}  # Me/B of each condition, by its first place
        for sample in _samples(one, rest):
            if sample.observation.voltage_V in part.eibm:
                first, sign = part.eibm[sample.observation.voltage_V]
                by_force = sample.moment_Nm(s_m) / B
                bend = sign * (sample.curve.curvature(s_m) - rest(s_m) - by_force)
                bends.setdefault(first, []).append(bend)
        for first, each in bends.items():
            found = np.linalg.lstsq(part.forms.T, np.mean(each, axis=0), rcond=None)[0]
            theta[first : first + len(part.forms)] = found
    return theta


def are_known(names: Sequence[str], bases: Bases, earlier: Earlier) -> bool:
    """Whether an earlier fit had all parameters of all configurations."""
    parts = zip(names, bases.parts, strict=True)
    return all(name in earlier and _has_all(part, earlier[name][0]) for name, part in parts)


def _has_all(part: BaseParameters, before: BaseParameters) -> bool:
    same = len(part.forms) == len(before.forms) and len(part.rest) == len(before.rest)
    return same and part.eibm.keys() <= before.eibm.keys()


def _carry_over(
    theta: FloatArray, part: BaseParameters, before: BaseParameters, values: FloatArray
) -> None:
    """Set a configuration's parameters as an earlier fit has them."""
    terms = len(part.forms)
    theta[part.stiffness] = values[before.stiffness]
    for voltage, (first, _) in part.eibm.items():
        own = before.eibm[voltage][0]
        theta[first : first + terms] = values[own : own + terms]
    theta[list(part.rest)] = values[list(before.rest)]


def _check_forces(observed: Observed, part: BaseParameters, *, stated: bool) -> None:
    """Raise a `ModelError` if there are fewer forces than parameters they must determine."""
    name = observed.sheet.configuration
    forces = sum(bool(np.isfinite(o.force_N)) for o in observed.touching())
    wanted = 1 + len({place for place, _ in part.eibm.values()}) + (0 if stated else 1)
    if forces == 0:
        _check_shapes(observed)
    elif forces < wanted:
        raise ModelError(
            f"'{name}': B and an EIBM for each voltage need {wanted} forces, and there are"
            f" {forces}; measure more positions"
        )


def _check_shapes(observed: Observed) -> None:
    """Raise a `ModelError` where nothing was weighed and a voltage has no shape either."""
    seen = {o.voltage_V for o in observed.observations if o.curve is not None}
    for voltage in observed.voltages_V:
        if voltage not in seen:
            raise ModelError(
                f"configuration '{observed.sheet.configuration}' has neither a valid force nor a"
                f" curve at {voltage:+g} V, so nothing is known of the EIBM there"
            )


def _first_guess(
    theta: FloatArray, observed: Observed, configuration_model: ConfigurationModel,
    part: BaseParameters, *, stated: bool,
) -> None:  # fmt: skip
    """Set B, EIBM and an unknown k0. With curves (2) of each condition is linear in 1/B, Me/B."""
    if not weighs(configuration_model.data_vector):
        _from_shapes(theta, observed, configuration_model, part)
        return
    places = sorted({place for place, _ in part.eibm.values()})
    samples = _samples(observed, configuration_model.rest)
    if len(samples) < 2 + len(places):
        _from_forces(theta, observed, configuration_model, part)
        return
    unknown = [] if stated else [min(part.rest)]
    A = np.zeros((len(samples), 1 + len(places) + len(unknown)))
    for row, sample in zip(A, samples, strict=True):
        row[0] = sample.mean_moment_Nm * 1e6  # so that 1/B in 1e6 per N m^2 is of order one
        if sample.observation.voltage_V != 0.0:
            place, sign = part.eibm[sample.observation.voltage_V]
            row[1 + places.index(place)] = sign
        row[1 + len(places) :] = 1.0
    turns = np.array([s.turn_rad / s.l_hat_m for s in samples])
    found = np.linalg.lstsq(A, turns, rcond=1e-10)[0]
    if found[0] <= 0.0:
        raise _wrong_sign(observed)
    theta[part.stiffness] = -np.log(found[0]) - 6.0 * np.log(10.0)
    theta[[*places, *unknown]] = found[1:]


def _samples(observed: Observed, rest: Field) -> list[Sample]:
    """Conditions whose curve is a smooth one; the others need not stop a rough guess.

    All of these, though few would do to begin with: a diagnosis keeps B near what they say.
    """
    result = []
    for o in observed.touching():
        if o.curve is not None and np.isfinite(o.force_N):
            with suppress(ModelError):
                result.append(loaded(observed, o, rest, 1.0))
    return result


def _from_forces(
    theta: FloatArray,
    observed: Observed,
    configuration_model: ConfigurationModel,
    part: BaseParameters,
) -> None:
    """Set B so that the forces are of the right size with an EIBM of the usual size."""
    usual_per_m = USUAL_BEND_PER_M / length_scale(observed.sheet)
    bend = {v: usual_per_m * float(np.sign(v)) for v in part.eibm}
    for voltage, (place, sign) in part.eibm.items():
        theta[place] = sign * bend[voltage]
    by_B = configuration_model.forces(configuration_model.beam(1.0, bend))
    measured = np.array(
        [
            np.mean(o.kept_N) if o.kept_N.size else np.nan
            for o in configuration_model.data_vector.seen
        ]
    )
    use = np.isfinite(measured) & np.isfinite(by_B)
    B = float(measured[use] @ by_B[use] / max(by_B[use] @ by_B[use], 1e-300)) if use.any() else 1e-6
    if B <= 0.0:
        raise _wrong_sign(observed)
    theta[part.stiffness] = np.log(B)


def _from_shapes(
    theta: FloatArray,
    observed: Observed,
    configuration_model: ConfigurationModel,
    part: BaseParameters,
) -> None:
    """Set Me/B to how much more the shapes are bent than at rest; B is not to be found."""
    at_rest_per_m = float(np.mean(configuration_model.at_rest))
    for voltage, (place, sign) in part.eibm.items():
        theta[place] = sign * (_measured_curvature(observed, voltage) - at_rest_per_m)


def _wrong_sign(observed: Observed) -> ModelError:
    return ModelError(
        f"configuration '{observed.sheet.configuration}': the forces have the opposite sign of what"
        " the shapes say, so B would be negative (check the signs of the forces and of the"
        " curves, and the arc's origin)"
    )
