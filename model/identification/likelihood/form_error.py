"""An effect as columns of the model: its amplitude, its parameters, how its form may differ.

No formula is nature's. So an effect is its form times (1 + a smooth deviation): along the sheet,
from voltage to voltage, along the arc, in time, or from one configuration to the other, whichever
it depends on; with a standard deviation of about a third, and integrated over.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from model.effects.interface import BeamProblem, ContactSolution, Effect, EffectParameter
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.linearisation import Linearisation
from model.identification.likelihood.model_state import (
    AppliedEffect,
    ModelState,
    acting_in,
)
from model.locations.quantities import Perturbation
from model.measurements import FloatArray
from model.sheet.effect_hooks import Acting, applied

FORM = 0.35  # standard deviation of the deviation along the coordinate that an effect depends on
SIGN = 0.25  # and from one voltage or configuration to the other
FALLS = -0.6  # power with which waves along the sheet grow smaller
WAVES = ((1, 0.8), (2, 0.6))  # along other coordinates
RUN = 0.5  # from run to run
OWN = 1.0  # where each configuration may have its own size
MOST_LOG_STEP = 0.4
PULSE_S = 0.6


@dataclass(frozen=True)
class Found:
    """An effect in the model, with the values it has there."""

    effect: Effect
    values: Mapping[str, Mapping[str, float]]  # configuration -> parameter -> value
    width: float = 3.0  # of the prior of the size, in units of its plausible size
    sigma: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    @property
    def active(self) -> AppliedEffect:
        """As states have it."""
        return AppliedEffect(self.effect, self.values)

    def parameters(self) -> list[tuple[EffectParameter, tuple[str, ...]]]:
        """Knobs that are refined, each with the configurations that share its value."""
        names = tuple(self.values)
        free = [k for i, k in enumerate(self.effect.parameters) if i == 0 or k.log]
        if not self.effect.by_configuration:
            return [(k, names) for k in free]
        return [(k, (name,)) for k in free for name in names]


def whole_step(
    forward: ForwardModel,
    c: int,
    state: ModelState,
    base: BeamProblem,
    others: tuple[AppliedEffect, ...],
    one: AppliedEffect,
) -> Perturbation:
    """Return the first-order perturbation by an effect at its present values, given the others."""
    without = shaped(base, state, others, forward.names[c])
    here = Acting(one.effect, one.values[forward.names[c]])
    full = applied(without, state.solved.contact, [here])
    step = replace(
        forward.no_step(c), beam=forward.scenes[c].change(without, full, state.solved.contact)
    )
    return forward.outer_step(c, state, here, step)


def shaped(
    base: BeamProblem, state: ModelState, active: tuple[AppliedEffect, ...], name: str
) -> BeamProblem:
    """Return the base problem with effects applied, at a known solution."""
    return applied(base, state.solved.contact, acting_in(active, name))


Ways = Iterator[tuple[Perturbation, float]]  # steps, each with its standard deviation


def deviations(
    effect: Effect, forward: ForwardModel, c: int, step: Perturbation, contact: ContactSolution
) -> Ways:
    """Yield the perturbations by which the form may differ, each with its standard deviation."""
    scene = forward.scenes[c]
    for along in effect.form_error_along:
        if along == "s":
            waves = waves_along(effect.waves)
            yield from _along_sheet(forward, c, step, scene.s_m / scene.length, waves)
        elif along == "curvature":
            bent = np.abs(contact.curvature - scene.rest(scene.s_m))
            yield from _along_sheet(forward, c, step, bent / max(float(np.max(bent)), 1e-9), WAVES)
        elif along == "position":
            u = unit(scene.stated_m)
            for j, share in WAVES:
                yield _weighed(forward, c, step, cosine(j, u)), FORM * share
        elif along == "voltage":
            driven = np.sign(scene.voltage_V)
            for wave in (driven, np.where(driven == 0.0, -1.0, 0.5)):
                yield _weighed(forward, c, step, wave), SIGN
        elif along == "time":
            yield from _in_time(forward, c, step)
        elif along == "run":
            yield from _from_run_to_run(forward, c, step)
        elif along == "place":
            u = scene.curve_s / np.maximum(scene.curve_s.max(axis=1, keepdims=True), 1e-12)
            for j, share in WAVES:
                points = step.points_m * cosine(j, u)
                yield replace(forward.no_step(c), points_m=points), FORM * share


def _from_run_to_run(forward: ForwardModel, c: int, step: Perturbation) -> Ways:
    """Yield differences between runs, such as the distance of frames from edges."""
    own = [one.run for one in forward.looks[c].seen]
    for run in forward.layout.runs:
        factor = np.array([float(each == run) for each in own])
        yield _weighed(forward, c, step, factor), RUN


def waves_along(count: int) -> tuple[tuple[int, float], ...]:
    """Waves along the sheet with their shares of `FORM`; finer ones are smaller."""
    numbers = np.arange(1, count + 1)
    shares = numbers**FALLS / np.sqrt(np.sum(numbers ** (2.0 * FALLS)))
    return tuple(zip(numbers.tolist(), shares.tolist(), strict=True))


def _along_sheet(
    forward: ForwardModel,
    c: int,
    step: Perturbation,
    u: FloatArray,
    waves: tuple[tuple[int, float], ...],
) -> Ways:
    """Yield changes of curvature and compliance times waves of u in 0 .. 1, (G,) or (K, G)."""
    G = forward.scenes[c].count
    for j, share in waves:
        beam = np.zeros_like(step.beam)
        beam[:, :G] = step.beam[:, :G] * cosine(j, u)
        beam[:, G : 2 * G] = step.beam[:, G : 2 * G] * cosine(j, u)
        yield replace(forward.no_step(c), beam=beam), FORM * share


def _in_time(
    forward: ForwardModel, c: int, step: Perturbation
) -> Iterator[tuple[Perturbation, float]]:
    """Within a pulse as a factor; over run and session something added, since drifts cross zero."""
    part = forward.part(c)
    at, in_bin = part.clock.pulse_s, part.bin_clock.pulse_s
    driven = part.clock.voltage_V != 0.0
    for j in (1, 2, 3):
        wave, bins = (cosine(j, a / PULSE_S) for a in (at, in_bin))
        wave, bins = wave * driven, part.bin_mean(bins)
        yield replace(
            forward.no_step(c), eibm=step.eibm * wave, stiffness=step.stiffness * wave,
            force_N=step.force_N * wave, bin_eibm=step.bin_eibm * bins,
            bin_stiffness=step.bin_stiffness * bins, frame_eibm=step.frame_eibm * wave,
        ), 0.6 * FORM / j  # fmt: skip
    size = [0.5 * float(np.ptp(v)) for v in (step.eibm, step.stiffness, step.force_N)]
    for name in ("session", "run_s"):
        t = unit(getattr(part.clock, name))
        if np.ptp(t) == 0.0 or not (any(size) or np.any(step.force_N)):
            continue
        force = step.force_N if name == "run_s" else size[2]
        for j in (1, 2, 3):
            wave = cosine(j, t)
            yield replace(
                forward.no_step(c), eibm=size[0] * wave * driven, stiffness=size[1] * wave,
                force_N=force * wave,
            ), 0.6 * FORM / j  # fmt: skip


def cosine(j: int, t: FloatArray) -> FloatArray:
    """Return a wave of unit mean square on a coordinate 0 .. 1."""
    result: FloatArray = np.sqrt(2.0) * np.cos(j * np.pi * np.clip(t, 0.0, 1.0))
    return result


def _weighed(forward: ForwardModel, c: int, step: Perturbation, wave: FloatArray) -> Perturbation:
    """Return a step times a factor (K,) for each condition."""
    part = forward.part(c)
    of, bin_of = part.reading_of, part.bin_of
    return Perturbation(
        beam=step.beam * wave[:, None], eibm=step.eibm * wave[of],
        stiffness=step.stiffness * wave[of], force_N=step.force_N * wave[of],
        bin_eibm=step.bin_eibm * wave[bin_of], bin_stiffness=step.bin_stiffness * wave[bin_of],
        points_m=step.points_m * wave[:, None], frame_eibm=step.frame_eibm * wave[of],
    )  # fmt: skip


def unit(values: FloatArray) -> FloatArray:
    """Finite values brought to 0 .. 1; the middle where there is none, or no difference."""
    good = values[np.isfinite(values)]
    span = float(np.ptp(good)) if len(good) else 0.0
    if span == 0.0:
        return np.full_like(values, 0.5)
    share: FloatArray = np.nan_to_num((values - good.min()) / span, nan=0.5)
    return share


def atoms(
    forward: ForwardModel, states: tuple[ModelState, ...], effect: Effect,
    steps: list[Perturbation], *,
    tolerant: bool = True,
) -> FloatArray:  # fmt: skip
    """Return the form itself, and its deviations times their standard deviations: (N, 1 + J)."""
    whole = [forward.rows_of(c, states[c], step) for c, step in enumerate(steps)]
    columns: list[FloatArray] = [np.sum(whole, axis=0)]
    if not tolerant:
        return np.stack(columns, axis=1)
    if len(steps) > 1 and all(np.any(w) for w in whole) and not effect.of_the_rig:
        share = OWN if effect.by_configuration else SIGN
        signs = [1.0 if c == 0 else -1.0 for c in range(len(steps))]
        columns.append(share * np.sum([s * w for s, w in zip(signs, whole, strict=True)], axis=0))
    ways: list[FloatArray] = []  # the same way in all configurations is one column
    for c, step in enumerate(steps):
        for j, (way, share) in enumerate(
            deviations(effect, forward, c, step, states[c].solved.contact)
        ):
            row = share * forward.rows_of(c, states[c], way)
            if j < len(ways):
                ways[j] = ways[j] + row
            else:
                ways.append(row)
    return np.stack([*columns, *(w for w in ways if np.any(w))], axis=1)


def effect_columns(
    forward: ForwardModel,
    linear: Linearisation,
    one: Found,
    active: tuple[AppliedEffect, ...],
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Columns of an effect in the model, its parameters, then the tolerance of its form: (N, q).

    With precision (q,) and distance (q,) of the present values from the middle of their priors.
    """
    columns, precision, away = [], [], []
    places = {name: c for c, name in enumerate(forward.names)}
    bent = [state.base for state in linear.states]
    for parameter, names in one.parameters():
        column = np.zeros(forward.layout.size)
        for name in names:
            column += _by_parameter(
                forward, places[name], linear, bent[places[name]], one, active, parameter
            )
        value = one.values[names[0]][parameter.name]
        columns.append(column)
        width, away_from_usual = _prior(parameter, value, one)
        precision.append(width**-2.0)
        away.append(away_from_usual)
    others = tuple(a for a in active if a.effect is not one.effect)
    steps = [
        whole_step(forward, c, linear.states[c], bent[c], others, one.active)
        if name in one.values else forward.no_step(c)
        for c, name in enumerate(forward.names)
    ]  # fmt: skip
    # where each configuration has its own size, the second column is among the parameters already
    first = 2 if one.effect.by_configuration and len(steps) > 1 else 1
    extra = atoms(forward, linear.states, one.effect, steps)[:, first:]
    n = extra.shape[1]
    return (
        np.concatenate([np.stack(columns, axis=1), extra], axis=1),
        np.array(precision + [1.0] * n), np.array(away + [0.0] * n),
    )  # fmt: skip


