"""The base model: where its parameters stand, and rough values of them to begin with."""

from __future__ import annotations

import numpy as np

from model.identification.likelihood.drive_rise import RISE
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.linearisation import BaseParameters, Bases
from model.identification.observations import observe
from model.identification.options import FitOptions
from model.identification.residual_vector import System, legendre_field
from model.identification.starting_values import first_guess, layout, rest_field
from model.measurements import FloatArray, Measurements, ModelError, SheetGeometry
from model.mechanics.field import Field

FREE_REST_PER_M = 60.0  # prior width of k0's terms where sheet.toml does not state k0


def rest_of(measurements: Measurements, configuration: str) -> tuple[Field, bool]:
    """k0 as stated, or a rough value to be refined."""
    return rest_field(measurements.sheets[configuration], observe(measurements, configuration))


def bases_of(study: ForwardModel, known: list[bool], symmetric: bool) -> Bases:
    """B, one EIBM a voltage, and what is not known of k0, by configuration; how pulses rise."""
    parts, place = [], 0
    for scene, look, stated in zip(study.scenes, study.looks, known, strict=True):
        stiffness, place = place, place + 1
        eibm: dict[float, tuple[int, float]] = {}
        own: dict[float, int] = {}
        for voltage in look.voltages_V:
            key = abs(voltage) if symmetric else voltage
            if key not in own:
                own[key], place = place, place + 1
            eibm[voltage] = (own[key], -1.0 if symmetric and voltage < 0.0 else 1.0)
        rest: dict[int, FloatArray] = {}
        prior: dict[int, tuple[float, float]] = {}
        if not stated:
            for i in range(6 if scene.count > 8 else 2):
                rest[place] = legendre_field(i, scene.length)(scene.s_m)
                prior[place] = (0.0, FREE_REST_PER_M)
                place += 1
        elif (bow := between_nodes(look.sheet, scene.s_m)) is not None:
            rest[place], prior[place] = bow, (0.5, 0.5)
            place += 1
        parts.append(BaseParameters(stiffness, eibm, rest, prior))
    if any(look.pulses for look in study.looks):
        return Bases(tuple(parts), place + len(RISE), rise=place)
    return Bases(tuple(parts), place)


def between_nodes(sheet: SheetGeometry, s_m: FloatArray) -> FloatArray | None:
    """Mean difference of a smooth curve and straight lines between the stated nodes of k0.

    Nobody says which of the two is meant, and it is more than shapes can see.
    """
    if sheet.initial_curvature is None or len(sheet.initial_curvature[0]) < 4:
        return None
    from scipy.interpolate import CubicSpline  # slow to import

    s, k = sheet.initial_curvature
    second = CubicSpline(s, k)(np.clip(s_m, s[0], s[-1]), 2)
    width = np.interp(s_m, 0.5 * (s[1:] + s[:-1]), np.diff(s))
    bow: FloatArray = -second * width**2 / 12.0
    return bow if np.max(np.abs(bow)) > 1e-3 else None


def start(
    measurements: Measurements,
    study: ForwardModel,
    bases: Bases,
    known: list[bool],
    symmetric: bool,
) -> FloatArray:
    """Rough base parameters."""
    theta = np.zeros(bases.size)
    for c, (name, one) in enumerate(zip(study.names, bases.parts, strict=True)):
        observed = observe(measurements, name)
        options = FitOptions(
            eibm_form="constant", symmetric=symmetric, initial_curvature_sigma_per_m=0.0
        )
        where = layout(observed, options, known[c])
        guess = first_guess(System(observed, study.scenes[c].rest, where, 5))
        theta[one.stiffness] = guess[0]
        for voltage, (i, _) in one.eibm.items():
            own, sign = where.of(voltage)
            theta[i] = guess[own.start] * (sign if symmetric and voltage < 0.0 else 1.0)
        for i, (mean, _) in one.prior.items():
            theta[i] = mean
    if bases.rise is not None:
        theta[bases.rise :] = [mean for mean, _ in RISE]
    if not np.all(np.isfinite(theta)):
        raise ModelError("no rough values of B and EIBM could be found; check forces and curves")
    return theta
