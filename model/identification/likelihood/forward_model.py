"""The model's state (base parameters, active effects) and its prediction of all data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np

from model.effects.interface import BeamProblem, ContactSolution, Effect, ImagePoints, Values
from model.effects.rise import rise_left
from model.identification.data.data_vector import DataVector
from model.identification.likelihood.contact_solution import (
    ConfigurationModel,
    SolvedConditions,
)
from model.identification.likelihood.model_state import (
    AppliedEffect,
    ModelState,
    acting_in,
)
from model.identification.likelihood.row_index import RowBlock, RowIndex
from model.identification.likelihood.second_order import LEVELS, WAYS_FROM_ONE, beyond_first_order
from model.identification.likelihood.time_courses import (
    bent,
    in_images,
    in_means,
    in_parts,
    modes_in_images,
    of_free_shapes,
)
from model.identification.reading_patterns.catalogue import patterns_in
from model.identification.reading_patterns.contract import FoundPattern
from model.locations.quantities import Perturbation
from model.measurements import FloatArray, RigScale, length_scale, scale_of
from model.mechanics.field import Field
from model.sheet.effect_hooks import (
    Acting,
    added_force_N,
    applied,
    course,
    image_displacement_m,
    in_course,
    lagging,
    load_cell_input,
    self_consistent,
)

STRONG = 0.03  # relative change of the EIBM from which on its slope will not do
SELF_CONSISTENT = 5  # rounds of solving and applying effects that depend on the solution
ACCURACY = 1e-6  # relative change of the beam problem that ends them sooner
LEAST_M = 1e-8  # that the EIBM moves a curve
# rounds of placing the points of a distorted picture, and the step that ends them sooner: half the
# curvature times its square is less than 0.1 um
PLACED, CLOSE_M = 4, 2e-5


class ForwardModel:
    """All configurations of a data set: predicts rows, and their changes."""

    def __init__(
        self, data_vectors: list[DataVector], rests: list[Field], like: ForwardModel | None = None
    ) -> None:
        """With the patterns in the readings of another one, of the same session."""
        self.data_vectors = data_vectors
        self.configuration_models = [
            ConfigurationModel(one, rest) for one, rest in zip(data_vectors, rests, strict=True)
        ]
        self.row_index = RowIndex(data_vectors, self.configuration_models)
        self.names = [one.sheet.configuration for one in data_vectors]
        self.scale: RigScale = like.scale if like is not None else _scale(data_vectors)
        self._nothing: dict[int, Perturbation] = {}
        self.patterns: tuple[FoundPattern, ...] = (
            patterns_in(data_vectors, self.scale)
            if like is None
            else tuple(one.in_other_data(data_vectors) for one in like.patterns)
        )
        # by configuration: change of the rows (N,) where data at rest are those of a sheet in
        # motion less what dynamics explain, for each metre of its contacts along the arc
        self.in_motion: dict[int, FloatArray] = {}

    def row_block(self, c: int) -> RowBlock:
        """Rows of a configuration."""
        return self.row_index.blocks[c]

    def state(self, c: int, base: BeamProblem, active: tuple[AppliedEffect, ...]) -> ModelState:
        """Solve a configuration with its effects; residuals of its rows."""
        configuration_model = self.configuration_models[c]
        inner = acting_in(active, self.names[c])
        base = in_course(base, *in_means(configuration_model, inner))
        changing = [one for one in inner if type(one.effect).beam is not Effect.beam]

        def change(base: BeamProblem, contact: ContactSolution) -> BeamProblem:
            return applied(base, contact, changing)

        rounds = SELF_CONSISTENT if changing else 0
        beam, solved, _ = self_consistent(
            base, change, configuration_model.solve, rounds=rounds, accuracy=ACCURACY
        )
        solved = _imaged(configuration_model, beam, solved, inner)
        answers = configuration_model.answers(beam, solved)
        G = configuration_model.count
        by_eibm = np.einsum("kg,kg->k", answers.force[:, :G], beam.eibm * beam.soft)
        modes_by = np.einsum("kmg,kg->km", answers.modes[:, :, :G], beam.eibm * beam.soft)
        state = ModelState(
            base=base, beam=beam, solved=solved, answers=answers, by_eibm=by_eibm,
            modes_by_eibm=modes_by, response=self._response(c, beam, solved, inner),
            weighed=load_cell_input(
                beam, solved.contact, configuration_model.clock, configuration_model.reading_of
            ),
            residual=np.zeros(0),
        )  # fmt: skip
        return replace(state, residual=self._residual(c, state, inner))

    def _response(
        self, c: int, beam: BeamProblem, solved: SolvedConditions, inner: Sequence[Acting]
    ) -> FloatArray | None:
        """Return forces at other sizes of the EIBM, if it or B changes much in time, or None."""
        block = self.row_block(c)
        courses = [course(one, clock) for one in inner for clock in (block.clock, block.bin_clock)]
        changes = [change for found in courses if found for change in found]
        changes.append(rise_left(block.bin_clock, self._rise_s(c), 0.0))
        largest = max((float(np.max(np.abs(x), initial=0.0)) for x in changes), default=0.0)
        if largest < STRONG:
            return None
        configuration_model = self.configuration_models[c]
        rows = configuration_model.touching[
            np.any(beam.eibm[configuration_model.touching] != 0.0, axis=1)
        ]
        result = np.repeat(solved.force_N[:, None], len(LEVELS), axis=1)  # at level 1
        for way in WAYS_FROM_ONE:  # each level from its neighbour, which is near
            sizes = [float(LEVELS[number]) for number in way]
            for number, forces in zip(
                way, configuration_model.forces_at_sizes(beam, sizes, rows), strict=True
            ):
                result[rows, number] = forces[rows]
        return result

    def _residual(self, c: int, state: ModelState, inner: Sequence[Acting]) -> FloatArray:
        block, configuration_model = self.row_block(c), self.configuration_models[c]
        y, nothing = np.zeros(self.row_index.size), self.no_step(c)
        of = block.reading_of
        measured = block.trend @ (block.measured_N - np.nan_to_num(state.solved.force_N[of]))
        y[block.trend_rows] = measured
        has = configuration_model.has_curve
        y[block.mode_rows[has]] = state.solved.modes_m[has]
        seen = in_images(configuration_model, inner)
        if seen is not None:  # what the step below takes off once more is put on here
            late = replace(
                nothing, frame_eibm=seen[0], beam=bent(configuration_model, state, seen[1])
            )
            first = self.rows_of(c, state, late)
            rows, exact = (
                block.mode_rows[has],
                modes_in_images(configuration_model, block, state, seen),
            )
            y[rows] = first[rows] + exact[has]
        y[block.bin_rows] = block.bin_N
        y[block.sway_rows] = self._sway(c, state)
        for one in inner:
            y -= self.rows_of(c, state, self.outer_step(c, state, one, nothing))
        # the means are in the beam problem already
        eibm, stiffness = in_means(configuration_model, inner)
        beam = bent(configuration_model, state, of_free_shapes(configuration_model, inner))
        driven = block.clock.voltage_V != 0.0
        mean = replace(nothing, eibm=eibm[of] * driven, stiffness=stiffness[of], beam=beam)
        y += self.rows_of(c, state, mean)
        y -= beyond_first_order(configuration_model, block, state, inner, self.row_index.size)
        if self.in_motion:
            y -= self._moved(
                c, configuration_model.change(state.base, state.beam, state.solved.contact)
            )
        return y - self.rows_of(c, state, self._rise_step(c))

    def _sway(self, c: int, state: ModelState) -> FloatArray:
        """Trends of how far out each reading's curve is, the way in which the EIBM moves it; m."""
        block, configuration_model = self.row_block(c), self.configuration_models[c]
        sizes = np.zeros(len(block.reading_of))
        for k in np.unique(block.sway_of).tolist():
            curves = (
                self.data_vectors[c]
                .seen[k]
                .own_points_m[:, :, : configuration_model.curve_s.shape[1]]
            )
            modes = _modes(configuration_model, k, curves, state.solved)
            u = state.modes_by_eibm[k]
            own = block.reading_of == k
            if curves.shape[1] < np.count_nonzero(own):
                own &= block.share > 0.0
            sizes[own] = modes @ u / max(state.reach_m[k], LEAST_M * self.scale.length)
        result: FloatArray = block.sway @ sizes
        return result

    # -- first-order changes

    def no_step(self, c: int) -> Perturbation:
        """No change; its arrays are the same each time, and cannot be written to."""
        if c not in self._nothing:
            self._nothing[c] = self.blank_step(c)
            for one in fields(Perturbation):
                getattr(self._nothing[c], one.name).flags.writeable = False
        return self._nothing[c]

    def blank_step(self, c: int) -> Perturbation:
        """No change, to be filled in."""
        configuration_model, block = self.configuration_models[c], self.row_block(c)
        n, b = len(block.reading_of), len(block.bin_of)
        return Perturbation(
            beam=np.zeros((configuration_model.K, configuration_model.columns)),
            eibm=np.zeros(n), stiffness=np.zeros(n), force_N=np.zeros(n),
            bin_eibm=np.zeros(b), bin_stiffness=np.zeros(b),
            points_m=np.zeros(configuration_model.curve_s.shape), frame_eibm=np.zeros(n),
        )  # fmt: skip

    def step(self, c: int, state: ModelState, effect: Effect, values: Values) -> Perturbation:
        """Return the perturbation by an effect at a state."""
        one = Acting(effect, values)
        other = applied(state.beam, state.solved.contact, [one])
        change = self.configuration_models[c].change(state.beam, other, state.solved.contact)
        return self.outer_step(c, state, one, replace(self.no_step(c), beam=change))

    def outer_step(
        self, c: int, state: ModelState, one: Acting, step: Perturbation
    ) -> Perturbation:
        """`step` with the part of an effect that is not in the beam problem."""
        block, configuration_model = self.row_block(c), self.configuration_models[c]
        found = course(one, block.clock)
        if found is not None:
            within, at_sample = in_parts(block, one)
            step = replace(
                step, eibm=found[0], stiffness=found[1],
                bin_eibm=within[0] - at_sample[0], bin_stiffness=within[1] - at_sample[1],
                beam=step.beam
                + bent(configuration_model, state, of_free_shapes(configuration_model, [one])),
            )  # fmt: skip
        seen = in_images(configuration_model, [one])
        if seen is not None:
            beam = step.beam + bent(configuration_model, state, seen[1])
            step = replace(step, frame_eibm=step.frame_eibm + seen[0], beam=beam)
        for shape, much in lagging(one, state.beam, state.solved.contact):
            force, size = self._lagging(c, state, shape, much)
            step = replace(step, force_N=step.force_N + force, frame_eibm=step.frame_eibm + size)
        if type(one.effect).force is not Effect.force:
            added_N = added_force_N([one], state.weighed, block.in_time)
            step = replace(step, force_N=step.force_N + added_N)
        if type(one.effect).curve is not Effect.curve:
            dx, dy = image_displacement_m([one], self.points(c, state.beam, state.solved))
            step = replace(step, points_m=dx * state.solved.nx + dy * state.solved.ny)
        return step

    def points(self, c: int, beam: BeamProblem, solved: SolvedConditions) -> ImagePoints:
        """Return the points of all curves of a solved beam problem."""
        return _points(self.configuration_models[c], beam, solved)

    def _rise_s(self, c: int) -> float:
        return max(self.configuration_models[c].sheet.rise_time_s, 1e-6)

    def _lagging(
        self, c: int, state: ModelState, shape: FloatArray, much: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Force of each reading, and size of its curve in shares of the EIBM's, by `lagging`."""
        of, G = self.row_block(c).reading_of, self.configuration_models[c].count
        force = np.einsum("kg,kg->k", state.answers.force[:, :G], shape)
        modes = np.einsum("kmg,kg->km", state.answers.modes[:, :, :G], shape)
        u = state.modes_by_eibm
        size = (
            np.sum(modes * u, axis=1) / np.maximum(state.reach_m, LEAST_M * self.scale.length) ** 2
        )
        return force[of] * much, size[of] * much

    def _rise_step(self, c: int) -> Perturbation:
        """Return the voltage's known rise: parts of a pulse relative to its sampling point."""
        block, step = self.row_block(c), self.no_step(c)
        rise = self._rise_s(c)
        at_sample = block.bin_mean(rise_left(block.bin_sample, rise, 0.0))
        later = block.bin_mean(rise_left(block.bin_clock, rise, 0.0)) - at_sample
        # the EIBM is stated as it is at the sampling point, not as it would settle
        return replace(step, bin_eibm=-later / (1.0 - at_sample))

    def rows_of(self, c: int, state: ModelState, step: Perturbation) -> FloatArray:
        """Return a step in all rows (N,); what is as in `no_step` costs nothing."""
        rows: FloatArray = self.rows_of_each(c, state, [step])[0]
        return rows

    def rows_of_each(self, c: int, state: ModelState, steps: Sequence[Perturbation]) -> FloatArray:
        """Return several steps in all rows (m, N)."""
        block = self.row_block(c)
        configuration_model = self.configuration_models[c]
        some = _Given(steps, self.no_step(c))
        y = np.zeros((len(steps), self.row_index.size))
        modes = np.zeros((len(steps), *state.modes_by_eibm.shape))
        readings, has, of = some.of("force_N"), configuration_model.has_curve, block.reading_of
        timed = some.of("eibm"), some.of("stiffness"), some.of("frame_eibm")
        if any(one is not None for one in timed):
            eibm, stiffness, frame = (np.zeros(1) if one is None else one for one in timed)
            by_time = state.by_eibm[of] * eibm + state.by_stiffness[of] * stiffness
            readings = by_time if readings is None else readings + by_time
            bent = eibm + frame - stiffness * (block.clock.voltage_V != 0.0)
            y[:, block.sway_rows] = (block.sways_by @ (bent * state.reach_m[of]).T).T
            modes = state.modes_by_eibm * block.means(bent)[:, :, None]
        beam = some.of("beam")
        if beam is not None:
            by_condition = beam.transpose(1, 2, 0)  # (K, Q, m)
            force = (state.answers.force[:, None] @ by_condition)[:, 0].T[:, of]
            readings = force if readings is None else readings + force
            modes = modes + (state.answers.modes @ by_condition).transpose(2, 0, 1)
        if readings is not None:
            y[:, block.trend_rows] = (block.trends_by @ readings.T).T
        points = some.of("points_m")
        if points is not None:
            modes = modes + (configuration_model.project @ points.transpose(1, 2, 0)).transpose(
                2, 0, 1
            )
        y[:, block.mode_rows[has]] = modes[:, has]
        within = some.of("bin_eibm"), some.of("bin_stiffness")
        if any(one is not None for one in within):
            b, (eibm, stiffness) = block.bin_of, (np.zeros(1) if w is None else w for w in within)
            y[:, block.bin_rows] = state.by_eibm[b] * eibm + state.by_stiffness[b] * stiffness
        if self.in_motion and beam is not None:
            y += np.stack([self._moved(c, one) for one in beam])
        return y

    def _moved(self, c: int, beam: FloatArray) -> FloatArray:
        """Return what a step (K, Q) that moves contacts changes of what dynamics explain, (N,)."""
        result = np.zeros(self.row_index.size)
        if c not in self.in_motion:
            return result
        for k, place_m in enumerate(self.configuration_models[c].along_arc_m(beam).tolist()):
            own = self.row_block(c).of_condition(k, self.row_index.size)
            result[own] = place_m * self.in_motion[c][own]
        return result


class _Given:
    """The fields of several steps, where any of them is something."""

    def __init__(self, steps: Sequence[Perturbation], none: Perturbation) -> None:
        self._steps, self._none = steps, none

    def of(self, name: str) -> FloatArray | None:
        """Return a field of all steps, (m, ...); None: it is nothing in all of them."""
        nothing = getattr(self._none, name)
        values = [getattr(step, name) for step in self._steps]
        for one in values:
            if one is not nothing:
                return values[0][None] if len(values) == 1 else np.array(values)
        return None


def _points(
    configuration_model: ConfigurationModel, beam: BeamProblem, solved: SolvedConditions
) -> ImagePoints:
    """Return the points of all curves, (K, S)."""
    held = solved.contact
    return ImagePoints(
        s_m=solved.s_m, x_m=solved.x_m, y_m=solved.y_m, normal_x=solved.nx, normal_y=solved.ny,
        length_scale=length_scale(configuration_model.sheet),
        free_length_m=configuration_model.length,
        contact_m=held.s_hat_m[:, None],
        pressed_per_m2=(held.normal_N / beam.stiffness)[:, None],
        session_number=configuration_model.session_number[:, None],
        voltage_V=configuration_model.voltage_V[:, None],
    )  # fmt: skip


def _imaged(
    configuration_model: ConfigurationModel,
    beam: BeamProblem,
    solved: SolvedConditions,
    inner: Sequence[Acting],
) -> SolvedConditions:
    """Return a solution at the places that the points show; itself where no camera distorts.

    The length along a picture's curve is that along the sheet only if lengths are seen as they are:
    a camera that shows them 5 % longer puts the end of a sheet of 50 mm at 52.5 mm. So each point
    is compared with the place whose picture is nearest to it (orthogonal distance regression:
    Boggs, Byrd and Schnabel 1987, SIAM J. Sci. Stat. Comput. 8, 1052).
    """
    close_m = CLOSE_M * length_scale(configuration_model.sheet)
    for _ in range(PLACED):
        dx, dy = image_displacement_m(inner, _points(configuration_model, beam, solved))
        if not (np.any(dx) or np.any(dy)):
            return solved
        beyond_x, beyond_y = (
            configuration_model.curve_x - solved.x_m - dx,
            configuration_model.curve_y - solved.y_m - dy,
        )
        step = beyond_x * solved.ny - beyond_y * solved.nx  # along the sheet
        s_m = _in_order(configuration_model, solved.s_m + step)
        if np.max(np.abs(s_m - solved.s_m), initial=0.0) < close_m:
            break
        solved = configuration_model.at(beam, solved, s_m)
    return solved


def _in_order(configuration_model: ConfigurationModel, s_m: FloatArray) -> FloatArray:
    """Return places of the measured points (K, S) on the sheet, ascending; the last one repeats."""
    last = np.maximum(configuration_model.points - 1, 0)[:, None]
    behind = np.arange(s_m.shape[1]) > last
    s_m = np.where(behind, np.take_along_axis(s_m, last, axis=1), s_m)
    s_m = np.clip(s_m, 0.0, configuration_model.length + configuration_model.sheet.elongation_m)
    found: FloatArray = np.maximum.accumulate(s_m, axis=1)
    return np.where(configuration_model.has_curve[:, None], found, configuration_model.curve_s)


def _modes(
    configuration_model: ConfigurationModel, k: int, curves: FloatArray, solved: SolvedConditions
) -> FloatArray:
    """Modes (r, M) of the readings' own curves (x and y, r, n), along their condition's normals."""
    n = curves.shape[2]
    off = (curves[0] - solved.x_m[k, :n]) * solved.nx[k, :n]
    off = off + (curves[1] - solved.y_m[k, :n]) * solved.ny[k, :n]
    result: FloatArray = off @ configuration_model.project[k, :, :n].T
    return result


def _scale(data_vectors: Sequence[DataVector]) -> RigScale:
    """Return the size of the session that data vectors are of."""
    kept = [one.kept_N for data_vector in data_vectors for one in data_vector.seen if not one.free]
    return scale_of([one.sheet for one in data_vectors], np.concatenate([np.zeros(0), *kept]))
