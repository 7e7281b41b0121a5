"""What every effect must fulfil, ours and other people's: `faults` finds nothing in a good one.

Only NumPy is needed, no solver: what an effect is given here is made up, but of the right kind.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from copy import deepcopy
from dataclasses import fields, is_dataclass, replace
from functools import partial
from typing import TypeVar, get_args, get_type_hints

import numpy as np

from model.effects.interface import (
    AcquisitionTimes,
    BeamProblem,
    Effect,
    EffectParameter,
    LoadCellInput,
)
from model.effects.methods import faults_of_answer, faults_of_calls
from model.locations import locations
from model.locations.examples import (
    example_beam,
    example_clock,
    example_points,
    example_pulse,
    example_weighed,
)
from model.measurements import FloatArray
from model.plugins import first_faults

WORDS = ("meaning", "form", "signature", "isolates", "source")
ACTIONS = ("beam", "course", "lagging", "force", "curve", "in_image")
MOST_LAGGING = 9
CHANNEL_VALUES = (21.0, 57.0)  # first and last of every further channel, whatever its unit
Given = TypeVar("Given", AcquisitionTimes, LoadCellInput)
LARGEST_FACTOR = 10.0  # by which an effect of plausible size changes the EIBM or a stiffness
LARGEST_FORCE_N = 0.05  # that one adds
_SCALED = {"beam.eibm": "EIBM", "beam.soft": "compliance", "beam.stiffness": "stiffness"}
_AWAY = " without contact"
RISE_S = 0.1  # of the voltage, where pictures are taken
_FORM_COORDINATES = get_args(get_args(get_type_hints(Effect)["form_error_along"])[0])


def faults(effect: object) -> list[str]:
    """Return the faults of an effect, a sentence each without its full stop; none: it conforms.

    Later checks may depend on earlier ones, so the first faults end it.
    """
    if not isinstance(effect, Effect):
        return [f"it is of type {type(effect).__name__}, not a model.effects.Effect"]
    checks = (faults_of_form, _can_be_called, *_CHECKS)
    return first_faults(partial(check, effect) for check in checks)


def faults_of_form(effect: Effect) -> list[str]:
    """Return the faults of its description; no code of the effect runs."""
    every: object = effect.parameters
    if not (isinstance(every, tuple) and all(isinstance(one, EffectParameter) for one in every)):
        return ["its parameters must be a tuple of EffectParameter"]
    return [
        *_faults_of_words(effect),
        *(fault for one in effect.parameters for fault in _faults_of_parameter(one)),
        *(fault for one in effect.parameters[:1] for fault in _faults_of_amplitude(one)),
    ]


def neutral(effect: Effect) -> dict[str, float]:
    """Values at which the effect is absent: its size neutral, its shapes any of those tried."""
    return {**plausible(effect), effect.amplitude.name: effect.amplitude.neutral}


def plausible(effect: Effect) -> dict[str, float]:
    """Return values at which the effect would surprise nobody."""
    shapes = {
        parameter.name: float(parameter.starting_values[0])
        for parameter in effect.parameters[1:]
        if parameter.starting_values
    }
    return {**{parameter.name: parameter.prior_scale for parameter in effect.parameters}, **shapes}


def acts(effect: Effect) -> set[str]:
    """Return the methods through which it acts."""
    return {name for name in ACTIONS if getattr(type(effect), name) is not getattr(Effect, name)}


# ------------------------------------------------------------------------------------------- form


def _faults_of_words(effect: Effect) -> Iterator[str]:
    if not (isinstance(effect.name, str) and effect.name.isidentifier()):
        yield f"its name {effect.name!r} must be one word of letters, digits and underscores"
    for name in WORDS:
        text = getattr(effect, name)
        if not (isinstance(text, str) and text.strip()):
            yield f"its {name} is empty"
    if effect.location not in locations():
        yield f"its location {effect.location!r} is none of {', '.join(locations())}"
    if not isinstance(effect.form_error_along, tuple):  # other people's may be anything
        yield 'its form_error_along must be a tuple, as ("voltage",)'  # type: ignore[unreachable]
    elif unknown := sorted(set(effect.form_error_along) - set(_FORM_COORDINATES)):
        yield (
            f"its form differs along {', '.join(unknown)}, which is none of"
            f" {', '.join(_FORM_COORDINATES)}"
        )
    if effect.explained_by_dynamics not in (True, False):
        yield "its explained_by_dynamics is neither True nor False"
    if not effect.parameters:
        yield "it has no parameter that says how much of it there is"
    if len({parameter.name for parameter in effect.parameters}) < len(effect.parameters):
        yield "two of its parameters have the same name"
    if not all(isinstance(name, str) and name.isidentifier() for name in effect.channels):
        yield "its channels are not a list of names with units, such as humidity_percent"
    if not acts(effect):
        yield f"it overrides none of {', '.join(ACTIONS)}, so it changes nothing"


def _faults_of_parameter(parameter: EffectParameter) -> Iterator[str]:
    low, high = parameter.low, parameter.high
    inside = [parameter.prior_scale, *parameter.starting_values]
    if not all(isinstance(value, int | float) for value in inside):
        yield f"{parameter.name}: {inside} must be numbers"
        return
    if not all(np.isfinite(v) and low <= v <= high for v in inside):
        yield f"{parameter.name}: {inside} must lie between {low:g} and {high:g}"
    if parameter.log and not (parameter.low > 0.0):
        yield f"{parameter.name}: its lower bound must be positive, as its logarithm is refined"
    if parameter.prior_scale == parameter.neutral and not parameter.starting_values:
        yield f"{parameter.name}: its plausible value is the neutral one"


def _faults_of_amplitude(amplitude: EffectParameter) -> Iterator[str]:
    """Yield a scale of the wrong sign; a shape is one of several values, and may have any."""
    scale = amplitude.prior_scale
    if isinstance(scale, int | float) and scale < 0.0 < amplitude.high:
        yield (
            f"{amplitude.name}: its prior_scale {scale:g} must be above 0, as it is the width of"
            " its prior; expected_sign says which sign it has"
        )


# -------------------------------------------------------------------------------------- behaviour

Results = dict[str, FloatArray]
STRETCHED = 0.3  # change of a length, and movement along the curve, over the movement's size
GIVEN = "changed what it was given"  # a result beside those that an effect makes


def _results(effect: Effect, p: Mapping[str, float], *, touched: bool = True) -> Results:
    """Everything the effect makes of the examples, named; what it leaves alone is not in it."""
    beam, contact = example_beam(touched=touched)
    beam.clock = _recorded(effect, beam.clock)
    run, pulse = _recorded(effect, example_clock()), _recorded(effect, example_pulse())
    weighed, points = _recorded(effect, example_weighed(touched=touched)), example_points()
    given = (beam, contact, run, pulse, weighed, points)
    kept = deepcopy(given)
    found: Results = {}
    if "beam" in acts(effect):
        other = effect.beam(beam, contact, p)
        found |= _arrays(other)
    for number, (shape, much) in enumerate(effect.lagging(beam, contact, p)):
        found |= {f"shape {number} that lags": shape, f"how much of shape {number}": much}
    for name, clock in (("run", run), ("pulse", pulse)):
        if (course := effect.course(clock, p)) is not None:
            found |= {f"EIBM in a {name}": course[0], f"stiffness in a {name}": course[1]}
    if (added := effect.force(weighed, p)) is not None:
        found["force"] = added
    if (moved := effect.curve(points, p)) is not None:
        found |= {"curve's x": moved[0], "curve's y": moved[1]}
    if (seen := effect.in_image(replace(run, rise_s=RISE_S), p)) is not None:
        found["EIBM in pictures"] = seen
    spoilt = not all(_same(a, b) for a, b in zip(kept, given, strict=True))
    found[GIVEN] = np.array([float(spoilt)])
    return found


def _can_be_called(effect: Effect) -> Iterator[str]:
    yield from faults_of_calls(effect, (*ACTIONS, "derived"))


def _returns_what_it_must(effect: Effect) -> Iterator[str]:
    beam, contact = example_beam()
    beam.clock = _recorded(effect, beam.clock)
    run, p = _recorded(effect, example_clock()), plausible(effect)
    arguments = {
        "beam": (beam, contact),
        "course": (run,),
        "lagging": (beam, contact),
        "force": (_recorded(effect, example_weighed()),),
        "curve": (example_points(),),
        "in_image": (replace(run, rise_s=RISE_S),),
    }
    for name in sorted(acts(effect)):
        made: object = getattr(effect, name)(*arguments[name], p)
        yield from faults_of_answer(name, made)


def _recorded(effect: Effect, given: Given) -> Given:
    """Return an example with values of the channels that the effect reads."""
    values = np.linspace(*CHANNEL_VALUES, len(given.voltage_V))
    return replace(given, channels=dict.fromkeys(effect.channels, values))


def _same(one: object, two: object) -> bool:
    """Return whether two examples are equal, number by number."""
    if isinstance(one, Mapping) and isinstance(two, Mapping):
        return one.keys() == two.keys() and all(_same(one[name], two[name]) for name in one)
    if not is_dataclass(one):
        return bool(np.array_equal(np.asarray(one), np.asarray(two), equal_nan=True))
    return all(
        _same(getattr(one, f.name), getattr(two, f.name))
        for f in fields(one)
        if f.name != "sheet"
    )  # fmt: skip


def _untouched() -> Results:
    """Return what the examples are without any effect, under the names of `_results`."""
    beam, _ = example_beam()
    points = example_points()
    nothing = {
        "force": example_weighed().force_N,
        "curve's x": points.x_m,
        "curve's y": points.y_m,
        "EIBM in pictures": np.zeros_like(example_clock().voltage_V),
        GIVEN: np.zeros(1),
    }
    for name, clock in (("run", example_clock()), ("pulse", example_pulse())):
        nothing |= {f"EIBM in a {name}": clock.run_s, f"stiffness in a {name}": clock.run_s}
    found = {name: np.zeros_like(values) for name, values in nothing.items()}
    for number in range(MOST_LAGGING):
        found[f"shape {number} that lags"] = np.zeros_like(beam.eibm)
        found[f"how much of shape {number}"] = np.zeros(len(beam.reading_of))
    return found | _arrays(beam)


def _arrays(beam: BeamProblem) -> Results:
    """Return the arrays of a beam that an effect may change."""
    kept = ("sheet", "s_m", "piece_m", "clock", "reading_of", "share")
    return {f"beam.{f.name}": getattr(beam, f.name) for f in fields(beam) if f.name not in kept}


def _is_absent_when_neutral(effect: Effect) -> Iterator[str]:
    before, there = _untouched(), _results(effect, plausible(effect))
    at = f"at {effect.amplitude.name} = {effect.amplitude.neutral:g}"
    for name, values in _results(effect, neutral(effect)).items():
        if name == GIVEN:
            continue
        much = float(np.nanmax(np.abs(there[name] - before[name])))
        if not np.nanmax(np.abs(values - before[name])) <= 1e-9 * much:
            yield f"{at} it still changes the {name}"


def _is_there_when_plausible(effect: Effect) -> Iterator[str]:
    before, after = _untouched(), _results(effect, plausible(effect))
    if all(np.array_equal(after[n], before[n], equal_nan=True) for n in after if n != GIVEN):
        yield f"at {effect.amplitude.name} = {effect.amplitude.prior_scale:g} it changes nothing"


def _keeps_shapes_and_is_finite(effect: Effect) -> Iterator[str]:
    """Yield each fault once, with the values at which it was found first."""
    found: dict[str, list[Mapping[str, float]]] = {}
    for touched in (True, False):
        for p in _everywhere(effect):
            for said in _faults_at(effect, p, touched=touched):
                if touched or said.replace(_AWAY, "") not in found:
                    found.setdefault(said, []).append(p)
    for said, where in found.items():
        more = len(where) - 1
        yield f"{said} at {dict(where[0])}" + (f" (and {more} more cases)" if more else "")


def _faults_at(effect: Effect, p: Mapping[str, float], *, touched: bool) -> Iterator[str]:
    before = _untouched()
    for name, values in _results(effect, p, touched=touched).items():
        what = f"the {name}" + ("" if touched else _AWAY)
        if np.shape(values) != np.shape(before[name]):
            yield f"{what} has shape {np.shape(values)}, not {np.shape(before[name])}"
        elif name != "beam.stated_m" and not np.all(np.isfinite(values)):
            yield f"{what} is not finite"


def _is_of_plausible_size(effect: Effect) -> Iterator[str]:
    """Yield what changes far more than anybody would call plausible: another unit, probably."""
    before, after = _untouched(), _results(effect, plausible(effect))
    for name, values in after.items():
        size = float(np.nanmax(np.abs(values)))
        at = "at its plausible size it"
        if name in _SCALED:
            factor = size / float(np.nanmax(np.abs(before[name])))
        elif name.startswith(("EIBM in", "stiffness in")):  # relative changes
            factor = 1.0 + size
        else:
            if name == "force" and size > LARGEST_FORCE_N:
                yield f"{at} adds {size:g} N to the force: is it in mN?"
            continue
        if factor > LARGEST_FACTOR:
            yield f"{at} changes the {_SCALED.get(name, name)} by a factor of {factor:.0f}"


def _changes_nothing_it_was_given(effect: Effect) -> Iterator[str]:
    if np.any(_results(effect, plausible(effect))[GIVEN]):
        yield "it changes the arrays that it was given"


def _does_not_remember(effect: Effect) -> Iterator[str]:
    first, again = (_results(effect, plausible(effect)) for _ in range(2))
    if not all(np.array_equal(first[name], again[name], equal_nan=True) for name in first):
        yield "it gives another answer when it is asked again"


def _derives_what_it_names(effect: Effect) -> Iterator[str]:
    derived = effect.derived(plausible(effect), example_beam()[0].sheet)
    if set(derived) != set(effect.extra):
        yield f"it derives {sorted(derived)}, but names the units of {sorted(effect.extra)}"
    elif not all(np.isfinite(value) for value in derived.values()):
        yield "what it derives is not finite"


def _everywhere(effect: Effect) -> Iterator[dict[str, float]]:
    """Plausible values; then, one by one, whatever is tried, and a step to either side."""
    start = plausible(effect)
    yield start
    for parameter in effect.parameters:
        step = 0.05 * parameter.prior_scale
        for value in (
            *parameter.starting_values,
            parameter.prior_scale + step,
            parameter.prior_scale - step,
        ):
            yield {**start, parameter.name: float(value)}
    if np.isfinite(effect.amplitude.neutral):
        yield {
            **start,
            effect.amplitude.name: effect.amplitude.neutral - 1e-3 * effect.amplitude.prior_scale,
        }


def _says_whether_it_stretches_curves(effect: Effect) -> Iterator[str]:
    points = example_points()
    moved = effect.curve(points, plausible(effect))
    if moved is None:
        return
    size = float(np.sqrt(np.mean(moved[0] ** 2 + moved[1] ** 2)))
    along = moved[0] * points.normal_y - moved[1] * points.normal_x  # the tangent is (n_y, -n_x)
    before, after = (_lengths(points.x_m + a, points.y_m + b) for a, b in ((0.0, 0.0), moved))
    longer, aside = float(np.max(np.abs(after - before))), float(np.sqrt(np.mean(along**2)))
    if not effect.moves_along_sheet and longer > STRETCHED * size and aside > STRETCHED * size:
        yield "it moves points along the sheet and makes curves longer: set moves_along_sheet"
    if effect.moves_along_sheet and longer < 0.1 * STRETCHED * size:
        yield "curves are as long as before: moves_along_sheet must not be set"


def _lengths(x_m: FloatArray, y_m: FloatArray) -> FloatArray:
    """Return the length of each curve, its points being in the last axis."""
    return np.asarray(np.sum(np.hypot(np.diff(x_m), np.diff(y_m)), axis=-1))


_CHECKS: tuple[Callable[[Effect], Iterator[str]], ...] = (
    _returns_what_it_must,
    _keeps_shapes_and_is_finite,
    _is_absent_when_neutral,
    _is_there_when_plausible,
    _changes_nothing_it_was_given,
    _does_not_remember,
    _derives_what_it_names,
    _says_whether_it_stretches_curves,
    _is_of_plausible_size,
)
