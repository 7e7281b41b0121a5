"""What the hooks of effects do: the one place that interprets them.

Prediction and inference both go through here, the first for the readings of a typical run, the
second for those that were taken. A further hook is read here, and nowhere else.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from model.effects.interface import (
    AcquisitionTimes,
    BeamProblem,
    ContactSolution,
    Effect,
    ImagePoints,
    LoadCellInput,
    Values,
)
from model.effects.sliding import slid
from model.measurements import FloatArray, load_scale
from model.sheet.form import Form

MOST_LOST = 0.95  # of EIBM and stiffness
LEAST_SOFT = 0.05  # of the compliance, that an inferred form may leave
MOST_KEPT = 256  # courses of the same times
DAMPED_AFTER = 15  # rounds; by then a plain repetition swings
ALONG_SHEET = ("rest", "eibm", "bend", "soft")
OF_CONDITIONS = ("stiffness", "elongation_soft", "shift_m", "tilt_rad", "offset_m", "reach_m")
ALL_FIELDS = (*ALONG_SHEET, *OF_CONDITIONS)
# the size that matters; else 1
LEAST = {"stiffness": 0.0, "shift_m": 1e-2, "offset_m": 1e-2, "reach_m": 1e-2}
Index = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Acting:
    """An effect with its numbers for one configuration."""

    effect: Effect
    values: Values
    form: Form | None = None  # where it differs from the catalogue's
    across_curve: bool = False  # of the camera: it moves points across the curve alone


class Solved(Protocol):
    """Whatever solving a `BeamProblem` gives."""

    @property
    def contact(self) -> ContactSolution:
        """Where the sheet touches, and its shape."""


AnySolved = TypeVar("AnySolved", bound=Solved)


# -- the course in time


def course(one: Acting, clock: AcquisitionTimes) -> tuple[FloatArray, FloatArray] | None:
    """Return the relative change of EIBM and stiffness at each time; the EIBM's only under voltage.

    None: the effect has no course in time.
    """
    found = _catalogue_course(one, clock)
    if found is None:
        return None
    eibm, stiffness = found
    if one.form is not None:
        factor, times = (
            one.form.of_readings(clock),
            {"session": clock.session, "run_s": clock.run_s},
        )
        eibm = factor * eibm + one.form.added("EIBM", **times)
        stiffness = factor * stiffness + one.form.added("stiffness", **times)
    return np.where(clock.voltage_V != 0.0, eibm, 0.0), np.asarray(stiffness, dtype=float)


def _catalogue_course(one: Acting, clock: AcquisitionTimes) -> tuple[FloatArray, FloatArray] | None:
    """Return the course in the catalogue's form; that of the same times is worked out once."""
    if not one.values:  # a free effect, made anew for each form
        return one.effect.course(clock, one.values)
    kept, key = clock.worked_out, (id(one.effect), *one.values.items())
    of, found = kept.get(key, (None, None))
    if of is not one.effect:
        found = one.effect.course(clock, one.values)
        if len(kept) >= MOST_KEPT:
            kept.clear()
        kept[key] = one.effect, found  # with the effect, so that nothing else can have its identity
    result: tuple[FloatArray, FloatArray] | None = found
    return result


def mean_course(
    acting: Sequence[Acting], clock: AcquisitionTimes, of: Index, share: FloatArray, count: int
) -> tuple[FloatArray, FloatArray]:
    """Return the relative change of EIBM and stiffness in the mean of each of `count` conditions.

    `of` says of which condition each time is, `share` how much it counts in the mean.
    """
    eibm, stiffness = np.zeros(count), np.zeros(count)
    for one in acting:
        found = course(one, clock)
        if found is not None:
            eibm += np.bincount(of, share * found[0], count)
            stiffness += np.bincount(of, share * found[1], count)
    return np.maximum(eibm, -MOST_LOST), np.maximum(stiffness, -MOST_LOST)


def in_course(beam: BeamProblem, eibm: FloatArray, stiffness: FloatArray) -> BeamProblem:
    """Return the problems with EIBM and stiffness as a course in time has them in the mean."""
    if not (np.any(eibm) or np.any(stiffness)):
        return beam
    share = (1.0 + eibm) / (1.0 + stiffness)
    return replace(
        beam, eibm=beam.eibm * share[:, None], stiffness=beam.stiffness * (1.0 + stiffness)
    )


def image_change(acting: Sequence[Acting], clock: AcquisitionTimes) -> FloatArray | None:
    """Return the relative change of the EIBM in the image of a reading; None: it is no older."""
    seen = []
    for one in acting:
        change = one.effect.in_image(clock, one.values)
        if change is not None:
            seen.append(change if one.form is None else change * one.form.of_readings(clock))
    return np.asarray(np.sum(seen, axis=0)) if seen else None