def _prior(parameter: EffectParameter, value: float, one: Found) -> tuple[float, float]:
    """Width of a parameter's prior, and how far its value is from the middle."""
    if not parameter.log:
        return one.width * parameter.prior_scale, value - parameter.neutral
    if parameter is not one.effect.amplitude:
        return 1.0, 0.0
    if np.isfinite(parameter.neutral) and parameter.neutral > 0.0:
        usual = abs(float(np.log(parameter.prior_scale / parameter.neutral)))
        return one.width * usual, float(np.log(value / parameter.neutral))
    return 1.0, float(np.log(value / parameter.prior_scale))


def _by_parameter(
    forward: ForwardModel, c: int, linear: Linearisation, base: BeamProblem, one: Found,
    active: tuple[AppliedEffect, ...],
    parameter: EffectParameter,
) -> FloatArray:  # fmt: skip
    """Return the derivative of the rows by a parameter, or by its logarithm."""
    name, state = forward.names[c], linear.states[c]
    values = dict(one.values[name])
    value = values[parameter.name]
    h = 0.02 if parameter.log else 0.05 * parameter.prior_scale
    both = []
    for sign in (-1.0, 1.0):
        values[parameter.name] = value * np.exp(sign * h) if parameter.log else value + sign * h
        turned = tuple(
            AppliedEffect(a.effect, {name: dict(values)}) if a.effect is one.effect else a
            for a in active
        )
        beam = shaped(base, state, turned, name)
        here = Acting(one.effect, dict(values))
        outer = forward.outer_step(c, state, here, forward.no_step(c))
        both.append((beam, outer))
    (low, outer_low), (high, outer_high) = both
    step = replace(outer_high, beam=forward.scenes[c].change(low, high, state.solved.contact))
    rows = forward.rows_of(c, state, step) - forward.rows_of(
        c, state, replace(outer_low, beam=0.0 * outer_low.beam)
    )
    result: FloatArray = rows / (2.0 * h)
    return result


def moved(
    found: tuple[Found, ...], beta: FloatArray, sigma: FloatArray, spans: list[slice]
) -> tuple[tuple[Found, ...], bool]:
    """Return the effects after a step, and whether the step was small."""
    result, quiet = [], True
    for one, span in zip(found, spans, strict=True):
        values = {name: dict(v) for name, v in one.values.items()}
        unsure = {name: dict(one.sigma.get(name, {})) for name in values}
        for place, (parameter, names) in enumerate(one.parameters(), span.start):
            step, doubt = float(beta[place]), float(sigma[place])
            quiet = quiet and abs(step) < 0.1 * doubt
            for name in names:
                old = values[name][parameter.name]
                if parameter.log:
                    new = old * float(np.exp(np.clip(step, -MOST_LOG_STEP, MOST_LOG_STEP)))
                    unsure[name][parameter.name] = new * doubt
                else:
                    most = max(3.0 * abs(parameter.prior_scale), abs(old - parameter.neutral))
                    new = old + float(np.clip(step, -most, most))
                    unsure[name][parameter.name] = doubt
                values[name][parameter.name] = float(np.clip(new, parameter.low, parameter.high))
        result.append(replace(one, values=values, sigma=unsure))
    return tuple(result), quiet
