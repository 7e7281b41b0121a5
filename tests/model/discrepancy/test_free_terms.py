"""What no catalogue has is among the free shapes of its location, and judged beside names."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from model import predict
from model.discrepancy.criticism.kinds import voltage_structure
from model.discrepancy.search.evidence import Projected, candidates, scored
from model.discrepancy.search.nonparametric_terms import shapes, unknowns
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.verdict.free_form_or_names import alone
from model.discrepancy.verdict.inferred_form import unknown_of
from model.discrepancy.verdict.result import Unknown
from model.effects import effect
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.mixed_model import weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.identification.likelihood.model_state import ModelState
from model.locations.basis import bending_per_m
from model.locations.quantities import AcquisitionTimes, Perturbation
from model.measurements import FloatArray
from model.sheet.beam_problem import ActiveEffect, Profile
from tests.model.discrepancy.sessions import base_fit, fitted, session

Made = Callable[[ForwardModel, int, ModelState], Perturbation]


def beam(forward: ForwardModel, c: int, state: ModelState, **change: FloatArray) -> Perturbation:
    other = replace(state.beam, **change)
    by = forward.configuration_models[c].change(state.beam, other, state.solved.contact)
    return replace(forward.no_step(c), beam=by)


def play_of_the_stage(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
    force = np.nan_to_num(state.solved.contact.force_N)
    return beam(forward, c, state, shift_m=3e-4 * np.tanh(force / 1e-3))


def rocking_rolls(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
    contact = state.solved.contact
    before = state.beam.s_m <= np.nan_to_num(contact.s_hat_m)[:, None]
    return beam(forward, c, state, bend=np.nan_to_num(contact.gamma_rad)[:, None] * before)


def stretched_electrodes(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
    less = 0.2 * (bending_per_m(state.solved.contact) / 40.0) ** 2
    return beam(forward, c, state, eibm=state.beam.eibm * (1.0 - less))


def moment_by_bending(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
    driven = state.beam.voltage_V != 0.0
    size = 0.01 * np.mean(np.abs(state.beam.eibm[driven])) * driven[:, None]
    return beam(forward, c, state, bend=size * bending_per_m(state.solved.contact))


def wrinkles(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
    over = np.maximum(bending_per_m(state.solved.contact) / 20.0 - 1.0, 0.0)
    return beam(forward, c, state, soft=state.beam.soft * (1.0 + 0.3 * over))


def bow_that_grows(forward: ForwardModel, c: int, _state: ModelState) -> Perturbation:
    def course(clock: AcquisitionTimes) -> FloatArray:
        return -0.1 * np.sign(clock.voltage_V) * np.expm1(-clock.driven_s / 5.0)

    block = forward.row_block(c)
    within = block.bin_mean(course(block.bin_clock)) - block.bin_mean(course(block.bin_sample))
    return replace(forward.no_step(c), eibm=course(block.clock), bin_eibm=within)


def glare(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
    solved, configuration_model = state.solved, forward.configuration_models[c]
    phi = np.unwrap(np.arctan2(-solved.nx, solved.ny), axis=1)
    curvature = np.gradient(phi, axis=1) / np.gradient(configuration_model.curve_s, axis=1)
    return replace(forward.no_step(c), points_m=1e-4 * np.tanh(curvature / 40.0))


def crooked_rail(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
    at = np.nan_to_num(state.beam.stated_m)
    return beam(forward, c, state, reach_m=5e-4 * np.sin(at / 0.004))


def wavy_window(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
    points = forward.points(c, state.beam, state.solved)
    return replace(forward.no_step(c), points_m=1e-4 * np.sin(points.x_m / 0.003))


def knocked_camera(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
    block = forward.row_block(c)
    after = block.mean(block.clock.session) > 1.0 / 3.0
    return replace(forward.no_step(c), points_m=5e-4 * state.solved.ny * after[:, None])


def zooming_lens(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
    points, block = forward.points(c, state.beam, state.solved), forward.row_block(c)
    along = points.x_m * points.normal_x + points.y_m * points.normal_y
    return replace(
        forward.no_step(c),
        points_m=0.02 * (block.mean(block.clock.session) - 0.5)[:, None] * along,
    )


def twisting_sheet(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
    sign = np.sign(forward.configuration_models[c].voltage_V)[:, None]
    s = state.solved.s_m
    return replace(forward.no_step(c), points_m=2e-4 * sign * (s / np.max(s)) ** 2)


def twisted_towards_the_camera(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
    """What is nearer is larger: a point off the plane by s goes outwards in the picture."""
    sign = np.sign(forward.configuration_models[c].voltage_V)[:, None]
    points = forward.points(c, state.beam, state.solved)
    along = points.x_m * points.normal_x + points.y_m * points.normal_y
    return replace(forward.no_step(c), points_m=0.02 * sign * points.s_m / 0.05 * along)


def eccentric_roll(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
    turned = np.nan_to_num(state.solved.contact.s_hat_m) / 0.006
    return beam(forward, c, state, reach_m=3e-4 * (1.0 - np.cos(turned)))


def drying_sheet(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
    block = forward.row_block(c)
    at = block.mean(block.clock.session)
    return beam(forward, c, state, rest=state.beam.rest + 3.0 * (at[:, None] - 0.5))


def warming_bridge(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
    at = forward.row_block(c).clock.session
    return replace(forward.no_step(c), force_N=0.05 * np.sin(9.0 * at) * state.weighed.force_N)


def gain_of_the_place(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
    at = np.nan_to_num(state.weighed.position_m) / 0.03
    return replace(forward.no_step(c), force_N=0.05 * at**2 * state.weighed.force_N)


def settling_stage(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
    left = forward.row_block(c).mean(np.exp(-forward.row_block(c).clock.run_s / 5.0))
    return beam(forward, c, state, shift_m=5e-4 * left)


def bowed_elongation(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
    sheet, s_hat = state.beam.sheet, np.nan_to_num(state.solved.contact.s_hat_m)
    if not sheet.elongation_m:
        return forward.no_step(c)

    def bow(s_m: FloatArray) -> FloatArray:
        along = np.maximum(s_m - sheet.free_length_m, 0.0) / sheet.elongation_m
        return 3e-4 * (1.0 - np.cos(np.pi * along / 2.0))

    moved = beam(forward, c, state, offset_m=bow(s_hat))
    return replace(moved, points_m=bow(state.solved.s_m))


@pytest.mark.parametrize(
    ("made", "location", "part"),
    [
        (bowed_elongation, "rest_curvature", "elongation"),
        (twisting_sheet, "camera", "each polarity"), (drying_sheet, "time", "curvature, session"),
        (warming_bridge, "load_cell", "gain, session"),
        (twisted_towards_the_camera, "camera", "place, each polarity"),
        (eccentric_roll, "position", "reach, by place"),
        (crooked_rail, "position", "reach"), (wavy_window, "camera", "place, fine"),
        (knocked_camera, "camera", "knock 7, session"),
        (zooming_lens, "camera", "place, session"), (zooming_lens, "camera", "scale, session"),
        (gain_of_the_place, "load_cell", "gain"), (settling_stage, "position", "position, run"),
        (play_of_the_stage, "position", "force"), (rocking_rolls, "position", "moment"),
        (stretched_electrodes, "eibm", "curvature"),
        (moment_by_bending, "even_moment", "curvature"), (wrinkles, "compliance", "bending"),
        (bow_that_grows, "time", "EIBM, train"), (glare, "camera", "side"),
    ],
)  # fmt: skip
def test_what_no_catalogue_has_is_among_the_shapes_of_its_location(
    made: Made, location: str, part: str
):
    base = base_fit()
    forward, states = base.problem.forward, base.linear.states
    rows = np.sum(
        [forward.rows_of(c, s, made(forward, c, s)) for c, s in enumerate(states)], axis=0
    )
    assert np.linalg.norm(left(base, rows, [])) > 0.3 * np.linalg.norm(rows)
    own = [shape.rows for shape in shapes(base, location, part)]
    assert np.linalg.norm(left(base, rows, own)) < 0.2 * np.linalg.norm(left(base, rows, []))


def left(base: MixedModelFit, rows: FloatArray, own: list[FloatArray]) -> FloatArray:
    """What neither the base parameters nor the shapes take up."""
    known = np.stack([*base.linear.columns.T, *own], axis=1)
    known = known / np.maximum(np.linalg.norm(known, axis=0), 1e-300)
    return rows - known @ np.linalg.lstsq(known, rows, rcond=1e-9)[0]


def test_a_knock_is_one_amid_the_pictures_of_a_sheet():
    """What differs from one sheet to the next may be theirs."""
    seen = {part for one in unknowns(base_fit()) if (part := one.part).startswith("knock")}
    middle = {f"knock {j}, session" for j in (10, 11)}  # of 20, between the two sheets
    assert seen
    assert not seen & middle
    assert {"knock 9, session", "knock 12, session"} <= seen


def told(fitted: MixedModelFit, location: str, part: str) -> Unknown:
    """What is said of a part of a location, as if it were reported."""
    forward = fitted.problem.forward
    pool = [one for one in unknowns(fitted) if (one.location, one.part) == (location, part)]
    projected = Projected.of(forward, fitted.linear, fitted.solution)
    (one,) = scored(forward, projected, pool)
    return unknown_of(fitted, RankedCandidate(score=one, ln_bayes_factor=one.log_bayes))


def test_a_cell_off_its_place_along_the_arc_and_off_it_is_told_of_one_of_them():
    """Both are lengths along the arc; their sum would be none."""

    def off(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
        wave_m = 5e-4 * np.cos(3.0 * np.pi * np.nan_to_num(state.beam.stated_m) / 0.03)
        return beam(forward, c, state, reach_m=wave_m, shift_m=-wave_m)

    found = told(with_more(base_fit(), off), "position", "position and reach")
    assert (found.along, found.unit) == ("position", "mm")
    assert np.max(np.abs(found.profile)) == pytest.approx(0.5, abs=0.15)
    assert "off the arc" in found.depends or "along the arc" in found.depends


def test_a_cell_off_its_arc_says_so():
    found = told(with_more(base_fit(), crooked_rail), "position", "reach")
    assert found.depends.endswith(", off the arc (positive: farther from its centre)")


def with_more(base: MixedModelFit, made: Made) -> MixedModelFit:
    """The same fit of data with something more in them."""
    forward, linear = base.problem.forward, base.linear
    steps = ((c, state, made(forward, c, state)) for c, state in enumerate(linear.states))
    rows = np.sum([forward.rows_of(*one) for one in steps], axis=0)
    data = replace(linear.data, y=linear.data.y + forward.row_index.pad(rows))
    return replace(
        base, linear=replace(linear, data=data), solution=weigh(data, base.solution.log_sigma)
    )


def test_a_knock_amid_the_second_sheet_is_told_of_its_curves():
    """To the first sheet it did nothing."""
    for part, sheet in (("knock 9, session", "long"), ("knock 12, session", "short")):
        found = told(base_fit(), "camera", part)
        assert (found.along, found.unit, found.configuration) == ("s", "mm", sheet)


@pytest.mark.slow
def test_a_camera_that_saw_the_second_sheet_alone_is_told_of_it():
    m = session()
    unseen = [
        replace(c, curve=None, readings=tuple(replace(r, curve=None) for r in c.readings))
        if c.configuration == "long" else c
        for c in m.conditions
    ]  # fmt: skip
    found = told(fitted(replace(m, conditions=tuple(unseen))), "camera", "place, fine")
    assert (found.along, found.unit, found.configuration) == ("s", "mm", "short")


def test_shapes_of_a_part_that_is_looked_for_alone_are_not_in_the_whole():
    base = base_fit()
    whole = {shape.part for shape in shapes(base, "position")}
    assert whole == {"position", "polarity"}
    assert {shape.under for shape in shapes(base, "position", "moment")} == {
        "", "voltage", "polarity",
    }  # fmt: skip


def test_rolls_that_turn_the_sheet_are_predicted_from_a_model_file(truth):
    moment = Profile(
        along="position", at=(0.0, 0.03), values=(2.0, 2.0), sigma=(0.0, 0.0), unit="1/m",
        adds="moment",
    )  # fmt: skip
    again = Profile.from_dict(moment.to_dict(), "moment")
    assert again == moment
    turned = truth.with_effects(ActiveEffect(name="unknown", location="position", form=(again,)))
    plain, found = (predict(one, "long", 0.02, 2.0) for one in (truth, turned))
    assert abs(found.F_N - plain.F_N) > 1e-5


def test_one_free_form_that_explains_more_than_the_names_stands_for_them():
    def fits(names: int) -> tuple[MixedModelFit, MixedModelFit]:
        base = SimpleNamespace(found=(), deviance=200.0)
        return base, SimpleNamespace(found=("name",) * names, deviance=0.0)

    free = SimpleNamespace(first=SimpleNamespace(ln_bayes_factor=110.0))
    assert alone(free, *fits(2), 90.0)
    assert not alone(free, *fits(1), 90.0)  # which may be of another form
    assert not alone(free, *fits(0), 90.0)
    less = SimpleNamespace(first=SimpleNamespace(ln_bayes_factor=102.0))
    assert not alone(less, *fits(2), 90.0)
    much_more = SimpleNamespace(first=SimpleNamespace(ln_bayes_factor=125.0))
    assert alone(much_more, *fits(1), 90.0)


def test_three_names_have_to_explain_more_than_a_free_form():
    base = SimpleNamespace(found=(), deviance=200.0)
    two, three = (SimpleNamespace(found=("name",) * n, deviance=0.0) for n in (2, 3))
    free = SimpleNamespace(first=SimpleNamespace(ln_bayes_factor=80.0))
    assert alone(free, base, three, 40.0)  # the others add 60 to the best name, the free form 40
    assert not alone(free, base, two, 40.0)
    assert not alone(free, base, three, 70.0)  # the best name explains about as much


def test_a_curve_of_response_may_have_a_zero_of_its_own():
    """The square of a force is no Legendre polynomial of two and more degrees."""
    base = base_fit()
    one = next(c for c in unknowns(base) if (c.location, c.part) == ("load_cell", "force"))
    forward, states = base.problem.forward, base.linear.states
    added = [forward.no_step(c) for c in range(len(states))]
    square = np.sum([
        forward.rows_of(c, state, replace(step, force_N=state.weighed.force_N**2))
        for c, (state, step) in enumerate(zip(states, added, strict=True))
    ], axis=0)  # fmt: skip
    left = square - one.columns @ np.linalg.lstsq(one.columns, square, rcond=None)[0]
    assert np.linalg.norm(left) < 1e-6 * np.linalg.norm(square)


@pytest.mark.parametrize(
    ("name", "compared"),
    [
        ("roll_friction", ["at -2 V", "at +2 V"]),
        ("load_cell_hysteresis", ["at -2 V", "at +2 V"]),
        ("roll_sticking", []),  # a slip lets go of any part of it
        ("gravity", ["at -2 V", "at 0 V", "at +2 V"]),
    ],
)
def test_what_depends_on_how_the_sheet_came_there_is_not_compared_at_0V(
    monkeypatch, name, compared
):
    asked = []

    def recorded(_named, groups, applies, along):
        asked.extend(g.title for g in groups if applies(effect(name)))
        assert along == "voltage"
        return iter(())

    monkeypatch.setattr(voltage_structure, "contradicted", recorded)
    named = SimpleNamespace(fitted=base_fit(), outcome=SimpleNamespace(outliers=[]))
    assert list(voltage_structure.CHECK.failures(named)) == []
    assert asked == compared


@pytest.mark.parametrize("degrees", [22.0, 52.0, 98.0, 172.0])
def test_an_arc_s_centre_in_any_direction_is_one_of_those_tried(degrees: float):
    """With a centre before the clamp alone 60 to 97 % of some were left: another name took it."""
    base, towards = base_fit(), np.radians(degrees)

    def off(forward: ForwardModel, c: int, state: ModelState) -> Perturbation:
        R, at = state.beam.sheet.arc_radius_m, np.nan_to_num(state.beam.stated_m)
        beta = at / R + state.beam.sheet.arc_origin_rad
        reach_m, shift_m = 1e-4 * np.cos(beta - towards), 1e-4 * np.sin(towards - beta)
        return beam(forward, c, state, reach_m=reach_m, shift_m=shift_m)

    forward, states = base.problem.forward, base.linear.states
    rows = np.sum([forward.rows_of(c, s, off(forward, c, s)) for c, s in enumerate(states)], axis=0)
    each = [one.columns[:, 0] for one in candidates(base, [effect("arc_error")])]
    least = min(np.linalg.norm(left(base, rows, [one])) for one in each)
    assert least < 0.3 * np.linalg.norm(left(base, rows, []))
