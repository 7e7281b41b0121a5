"""A state of the model, base parameters and active effects, and what it says of all the data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np

from model.effects.interface import BeamProblem, Effect, ImagePoints, LoadCellInput, Values
from model.effects.rise import rise_left
from model.effects.roll_friction import slid
from model.identification.data.data_vector import DataVector
from model.identification.data.periodic_terms import wave_in
from model.identification.likelihood.contact_solution import (
    ConfigurationModel,
    Sensitivities,
    SolvedConditions,
)
from model.identification.likelihood.image_lag import bent, free_course, modes_in_pictures, pictured
from model.identification.likelihood.row_index import RowBlock, RowIndex
from model.identification.likelihood.second_order import LEVELS, MOST_LOST, beyond_first_order
from model.measurements import Curve, FloatArray
from model.mechanics.field import Field

STRONG = 0.03  # relative change of the EIBM from which on its slope will not do
SELF_CONSISTENT = 5  # rounds of solving and applying effects that depend on the solution
LEAST_M = 1e-8  # that the EIBM moves a curve
SETTLED_N = 3e-8  # change of any force that ends them sooner


@dataclass(frozen=True)
class AppliedEffect:
    """An effect with its values; by configuration where each has its own."""

    effect: Effect
    values: Mapping[str, Mapping[str, float]]  # configuration -> parameter -> value


@dataclass
class Perturbation:
    """A change of one configuration's prediction, to first order."""

    beam: FloatArray  # (K, Q) columns of `ConfigurationModel.answers`
    eibm: FloatArray  # (n,) relative, of each reading
    stiffness: FloatArray  # (n,)
    force_N: FloatArray  # (n,) of each reading
    bin_eibm: FloatArray  # (b,) relative to the sampling point
    bin_stiffness: FloatArray
    points_m: FloatArray  # (K, S) of the predicted points along the normal
    frame_eibm: FloatArray  # (n,) relative, of the frame of each reading where it is older


@dataclass(frozen=True)
class ModelState:
    """One configuration, solved."""

    # before the effects: EIBM and stiffness in the mean of each condition's readings
    base: BeamProblem
    beam: BeamProblem  # as they left it
    solved: SolvedConditions
    answers: Sensitivities
    by_eibm: FloatArray  # (K,) dF / d ln Me
    modes_by_eibm: FloatArray  # (K, M)
    response: FloatArray | None  # (K, L) force at the EIBM times `LEVELS`; None: its slope will do
    weighed: LoadCellInput  # of the readings, before what the load cell adds
    residual: FloatArray  # (N,) of this configuration's rows, at their places among all

    @property
    def reach_m(self) -> FloatArray:
        """How far the EIBM moves each curve, root mean square along it: (K,)."""
        return np.asarray(np.linalg.norm(self.modes_by_eibm, axis=1))


