"""Ways in which the form of an effect may differ from the catalogue's.

No formula is nature's. So an effect is its form times (1 + a smooth deviation): along the sheet,
from voltage to voltage, along the arc, in time, or from one configuration to the other, whichever
it depends on; with a standard deviation of about a third, and integrated over.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import zip_longest

import numpy as np

from model.effects.interface import Along, ContactSolution, Effect
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.model_state import ModelState
from model.identification.likelihood.row_index import RowBlock
from model.locations.quantities import Perturbation
from model.measurements import FloatArray
from model.measurements.pulse_train import PULSE_S
from model.sheet.beam_problem import Adds, Coordinate, Profile, Under

FORM = 0.35  # standard deviation of the deviation along the coordinate that an effect depends on
SIGN = 0.25  # and from one voltage or configuration to the other
FALLS = -0.6  # power with which waves along the sheet grow smaller
WAVES = ((1, 0.8), (2, 0.6))  # along other coordinates
RUN = 0.5  # from run to run
HELD = 0.9  # at 0 V, of what goes by how the sheet came there
OWN = 1.0  # where each configuration may have its own size
PULSE_WAVES = SLOW_WAVES = (1, 2, 3)
NODES = 51  # of a term that was inferred
LEAST_V = 1e-6  # that is a voltage


Terms = Callable[[], tuple[Profile, ...]]


@dataclass(frozen=True)
class Way:
    """A way in which a form may differ in one configuration."""

    step: Perturbation
    share: float  # its standard deviation
    # terms of a model that have it, for a deviation of one; none: it is a matter of single runs
    terms: Terms = tuple


Ways = Iterator[Way]


def deviations(
    effect: Effect, forward: ForwardModel, c: int, step: Perturbation, contact: ContactSolution
) -> Ways:
    """Yield the perturbations by which the form may differ, each with its standard deviation."""
    configuration_model = forward.configuration_models[c]
    for along in effect.form_error_along:
        if along == "s":
            waves = waves_along(effect.waves)
            u, most = (
                configuration_model.s_m / configuration_model.length,
                configuration_model.length,
            )
            yield from _along_sheet(forward, c, step, u, waves, _Span("s", 0.0, most))
        elif along == "curvature":
            bent = np.abs(contact.curvature - configuration_model.rest(configuration_model.s_m))
            most = max(float(np.max(bent)), 1e-9)
            span = _Span("curvature", 0.0, most)
            yield from _along_sheet(forward, c, step, bent / most, WAVES, span)
        elif along == "position":
            u, span = (
                unit(configuration_model.stated_m),
                _Span("position", *_ends(configuration_model.stated_m)),
            )
            for j, share in WAVES:
                yield Way(_weighed(forward, c, step, cosine(j, u)), FORM * share, span.wave(j))
        elif along == "voltage":
            driven = np.sign(configuration_model.voltage_V)
            at_zero = any(np.any(step_of[driven == 0.0]) for step_of in (step.beam, step.points_m))
            at_zero = at_zero or bool(
                np.any(step.force_N[driven[forward.row_block(c).reading_of] == 0.0])
            )
            for wave in (driven, np.where(driven == 0.0, -1.0, 0.5)):
                terms = partial(_at_voltages, configuration_model.voltage_V, wave, at_zero=at_zero)
                yield Way(_weighed(forward, c, step, wave), SIGN, terms)
        elif along in _SLOW:
            yield from _in_time(forward, c, step, along)
        elif along in _OF_RUNS:
            yield from _OF_RUNS[along](forward, c, step)
        elif along == "place":
            most = np.maximum(configuration_model.curve_s.max(axis=1, keepdims=True), 1e-12)
            span = _Span("s", 0.0, float(np.max(most)))
            for j, share in WAVES:
                points = step.points_m * cosine(j, configuration_model.curve_s / most)
                way = replace(forward.no_step(c), points_m=points)
                yield Way(way, FORM * share, span.wave(j))


@dataclass(frozen=True)
class _Span:
    """A coordinate from one end to the other."""

    along: Coordinate
    low: float
    high: float
    under: Under = ""

    def wave(self, j: int, size: float = 1.0, adds: Adds = "") -> Terms:
        """Return what makes the term that is a wave along it."""
        return partial(self._wave, j, size, adds)

    def _wave(self, j: int, size: float, adds: Adds) -> tuple[Profile, ...]:
        def value(t: FloatArray) -> FloatArray:
            return size * cosine(j, t)

        return (sampled(value, self.along, self.low, self.high, under=self.under, adds=adds),)


def sampled(
    function: Callable[[FloatArray], FloatArray],
    along: Coordinate,
    low: float,
    high: float,
    *,
    nodes: int = NODES,
    unit: str = "",
    under: Under = "",
    adds: Adds = "",
) -> Profile:
    """Return a function of a coordinate, brought to 0 .. 1, as straight lines."""
    t = np.linspace(0.0, 1.0, nodes) if nodes > 1 and high > low else np.full(1, 0.5)
    return Profile(
        along=along, at=tuple((low + t * (high - low)).tolist()),
        values=tuple(function(t).tolist()), sigma=(0.0,) * len(t), unit=unit, under=under,
        adds=adds,
    )  # fmt: skip


def _at_voltages(voltage_V: FloatArray, wave: FloatArray, *, at_zero: bool) -> tuple[Profile, ...]:
    """Return a wave as a function of the voltage; of what is absent at 0 V that of its sign."""
    volts, first = np.unique(voltage_V, return_index=True)
    values = wave[first]
    if not at_zero:
        volts, values = volts[volts != 0.0], values[volts != 0.0]
        signs = [sign for sign in (-1.0, 1.0) if np.any(np.sign(volts) == sign)]
        near = [float(values[np.sign(volts) == sign][0]) for sign in signs]
        volts, values = np.append(volts, LEAST_V * np.array(signs)), np.append(values, near)
        order = np.argsort(volts)
        volts, values = volts[order], values[order]
    return (
        Profile(
            along="voltage", at=tuple(volts.tolist()), values=tuple(values.tolist()),
            sigma=(0.0,) * len(volts), unit="",
        ),
    )  # fmt: skip


def _ends(values: FloatArray) -> tuple[float, float]:
    good = values[np.isfinite(values)]
    return (float(good.min()), float(good.max())) if len(good) else (0.0, 0.0)


def _from_run_to_run(forward: ForwardModel, c: int, step: Perturbation) -> Ways:
    """Yield differences between runs, such as the distance of frames from edges."""
    own = [one.run for one in forward.data_vectors[c].seen]
    for run in forward.row_index.runs:
        factor = np.array([float(each == run) for each in own])
        yield Way(_weighed(forward, c, step, factor), RUN)


def _held_at_zero(forward: ForwardModel, c: int, step: Perturbation) -> Ways:
    """Yield factors at 0 V, after each side of approach: what held the sheet there is not known."""
    configuration_model = forward.configuration_models[c]
    for way in (1.0, -1.0):
        here = (configuration_model.voltage_V == 0.0) & (configuration_model.up == way)
        yield Way(_weighed(forward, c, step, here.astype(float)), HELD)


def _at_each_polarity(forward: ForwardModel, c: int, step: Perturbation) -> Ways:
    """Yield a factor from one polarity to the other that the next sheet has the other way round."""
    if len(forward.names) < 2:
        return
    volts = forward.configuration_models[c].voltage_V
    wave = (1.0 if c == 0 else -1.0) * np.sign(volts)
    terms = partial(_at_voltages, volts, wave, at_zero=False)
    yield Way(_weighed(forward, c, step, wave), SIGN, terms)


_OF_RUNS: dict[Along, Callable[[ForwardModel, int, Perturbation], Ways]] = {
    "run": _from_run_to_run, "approach": _held_at_zero, "polarity": _at_each_polarity,
}  # fmt: skip


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
    span: _Span,
) -> Ways:
    """Yield changes of curvature and compliance times waves of u in 0 .. 1, (G,) or (K, G)."""
    G = forward.configuration_models[c].count
    for j, share in waves:
        beam = np.zeros_like(step.beam)
        beam[:, :G] = step.beam[:, :G] * cosine(j, u)
        beam[:, G : 2 * G] = step.beam[:, G : 2 * G] * cosine(j, u)
        yield Way(replace(forward.no_step(c), beam=beam), FORM * share, span.wave(j))


def _in_pulses(forward: ForwardModel, c: int, step: Perturbation) -> Ways:
    """Yield factors within a pulse."""
    for j, (wave, bins) in zip(PULSE_WAVES, _pulse_waves(forward.row_block(c)), strict=True):
        way = replace(
            forward.no_step(c), eibm=step.eibm * wave, stiffness=step.stiffness * wave,
            force_N=step.force_N * wave, bin_eibm=step.bin_eibm * bins,
            bin_stiffness=step.bin_stiffness * bins, frame_eibm=step.frame_eibm * wave,
        )  # fmt: skip
        yield Way(way, 0.6 * FORM / j, _Span("pulse", 0.0, PULSE_S, "voltage").wave(j))


def _pulse_waves(block: RowBlock) -> list[tuple[FloatArray, FloatArray]]:
    """Return waves over a pulse at readings, 0 where there is no voltage, and in parts of it."""
    kept = block.bin_clock.worked_out  # that is of one part only
    if "pulse waves" not in kept:
        driven = block.clock.voltage_V != 0.0
        kept["pulse waves"] = [
            (
                cosine(j, block.clock.pulse_s / PULSE_S) * driven,
                block.bin_mean(cosine(j, block.bin_clock.pulse_s / PULSE_S)),
            )
            for j in PULSE_WAVES
        ]
    waves: list[tuple[FloatArray, FloatArray]] = kept["pulse waves"]
    return waves


def _slow_waves(block: RowBlock, times: str) -> list[FloatArray]:
    """Return waves at readings over some of their times; none where all of these are equal."""
    kept = block.clock.worked_out
    key = ("slow waves", times)
    if key not in kept:
        t = unit(getattr(block.clock, times))
        kept[key] = [] if np.ptp(t) == 0.0 else [cosine(j, t) for j in SLOW_WAVES]
    waves: list[FloatArray] = kept[key]
    return waves


def _in_time(forward: ForwardModel, c: int, step: Perturbation, along: Along) -> Ways:
    """Yield changes within a pulse; over run or session something is added: drifts cross zero.

    What a sheet's data cannot show is no change, so that each way has its place in all sheets.
    """
    if along == "time":
        yield from _in_pulses(forward, c, step)
    block, none = forward.row_block(c), forward.no_step(c)
    driven = block.clock.voltage_V != 0.0
    dated = len(block.clock.pulse_s) > 0  # else shapes alone
    changes = (step.eibm, step.stiffness, step.force_N)
    size = [0.5 * float(np.ptp(v)) if dated else 0.0 for v in changes]
    shown = any(size) or bool(np.any(step.force_N))
    for over, times in _SLOW[along]:
        waves = _slow_waves(block, times) if shown else []
        force = step.force_N if over == "run" else size[2]
        span = _Span(over, *_ends(getattr(block.clock, times)))
        for j, wave in zip_longest(SLOW_WAVES, waves):
            if wave is None:
                yield Way(none, 0.6 * FORM / j)
                continue
            way = replace(
                none, eibm=size[0] * wave * driven, stiffness=size[1] * wave, force_N=force * wave
            )
            yield Way(way, 0.6 * FORM / j, partial(_slow_terms, span, j, size))


_SESSION: tuple[Coordinate, str] = ("session", "session")
_RUN: tuple[Coordinate, str] = ("run", "run_s")  # it begins as its sheet is wetted
_SLOW = {"time": (_SESSION, _RUN), "session": (_SESSION,), "wetted": (_RUN,)}


def _slow_terms(span: _Span, j: int, size: list[float]) -> tuple[Profile, ...]:
    """Return the terms of a wave over run or session; over the run a force has a factor."""
    parts: list[tuple[Adds, float]] = [("EIBM", size[0]), ("stiffness", size[1])]
    parts.append(("force", size[2]) if span.along == "session" else ("", 1.0))
    return tuple(term for adds, much in parts if much for term in span.wave(j, much, adds)())


def cosine(j: int, t: FloatArray) -> FloatArray:
    """Return a wave of unit mean square on a coordinate 0 .. 1."""
    result: FloatArray = np.sqrt(2.0) * np.cos(j * np.pi * np.clip(t, 0.0, 1.0))
    return result


def _weighed(forward: ForwardModel, c: int, step: Perturbation, wave: FloatArray) -> Perturbation:
    """Return a step times a factor (K,) for each condition."""
    block = forward.row_block(c)
    by_reading, by_bin, by_row = wave[block.reading_of], wave[block.bin_of], wave[:, None]
    factors = {
        "beam": by_row, "eibm": by_reading, "stiffness": by_reading, "force_N": by_reading,
        "bin_eibm": by_bin, "bin_stiffness": by_bin, "points_m": by_row, "frame_eibm": by_reading,
    }  # fmt: skip
    none = forward.no_step(c)
    # nothing stays the same nothing, so that it costs nothing
    changed = {
        name: getattr(step, name) * factor
        for name, factor in factors.items()
        if getattr(step, name) is not getattr(none, name)
    }
    return replace(none, **changed)


def unit(values: FloatArray) -> FloatArray:
    """Finite values brought to 0 .. 1; the middle where there is none, or no difference."""
    good = values[np.isfinite(values)]
    span = float(np.ptp(good)) if len(good) else 0.0
    if span == 0.0:
        return np.full_like(values, 0.5)
    share: FloatArray = np.nan_to_num((values - good.min()) / span, nan=0.5)
    return share


@dataclass(frozen=True)
class WayColumn:
    """A way of all configurations: its rows (N,), and its terms by configuration."""

    rows: FloatArray
    share: float
    terms: dict[str, Terms]
    between_sheets: bool = False  # all of the effect is larger in one sheet than in the next


def atoms(
    forward: ForwardModel, states: tuple[ModelState, ...], effect: Effect,
    steps: list[Perturbation], *,
    tolerant: bool = True,
) -> FloatArray:  # fmt: skip
    """Return the form itself, and its deviations times their standard deviations: (N, 1 + J)."""
    if not tolerant:
        rows = [forward.rows_of(c, states[c], step) for c, step in enumerate(steps)]
        return np.stack([np.sum(rows, axis=0)], axis=1)
    whole, ways = ways_of(forward, states, effect, steps)
    return np.stack([np.sum(whole, axis=0), *(one.rows for one in ways)], axis=1)


def ways_of(
    forward: ForwardModel, states: tuple[ModelState, ...], effect: Effect,
    steps: list[Perturbation],
) -> tuple[list[FloatArray], list[WayColumn]]:  # fmt: skip
    """Return the rows of each configuration's step, and the ways in which the form may differ.

    The same way in all configurations is one.
    """
    whole, ways = list[FloatArray](), list[WayColumn]()
    for c, step in enumerate(steps):
        found = list(deviations(effect, forward, c, step, states[c].solved.contact))
        itself, *every = forward.rows_of_each(c, states[c], [step, *(way.step for way in found)])
        whole.append(itself)
        for j, (way, rows) in enumerate(zip(found, every, strict=True)):
            rows *= way.share
            if j < len(ways):
                ways[j].terms[forward.names[c]] = way.terms
                np.add(ways[j].rows, rows, out=ways[j].rows)
            else:
                ways.append(WayColumn(rows, way.share, {forward.names[c]: way.terms}))
    first = []
    if len(steps) > 1 and all(np.any(w) for w in whole) and not effect.of_the_rig:
        share = OWN if effect.by_configuration else SIGN
        signs = [1.0 if c == 0 else -1.0 for c in range(len(steps))]
        whole_rows = np.sum([s * w for s, w in zip(signs, whole, strict=True)], axis=0)
        signed: dict[str, Terms] = {
            n: partial(_constant, s) for n, s in zip(forward.names, signs, strict=True)
        }
        first.append(WayColumn(share * whole_rows, share, signed, between_sheets=True))
    return whole, [*first, *(w for w in ways if np.any(w.rows))]


def _constant(value: float) -> tuple[Profile, ...]:
    return (Profile(along="configuration", at=(0.0,), values=(value,), sigma=(0.0,), unit=""),)
