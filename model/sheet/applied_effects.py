"""Apply the catalogue's effects to the beam problem of a `SheetModel`.

What they do to it is in `effect_hooks`; here are a model's own conditions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.effects import Effect, catalogue
from model.effects.between_sessions import sessions_for
from model.effects.interface import BeamProblem, ContactSolution, EffectParameter
from model.locations import location
from model.measurements import FloatArray, ModelError, RigScale, SheetGeometry
from model.mechanics.collocation import rule
from model.mechanics.field import Field, for_each_field
from model.sheet.beam_problem import UNKNOWN, ActiveEffect, ConditionProblem
from model.sheet.effect_hooks import Acting, applied, in_course, mean_course, self_consistent
from model.sheet.form import form_in
from model.sheet.free_effect import acting_with, free_effect
from model.sheet.solution import SolvedProblems, solved
from model.sheet.typical_run import kept_readings, typical_run

NODES = 14  # along the free length (each part of it), where effects are worked out
SHORTEST_PART = 1e-6  # of the free length, that is a part of its own
MOST_ROUNDS = 60
SETTLED = 1e-9


def acting(effects: Sequence[ActiveEffect], configuration: str) -> list[Acting]:
    """Return the effects that act in a configuration; raise `ModelError` for unusable ones."""
    result = []
    for one in effects:
        values = one.values(configuration)
        if values is not None:
            effect = effect_of(one)
            form = form_in(one.terms, configuration)
            own = acting_with(effect, _numbers(effect, values), form)
            result.append(replace(own, across_curve=one.across_curve))
    return result


def effect_of(one: ActiveEffect) -> Effect:
    """Return the catalogue's effect, or that of a location; raise `ModelError` without one."""
    if one.name == UNKNOWN:
        return free_effect(location(one.location))
    known = catalogue()
    if one.name not in known:
        whose = one.distribution
        raise ModelError(
            f"the model includes the effect '{one.name}'"
            + (f" of {whose}, which is not installed" if whose else ", unknown to this version")
        )
    effect = known[one.name]
    values = one.parameters or next(iter(one.by_configuration.values()), {})
    return effect.for_sessions(sessions_for(values)) or effect


def _numbers(effect: Effect, values: dict[str, float]) -> dict[str, float]:
    """Return a value for each parameter; parameters that only shape the form are optional."""
    result = {}
    for parameter in effect.parameters:
        if parameter.name not in values and parameter is effect.amplitude:
            raise ModelError(f"the effect '{effect.name}' of the model lacks its {parameter.name}")
        value = values.get(parameter.name, parameter.unstated)
        # lengths and forces have the bounds of their session, which a model does not know
        if not _has_size(parameter) and not parameter.low <= value <= parameter.high:
            raise ModelError(
                f"the effect '{effect.name}' of the model has {parameter.name} = {value:g}; it must"
                f" be within {parameter.low:g} and {parameter.high:g}"
            )
        result[parameter.name] = value
    return result


def _has_size(parameter: EffectParameter) -> bool:
    unit = parameter.scales_as or parameter.unit
    return RigScale(length=2.0, force=3.0).of_unit(unit) != 1.0


def with_effects(
    setups: Sequence[ConditionProblem],
    positions_m: Sequence[float | None],
    effects: Sequence[ActiveEffect],
) -> list[ConditionProblem]:
    """Setups of one configuration with the effects in them.

    Friction and the like look at the other voltages of the same position among the setups.
    """
    return with_acting(setups, positions_m, acting(effects, setups[0].sheet.configuration))


def with_acting(
    setups: Sequence[ConditionProblem],
    positions_m: Sequence[float | None],
    named: Sequence[Acting],
) -> list[ConditionProblem]:
    """Setups with effects, of which the numbers are known; raise `ModelError` without a solution.

    The effects and the solution are worked out in turn until nothing moves.
    """
    plain = beam_problem(setups, positions_m)
    course = mean_course(named, plain.clock, plain.reading_of, plain.share, len(setups))

    def change(base: BeamProblem, contact: ContactSolution) -> BeamProblem:
        return applied(base, contact, named)

    def solve(beam: BeamProblem) -> _Solved:
        found = solved(_setups(setups, plain, beam))
        return _Solved(found, contact_solution(found, beam))

    beam, _, settled = self_consistent(
        in_course(plain, *course), change, solve, rounds=MOST_ROUNDS, accuracy=SETTLED
    )
    if not settled:
        names = ", ".join(one.effect.name for one in named)
        raise ModelError(f"the model's effects ({names}) do not settle with its other parameters")
    return _setups(setups, plain, beam)