class ForwardModel:
    """All configurations of a data set: predicts rows, and their changes."""

    def __init__(self, looks: list[DataVector], rests: list[Field]) -> None:
        self.looks = looks
        self.scenes = [
            ConfigurationModel(one, rest) for one, rest in zip(looks, rests, strict=True)
        ]
        self.layout = RowIndex(looks, self.scenes)
        self.names = [one.sheet.configuration for one in looks]
        self.wave = wave_in(looks)

    def part(self, c: int) -> RowBlock:
        """Rows of a configuration."""
        return self.layout.parts[c]

    def state(self, c: int, base: BeamProblem, active: tuple[AppliedEffect, ...]) -> ModelState:
        """Solve a configuration with its effects; residuals of its rows."""
        scene, name = self.scenes[c], self.names[c]
        inner = [(a.effect, a.values[name]) for a in active if name in a.values]
        base = self._timed(c, base, inner)
        beam, solved = base, scene.solve(base)
        changing = [e for e in inner if type(e[0]).beam is not Effect.beam]
        for _ in range(SELF_CONSISTENT if changing else 0):
            before = solved.force_N
            beam = base
            for effect, values in changing:
                beam = effect.beam(beam, solved.contact, values)
            solved = scene.solve(beam)
            if np.nanmax(np.abs(solved.force_N - before), initial=0.0) < SETTLED_N:
                break
        answers = scene.answers(beam, solved)
        G = scene.count
        by_eibm = np.einsum("kg,kg->k", answers.force[:, :G], beam.eibm * beam.soft)
        modes_by = np.einsum("kmg,kg->km", answers.modes[:, :, :G], beam.eibm * beam.soft)
        weighed = self._weighed(c, beam, solved)
        response = self._response(c, beam, inner)
        state = ModelState(
            base, beam, solved, answers, by_eibm, modes_by, response, weighed, np.zeros(0)
        )
        return replace(state, residual=self._residual(c, state, inner))

    def _timed(self, c: int, base: BeamProblem, inner: list[tuple[Effect, Values]]) -> BeamProblem:
        """EIBM and stiffness as they are in the mean of each condition's readings."""
        eibm, stiffness = self.mean_course(c, inner)
        if not (np.any(eibm) or np.any(stiffness)):
            return base
        share = (1.0 + eibm) / (1.0 + stiffness)
        return replace(
            base, eibm=base.eibm * share[:, None], stiffness=base.stiffness * (1.0 + stiffness)
        )

    def mean_course(
        self, c: int, inner: list[tuple[Effect, Values]]
    ) -> tuple[FloatArray, FloatArray]:
        """Relative change of EIBM and stiffness in the mean of each condition's readings: (K,)."""
        part, K = self.part(c), self.scenes[c].K
        eibm, stiffness = np.zeros(K), np.zeros(K)
        for effect, values in inner:
            course = effect.course(part.clock, values)
            if course is not None:
                driven = part.clock.voltage_V != 0.0
                eibm += part.mean(np.where(driven, course[0], 0.0))
                stiffness += part.mean(course[1])
                eibm += free_course(self, c, effect, values)
        return np.maximum(eibm, -MOST_LOST), np.maximum(stiffness, -MOST_LOST)

    def _response(
        self, c: int, beam: BeamProblem, inner: list[tuple[Effect, Values]]
    ) -> FloatArray | None:
        """Forces at other sizes of the EIBM, where it, or B, changes much in time."""
        part = self.part(c)
        courses = [e.course(k, v) for e, v in inner for k in (part.clock, part.bin_clock)]
        changes = [change for course in courses if course for change in course]
        changes.append(rise_left(part.bin_clock, self._rise_s(c), 0.0))
        largest = max((float(np.max(np.abs(x), initial=0.0)) for x in changes), default=0.0)
        if largest < STRONG:
            return None
        scene = self.scenes[c]
        result = [scene.forces(replace(beam, eibm=beam.eibm * level)) for level in LEVELS]
        return np.stack(result, axis=1)

    def _weighed(self, c: int, beam: BeamProblem, solved: SolvedConditions) -> LoadCellInput:
        part, of = self.part(c), self.part(c).reading_of
        contact, scene = solved.contact, self.scenes[c]
        touching = np.isfinite(contact.force_N[of]).astype(float)
        return LoadCellInput(
            np.nan_to_num(contact.force_N[of]), np.nan_to_num(contact.normal_N[of]),
            np.nan_to_num(contact.gamma_rad[of]), scene.stated_m[of], part.clock.session, touching,
            part.clock.wetted_s, slid(beam, contact)[of],
        )  # fmt: skip

    def _residual(
        self, c: int, state: ModelState, inner: list[tuple[Effect, Values]]
    ) -> FloatArray:
        part, scene = self.part(c), self.scenes[c]
        y, nothing = np.zeros(self.layout.size), self.no_step(c)
        of = part.reading_of
        measured = part.trend @ (part.measured_N - np.nan_to_num(state.solved.force_N[of]))
        y[part.trend_rows] = measured
        has = scene.has_curve
        y[part.mode_rows[has]] = state.solved.modes_m[has]
        seen = pictured(self, c, inner)
        if seen is not None:  # what the step below takes off once more is put on here
            late = replace(nothing, frame_eibm=seen[0], beam=bent(self, c, state, seen[1]))
            first = self.rows_of(c, state, late)
            rows, exact = part.mode_rows[has], modes_in_pictures(self, c, state.beam, seen)
            y[rows] = first[rows] + exact[has]
        y[part.bin_rows] = part.bin_N
        y[part.sway_rows] = self._sway(c, state)
        of, (eibm, stiffness) = part.reading_of, self.mean_course(c, inner)
        for effect, values in inner:
            step = self.outer_step(c, state, effect, values, nothing)
            y -= self.rows_of(c, state, step)
        # the means are in the beam problem already
        driven = part.clock.voltage_V != 0.0
        free = sum((free_course(self, c, e, v) for e, v in inner), start=np.zeros(scene.K))
        beam = bent(self, c, state, free)
        mean = replace(nothing, eibm=eibm[of] * driven, stiffness=stiffness[of], beam=beam)
        y += self.rows_of(c, state, mean)
        y -= beyond_first_order(self, c, state, inner)
        return y - self.rows_of(c, state, self._rise_step(c))

    def _sway(self, c: int, state: ModelState) -> FloatArray:
        """Trends of how far out each reading's curve is, the way in which the EIBM moves it; m."""
        part, scene = self.part(c), self.scenes[c]
        sizes = np.zeros(len(part.reading_of))
        for k in np.unique(part.sway_of).tolist():
            curves = self.looks[c].seen[k].own_curves
            modes = np.array([_modes(scene, k, curve, state.solved) for curve in curves])
            u = state.modes_by_eibm[k]
            own = part.reading_of == k
            if len(curves) < np.count_nonzero(own):
                own &= part.share > 0.0
            sizes[own] = modes @ u / max(state.reach_m[k], LEAST_M)
        result: FloatArray = part.sway @ sizes
        return result

    # -- first-order changes

    def no_step(self, c: int) -> Perturbation:
        """No change."""
        scene, part = self.scenes[c], self.part(c)
        n, b = len(part.reading_of), len(part.bin_of)
        return Perturbation(
            np.zeros((scene.K, scene.columns)), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(b),
            np.zeros(b), np.zeros(scene.curve_s.shape), np.zeros(n),
        )  # fmt: skip

    def step(self, c: int, state: ModelState, effect: Effect, values: Values) -> Perturbation:
        """What an effect changes at a state."""
        other = effect.beam(state.beam, state.solved.contact, values)
        change = self.scenes[c].change(state.beam, other, state.solved.contact)
        step = replace(self.no_step(c), beam=change)
        return self.outer_step(c, state, effect, values, step)

    def outer_step(
        self, c: int, state: ModelState, effect: Effect, values: Values, step: Perturbation
    ) -> Perturbation:
        """`step` with the part of an effect that is not in the beam problem."""
        part, scene = self.part(c), self.scenes[c]
        course = effect.course(part.clock, values)
        if course is not None:
            within, at_sample = self.bin_courses(c, effect, values)
            driven = part.clock.voltage_V != 0.0
            step = replace(
                step, eibm=np.where(driven, course[0], 0.0), stiffness=np.asarray(course[1]),
                bin_eibm=within[0] - at_sample[0], bin_stiffness=within[1] - at_sample[1],
                beam=step.beam + bent(self, c, state, free_course(self, c, effect, values)),
            )  # fmt: skip
        seen = pictured(self, c, [(effect, values)])
        if seen is not None:
            beam = step.beam + bent(self, c, state, seen[1])
            step = replace(step, frame_eibm=step.frame_eibm + seen[0], beam=beam)
        for shape, much in effect.lagging(state.beam, state.solved.contact, values):
            force, size = self._lagging(c, state, shape, much)
            step = replace(step, force_N=step.force_N + force, frame_eibm=step.frame_eibm + size)
        if type(effect).force is not Effect.force:
            force = step.force_N + self._added_force(c, state, effect, values)
            step = replace(step, force_N=force)
        points = ImagePoints(state.solved.x_m, state.solved.y_m, scene.length)
        moved = effect.curve(points, values)
        if moved is not None:
            normal = moved[0] * state.solved.nx + moved[1] * state.solved.ny
            step = replace(step, points_m=normal)
        return step

    def _rise_s(self, c: int) -> float:
        return max(self.scenes[c].sheet.rise_time_s, 1e-6)

    def _lagging(
        self, c: int, state: ModelState, shape: FloatArray, much: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Force of each reading, and size of its curve in shares of the EIBM's, by `lagging`."""
        of, G = self.part(c).reading_of, self.scenes[c].count
        force = np.einsum("kg,kg->k", state.answers.force[:, :G], shape)
        modes = np.einsum("kmg,kg->km", state.answers.modes[:, :, :G], shape)
        u = state.modes_by_eibm
        size = np.sum(modes * u, axis=1) / np.maximum(state.reach_m, LEAST_M) ** 2
        return force[of] * much, size[of] * much

    def bin_courses(
        self, c: int, effect: Effect, values: Values
    ) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
        """Mean over the pulses of an effect's course, in each part and at its sampling point."""
        part = self.part(c)
        result = []
        for clock in (part.bin_clock, part.bin_sample):
            course = effect.course(clock, values) or (np.zeros(clock.run_s.shape),) * 2
            result.append((part.bin_mean(course[0]), part.bin_mean(course[1])))
        return result[0], result[1]

    def _added_force(self, c: int, state: ModelState, effect: Effect, values: Values) -> FloatArray:
        """What the load cell adds to each reading; it is given them in the order of time."""
        order, w = self.part(c).in_time, state.weighed
        sorted_ = LoadCellInput(*(getattr(w, f.name)[order] for f in fields(LoadCellInput)))
        result = np.zeros(len(order))
        added = effect.force(sorted_, values)
        if added is not None:
            result[order] = added
        return result

    def _rise_step(self, c: int) -> Perturbation:
        """The known rise of the voltage: parts of a pulse against its sampling point."""
        part, step = self.part(c), self.no_step(c)
        rise = self._rise_s(c)
        at_sample = part.bin_mean(rise_left(part.bin_sample, rise, 0.0))
        later = part.bin_mean(rise_left(part.bin_clock, rise, 0.0)) - at_sample
        # the EIBM is stated as it is at the sampling point, not as it would settle
        return replace(step, bin_eibm=-later / (1.0 - at_sample))

    def rows_of(self, c: int, state: ModelState, step: Perturbation) -> FloatArray:
        """A step in all rows (N,)."""
        part, scene, y = self.part(c), self.scenes[c], np.zeros(self.layout.size)
        of, answers = part.reading_of, state.answers
        force = np.nan_to_num(state.solved.force_N)
        by_stiffness = force - state.by_eibm
        condition = np.einsum("kq,kq->k", answers.force, step.beam)
        readings = condition[of] + state.by_eibm[of] * step.eibm
        readings += by_stiffness[of] * step.stiffness + step.force_N
        y[part.trend_rows] = part.trend @ readings
        bent = step.eibm + step.frame_eibm - step.stiffness * (part.clock.voltage_V != 0.0)
        y[part.sway_rows] = part.sway @ (bent * state.reach_m[of])
        modes = np.einsum("kmq,kq->km", answers.modes, step.beam)
        modes += state.modes_by_eibm * part.mean(bent)[:, None]
        modes += np.einsum("kms,ks->km", scene.project, step.points_m)
        has = scene.has_curve
        y[part.mode_rows[has]] = modes[has]
        b = part.bin_of
        y[part.bin_rows] = state.by_eibm[b] * step.bin_eibm + by_stiffness[b] * step.bin_stiffness
        return y


def _modes(scene: ConfigurationModel, k: int, curve: Curve, solved: SolvedConditions) -> FloatArray:
    """Modes of a reading's own curve, along the normals of its condition."""
    n = min(len(curve.s_m), scene.curve_s.shape[1])
    off = (curve.x_m[:n] - solved.x_m[k, :n]) * solved.nx[k, :n]
    off = off + (curve.y_m[:n] - solved.y_m[k, :n]) * solved.ny[k, :n]
    result: FloatArray = scene.project[k, :, :n] @ off
    return result