def lagging(
    one: Acting, beam: BeamProblem, contact: ContactSolution
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield shapes that lag (K, G), 1/m, each with how much of it there is at each reading (n,)."""
    for shape, much in one.effect.lagging(beam, contact, one.values):
        yield shape, much if one.form is None else much * one.form.of_readings(beam.clock)


# -- the beam problem


def applied(beam: BeamProblem, contact: ContactSolution, acting: Sequence[Acting]) -> BeamProblem:
    """Return the problem with the effects in it, given a solution."""
    for one in acting:
        changed = one.effect.beam(beam, contact, one.values)
        beam = changed if one.form is None else _formed(beam, changed, contact, one.form)
    return beam


def _formed(
    before: BeamProblem, after: BeamProblem, contact: ContactSolution, form: Form
) -> BeamProblem:
    """Return an effect's change times the factors of the inferred form.

    Along the sheet these are factors on compliance and curvature without load. The moment follows
    from them: as a product with the compliance it would not be in proportion to the factor.
    """
    factor, whole = form.along_sheet(before, contact), form.of_conditions(before)
    changed: dict[str, Any] = {name: _between(before, after, name, whole) for name in OF_CONDITIONS}
    changed |= {name: _between(before, after, name, factor) for name in ("rest", "eibm", "soft")}
    changed["soft"] = np.maximum(changed["soft"], LEAST_SOFT * before.soft)
    free, other = ((one.eibm + one.bend) * one.soft for one in (before, after))
    bend = (free + (other - free) * factor) / changed["soft"] - changed["eibm"]
    return replace(after, bend=bend, **changed)


def _between(before: BeamProblem, after: BeamProblem, name: str, factor: FloatArray) -> FloatArray:
    old, new = getattr(before, name), getattr(after, name)
    return np.asarray(old if new is old else old + (new - old) * factor)


def self_consistent(
    base: BeamProblem,
    change: Callable[[BeamProblem, ContactSolution], BeamProblem],
    solve: Callable[[BeamProblem], AnySolved],
    *,
    rounds: int,
    accuracy: float,
) -> tuple[BeamProblem, AnySolved, bool]:
    """Solve and `change` the base in turn until nothing moves; whether it came to that.

    Some effects depend on the solution: a clamp that gives way under the load.
    """
    beam, found = base, solve(base)
    for turn in range(rounds):
        new = change(base, found.contact)
        if turn >= DAMPED_AFTER:
            new = _halfway(beam, new)
        if _same(beam, new, accuracy):
            return beam, found, True
        beam, found = new, solve(new)
    return beam, found, False


def _same(one: BeamProblem, other: BeamProblem, accuracy: float) -> bool:
    """Whether nothing that matters differs."""
    for name in ALL_FIELDS:
        a, b = getattr(one, name), getattr(other, name)
        if a is b:
            continue
        size = float(np.max(np.abs(b), initial=0.0))
        if np.max(np.abs(a - b), initial=0.0) > accuracy * max(size, LEAST.get(name, 1.0)):
            return False
    return True


def _halfway(one: BeamProblem, other: BeamProblem) -> BeamProblem:
    return replace(
        one, **{name: 0.5 * (getattr(one, name) + getattr(other, name)) for name in ALL_FIELDS}
    )


# -- load cell and camera


def load_cell_input(
    beam: BeamProblem, contact: ContactSolution, clock: AcquisitionTimes, of: Index
) -> LoadCellInput:
    """Return what the load cell is given at readings, each of the condition that `of` says."""
    return LoadCellInput(
        force_N=np.nan_to_num(contact.force_N[of]), normal_N=np.nan_to_num(contact.normal_N[of]),
        gamma_rad=np.nan_to_num(contact.gamma_rad[of]), position_m=beam.stated_m[of],
        voltage_V=clock.voltage_V, session=clock.session,
        touching=np.isfinite(contact.force_N[of]).astype(float),
        wetted_s=np.broadcast_to(clock.wetted_s, of.shape), slid=slid(beam, contact)[of],
        run_s=np.broadcast_to(clock.run_s, of.shape),
        pulse_s=np.broadcast_to(clock.pulse_s, of.shape),
        session_number=np.broadcast_to(beam.session_number, beam.voltage_V.shape)[of],
        overall=np.broadcast_to(clock.overall, of.shape), channels=clock.channels,
        force_scale=load_scale(beam.sheet, beam.stiffness),
    )  # fmt: skip


def added_force_N(acting: Sequence[Acting], weighed: LoadCellInput, in_time: Index) -> FloatArray:
    """Return what the load cell adds to each reading, (n,); `in_time` is the order of time."""
    result = np.zeros(len(in_time))
    hooked = [one for one in acting if type(one.effect).force is not Effect.force]
    if not hooked:
        return result
    ordered = weighed.in_order(in_time)
    for one in hooked:
        added = one.effect.force(ordered, one.values)
        if added is None:
            continue
        if one.form is not None:
            added = one.form.of_forces(ordered) * added
            added = added + one.form.added("force", session=ordered.session, run_s=ordered.run_s)
        result[in_time] += np.asarray(added)
    return result


def image_displacement_m(
    acting: Sequence[Acting], points: ImagePoints
) -> tuple[FloatArray, FloatArray]:
    """Return what the camera adds to the points' x and y, (K, S)."""
    dx, dy = np.zeros_like(points.x_m), np.zeros_like(points.y_m)
    for one in acting:
        added = one.effect.curve(points, one.values)
        if added is not None:
            share = 1.0 if one.form is None else one.form.of_points(points)
            more_x, more_y = share * added[0], share * added[1]
            if one.across_curve:
                across = more_x * points.normal_x + more_y * points.normal_y
                more_x, more_y = across * points.normal_x, across * points.normal_y
            dx, dy = dx + more_x, dy + more_y
    return dx, dy