@dataclass(frozen=True)
class _Solved:
    """Equilibria as effects see them."""

    found: SolvedProblems
    contact: ContactSolution


# -- a model's conditions as beam problems, and back


def beam_problem(
    setups: Sequence[ConditionProblem], positions_m: Sequence[float | None]
) -> BeamProblem:
    """Return conditions of one configuration as effects see them, at times of typical runs."""
    sheet = setups[0].sheet
    breaks_m = _breaks(sheet, setups[0].measured_length_m)
    parts_m = np.diff(breaks_m)
    s = np.concatenate(
        [low + part * rule(NODES).c for low, part in zip(breaks_m, parts_m, strict=False)]
    )
    B = np.array([one.B_Nm2 for one in setups])
    voltages = [float(one.voltage_V) for one in setups]
    ratio = _opposite_ratios(setups)
    runs = [
        typical_run(v, -v, sheet.rise_time_s, np.nan if at is None else at, ratio[abs(v)])
        for v, at in zip(voltages, positions_m, strict=True)
    ]
    clock, of = kept_readings(runs, voltages)
    none = np.zeros(len(setups))
    ones = np.ones((len(setups), len(s)))
    return BeamProblem(
        sheet=sheet, s_m=s, voltage_V=np.array([one.voltage_V for one in setups]),
        stated_m=np.array([np.nan if p is None else p for p in positions_m]),
        up=np.ones(len(setups)), stiffness=B, rest=0.0 * ones,
        eibm=np.stack(for_each_field(lambda me: me(s), [one.eibm for one in setups])) / B[:, None],
        bend=0.0 * ones,
        soft=np.stack([ones[0] if c.softness is None else c.softness(s) for c in setups]),
        elongation_soft=none, shift_m=none.copy(),
        tilt_rad=np.array([one.clamp_rad for one in setups]),
        offset_m=np.array([one.offset_m for one in setups]),
        reach_m=np.array([one.reach_m for one in setups]),
        piece_m=np.concatenate([part * rule(NODES).b for part in parts_m]),
        clock=clock, reading_of=of, measured_length_m=setups[0].measured_length_m,
        share=1.0 / np.bincount(of)[of], upright=np.ones(len(setups)),
        session_number=np.array([float(one.session) for one in setups]),
    )  # fmt: skip


def _opposite_ratios(setups: Sequence[ConditionProblem]) -> dict[float, float]:
    """Return |EIBM(-)/EIBM(+)| at the clamp by the voltage's size; 1 where one is not known."""
    found = {float(one.voltage_V): abs(float(one.eibm(0.0))) for one in setups}
    result = dict.fromkeys(map(abs, found), 1.0)
    for volts, size in found.items():
        if volts > 0.0 and size > 0.0 and found.get(-volts, 0.0) > 0.0:
            result[volts] = found[-volts] / size
    return result


def _setups(
    setups: Sequence[ConditionProblem], plain: BeamProblem, beam: BeamProblem
) -> list[ConditionProblem]:
    """Return the setups with all differences of a beam from the plain one."""
    R = beam.sheet.arc_radius_m
    B, plain_B = beam.stiffness[:, None], plain.stiffness[:, None]
    induced = beam.eibm * B - plain.eibm * plain_B
    moment = induced + beam.bend * B - plain.bend * plain_B
    ratio = _opposite_ratios(setups)
    rest, soft = beam.rest - plain.rest, beam.soft - plain.soft
    one = Field.constant(1.0, beam.sheet.free_length_m)
    plus = _Sums(beam)
    result = []
    for k, setup in enumerate(setups):
        softness = setup.softness
        if np.any(soft[k]):
            softness = plus(softness or one, soft[k])
            if float(np.min(softness(beam.s_m))) <= 0.0:
                raise ModelError("with the model's effects its bending stiffness is not positive")
        result.append(
            replace(
                setup, softness=softness, B_Nm2=float(beam.stiffness[k]),
                angle_rad=setup.angle_rad + float(beam.shift_m[k]) / R,
                rest=plus(setup.rest, rest[k]), eibm=plus(setup.eibm, moment[k]),
                induced=plus(setup.eibm, induced[k]), opposite_ratio=ratio[abs(setup.voltage_V)],
                clamp_rad=float(beam.tilt_rad[k]), offset_m=float(beam.offset_m[k]),
                reach_m=float(beam.reach_m[k]),
                elongation_soft=float(beam.elongation_soft[k]),
            )
        )  # fmt: skip
    return result


class _Sums:
    """Adds values at a beam's nodes to fields; setups in which these are the same share the sum."""

    def __init__(self, beam: BeamProblem) -> None:
        self._beam = beam
        self._made: dict[tuple[int, bytes], Field] = {}

    def __call__(self, field: Field, values: FloatArray) -> Field:
        if not np.any(values):
            return field
        key = (id(field), values.tobytes())
        if key not in self._made:
            self._made[key] = field + _field(self._beam, values)
        return self._made[key]


def _breaks(sheet: SheetGeometry, measured_length_m: float) -> FloatArray:
    """Return the ends of the parts of a sheet: beyond the measured length its material is even."""
    length_m = sheet.free_length_m
    beyond = 0.0 < measured_length_m < (1.0 - SHORTEST_PART) * length_m
    return np.array([0.0, *([measured_length_m] if beyond else []), length_m])


def _field(beam: BeamProblem, values: FloatArray) -> Field:
    """Return the polynomials through values at the nodes of each part."""
    breaks_m = _breaks(beam.sheet, beam.measured_length_m)
    t = 2.0 * np.asarray(rule(NODES).c) - 1.0
    rows = np.linalg.solve(np.vander(t, increasing=True), values.reshape(-1, NODES).T).T
    return Field(breaks_m, np.asarray(rows, dtype=float))


def contact_solution(found: SolvedProblems, beam: BeamProblem) -> ContactSolution:
    """Return equilibria of setups as effects see them, in the clamp's own frame."""
    shapes = found.shapes(np.append(beam.s_m, beam.sheet.free_length_m))
    x, y, phi = (a[:, :-1] for a in (shapes.x_m, shapes.y_m, shapes.phi_rad))
    # in the clamp's own frame, in which the contact's forces are worked out
    tilt = beam.tilt_rad[:, None]
    cos, sin = np.cos(tilt), np.sin(tilt)
    own_x, own_y = cos * x + sin * y, cos * y - sin * x
    R, offset = beam.sheet.arc_radius_m + beam.reach_m, beam.offset_m
    beta = np.array([s.angle_rad for s in found.setups]) - beam.tilt_rad
    end = found.phi_hat_rad - beam.tilt_rad
    dx = (R * np.cos(beta) + offset * np.sin(end))[:, None] - own_x
    dy = (R * np.sin(beta) - offset * np.cos(end))[:, None] - own_y
    cos, sin = np.cos(end)[:, None], np.sin(end)[:, None]
    before = beam.s_m <= found.s_hat_m[:, None]
    return ContactSolution(
        force_N=found.force_N, normal_N=found.normal_N, gamma_rad=found.gamma_rad,
        s_hat_m=found.s_hat_m, lever=np.where(before, dx * cos + dy * sin, 0.0),
        offset=np.where(before, dy * cos - dx * sin, 0.0), x_m=own_x, y_m=own_y,
        phi_rad=phi - tilt, curvature=shapes.curvature_per_m[:, :-1],
        end_phi_rad=shapes.phi_rad[:, -1] - beam.tilt_rad,
        at_rest=np.stack(for_each_field(lambda k0: k0(beam.s_m), [s.rest for s in found.setups]))
        - beam.rest,
    )  # fmt: skip
