"""Forces and curves answer to changes as their derivatives say; the base model is `predict`'s."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from model import Parameter, predict
from model.effects import effect
from model.effects.conformance import plausible
from model.effects.interface import BeamProblem
from model.identification.data.data_vector import data_vector_of
from model.identification.likelihood.configuration.stacked_curves import projection
from model.identification.likelihood.contact_solution import ConfigurationModel
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.model_state import AppliedEffect
from model.identification.likelihood.row_index import WITHIN
from model.identification.likelihood.second_order import LEVELS, WAYS_FROM_ONE
from model.locations.quantities import Perturbation
from model.mechanics.field import Field
from model.sheet.beam_problem import ActiveEffect
from tests.cases import few
from tests.model.discrepancy.sessions import base_fit

LEVEL = {"long": {2.0: 25.0, -2.0: -20.0}, "short": {2.0: 80.0, -2.0: -64.0}}
STIFF = {"long": 1.27e-6, "short": 8.5e-7}
NAMES = ("long", "short")


@pytest.fixture(scope="module")
def studies(measure):
    """One `ForwardModel` of the base model for each sheet, free shapes among the conditions."""
    made = measure(force_N=0.0, curve_m=0.0, scatter=0.0, free=True, positions_mm=(0, 10, 25))
    result = {}
    for name in NAMES:
        seen = data_vector_of(made, name)
        s, k = seen.sheet.initial_curvature
        rest = Field.linear(s, k, seen.sheet.free_length_m)
        result[name] = ForwardModel([seen], [rest]), made
    return result


def base(configuration_model: ConfigurationModel, name: str) -> BeamProblem:
    return configuration_model.beam(STIFF[name], LEVEL[name])


def change(
    name: str, configuration_model: ConfigurationModel, beam: BeamProblem, h: float
) -> BeamProblem:
    """One field of a beam moved by h of its natural size, unevenly along the sheet."""
    t, touching = (
        configuration_model.s_m / configuration_model.length,
        np.isfinite(configuration_model.stated_m).astype(float),
    )
    moves = {
        "stiffness": beam.stiffness * (1.0 + 0.1 * h),
        "rest": beam.rest + h * np.cos(2.0 * t),
        "eibm": beam.eibm * (1.0 + 0.1 * h * (1.0 - t**2)),
        "bend": beam.bend + h * np.sin(3.0 * t) * (1.0 + configuration_model.voltage_V[:, None]),
        "soft": beam.soft + 0.05 * h * (1.0 + np.cos(3.0 * t)),
        "elongation_soft": beam.elongation_soft + 0.02 * h,
        "shift_m": beam.shift_m + 5e-4 * h * touching,
        "tilt_rad": beam.tilt_rad + 0.02 * h,
        "offset_m": beam.offset_m + 3e-4 * h * touching,
    }
    return replace(beam, **{name: moves[name]})


FIELDS = ("stiffness", "rest", "eibm", "bend", "soft", "elongation_soft", "shift_m", "tilt_rad",
          "offset_m")  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("field", FIELDS)
def test_force_and_modes_answer_as_finite_differences_do(studies, name: str, field: str):
    configuration_model = studies[name][0].configuration_models[0]
    beam, h = base(configuration_model, name), 0.02
    low, high = (
        configuration_model.solve(change(field, configuration_model, beam, sign * h))
        for sign in (-1.0, 1.0)
    )
    solved = configuration_model.solve(beam)
    answers = configuration_model.answers(beam, solved)
    up, down = (change(field, configuration_model, beam, sign * h) for sign in (1.0, -1.0))
    step = configuration_model.change(beam, up, solved.contact) - configuration_model.change(
        beam, down, solved.contact
    )
    force = np.einsum("kq,kq->k", answers.force, step)
    wanted = high.force_N - low.force_N
    touching = configuration_model.touching
    size = np.max(np.abs(wanted[touching]))
    np.testing.assert_allclose(force[touching], wanted[touching], atol=3e-4 * size + 1e-12)
    modes = np.einsum("kmq,kq->km", answers.modes, step)
    wanted = low.modes_m - high.modes_m  # they are of measured less predicted
    size = np.max(np.abs(wanted))
    np.testing.assert_allclose(modes, wanted, atol=1e-3 * size + 1e-12)
    # B alone, Me/B as it was, changes no shape; the long sheet has no elongation
    without = field == "stiffness" or (name, field) == ("long", "elongation_soft")
    assert size < 1e-13 if without else size > 1e-8


@pytest.mark.parametrize("name", NAMES)
def test_base_conditions_are_those_of_predict(studies, truth, name: str):
    configuration_model = studies[name][0].configuration_models[0]
    solved = configuration_model.solve(base(configuration_model, name))
    for k in configuration_model.touching:
        wanted = predict(
            truth, name, configuration_model.stated_m[k], configuration_model.voltage_V[k]
        )
        assert solved.force_N[k] == pytest.approx(wanted.F_N, rel=1e-6, abs=1e-10)
        assert solved.contact.s_hat_m[k] == pytest.approx(wanted.s_hat_m, rel=1e-6)
        x = np.interp(wanted.s_m, configuration_model.curve_s[k], solved.x_m[k])
        assert np.max(np.abs(x - wanted.x_m)) < 2e-6
    assert np.nanmax(np.abs(solved.modes_m)) < 2e-7  # the curves were predicted, free ones too
    forces = configuration_model.forces(base(configuration_model, name))
    np.testing.assert_allclose(forces, solved.force_N, rtol=1e-12, atol=1e-14)  # of mN: rounding


@pytest.mark.slow
@pytest.mark.parametrize("effect_name", few(["clamp_compliance", "nonlinear_stiffness", "gravity"]))
def test_an_effect_of_the_solution_is_solved_until_it_agrees_with_itself(studies, effect_name):
    forward = studies["long"][0]
    configuration_model, one = forward.configuration_models[0], effect(effect_name)
    p = plausible(one)
    start = base(configuration_model, "long")
    state = forward.state(0, start, (AppliedEffect(one, {"long": p}),))
    contact = configuration_model.solve(start).contact
    for _ in range(30):
        contact = configuration_model.solve(one.beam(start, contact, p)).contact
    change = np.nanmax(np.abs(contact.force_N - configuration_model.solve(start).force_N))
    assert change > 1e-6
    left = np.nanmax(np.abs(state.solved.force_N - contact.force_N))
    assert left < 2e-3 * change


@pytest.mark.slow
@pytest.mark.parametrize(
    "effect_name",
    few([
        "clamp_angle", "clamp_compliance", "eibm_asymmetry", "gravity", "nonlinear_stiffness",
        "position_error", "roll_friction", "roll_offset", "force_offset", "surface_tension",
        "load_cell_misalignment",
    ], first=3),
)  # fmt: skip
def test_an_effect_adds_to_the_fitted_forces_what_it_adds_to_the_predicted_ones(
    studies, truth, effect_name
):
    forward, one = studies["long"][0], effect(effect_name)
    values = plausible(one)
    configuration_model = forward.configuration_models[0]
    block = forward.row_block(0)
    rows, conditions = block.trend_rows[block.is_mean], block.trend_of[block.is_mean]
    active = (AppliedEffect(one, {"long": values}),)
    plain, there = (
        forward.state(0, base(configuration_model, "long"), a).residual[rows] for a in ((), active)
    )
    parameters = {
        name: Parameter(value=value, sigma=0.0, unit="") for name, value in values.items()
    }
    with_it = truth.with_effects(ActiveEffect(name=effect_name, parameters=parameters))
    added = []
    for k in conditions:
        at = ("long", configuration_model.stated_m[k], configuration_model.voltage_V[k])
        added.append(predict(with_it, *at).F_N - predict(truth, *at).F_N)
    assert np.max(np.abs(added)) > 1e-7
    np.testing.assert_allclose(plain - there, added, rtol=1e-4, atol=1e-9)


def test_a_rig_turned_over_is_one_whose_weight_pulls_the_other_way(measure):
    made = measure(names=("long",), free=True, positions_mm=(0, 10, 25))
    turned = replace(made, conditions=tuple(replace(c, tilt_rad=np.pi) for c in made.conditions))
    gravity, forces = effect("gravity"), []
    for m, load in ((made, -0.01), (turned, 0.01)):
        seen = data_vector_of(m, "long")
        s, k = seen.sheet.initial_curvature
        forward = ForwardModel([seen], [Field.linear(s, k, seen.sheet.free_length_m)])
        active = (AppliedEffect(gravity, {"long": {"load_N_per_m": load}}),)
        solved = forward.state(0, base(forward.configuration_models[0], "long"), active).solved
        forces.append((solved.force_N, solved.modes_m))
    for one, other in zip(*forces, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-15)


def test_projection_finds_the_polynomials_it_is_of():
    s = np.linspace(0.0, 0.05, 40)
    t = 2.0 * s / 0.05 - 1.0
    found = projection(s, 5) @ (3.0 + 2.0 * np.sqrt(3.0) * t)
    np.testing.assert_allclose(found, [3.0, 2.0, 0.0, 0.0, 0.0], atol=1e-12)
    assert projection(s[:3], 5).shape == (5, 3)
    assert not np.any(projection(s[:3], 5)[3:])  # no more than there are points


def test_a_curve_is_cut_where_the_sheet_ends(measure):
    made = measure(names=("long",), positions_mm=(5, 10, 15, 20), seed=3)
    (first, *others), by = made.conditions, 0.004
    c = first.curve
    longer = replace(
        c, s_m=np.append(c.s_m, [c.s_m[-1] + by, c.s_m[-1] + 2 * by]),
        x_m=np.append(c.x_m, [0.2, 0.3]), y_m=np.append(c.y_m, [0.0, 0.0]),
    )  # fmt: skip
    seen = data_vector_of(replace(made, conditions=(replace(first, curve=longer), *others)), "long")
    configuration_model = ConfigurationModel(seen, Field.constant(20.0, 0.05))
    s, x, y = configuration_model.measured(0)
    np.testing.assert_allclose(s, c.s_m)
    assert np.max(x) < 0.1
    assert len(y) == len(s)
    plain = ConfigurationModel(data_vector_of(made, "long"), Field.constant(20.0, 0.05))
    one, two = (
        a.solve(a.beam(1e-6, {2.0: 20.0, -2.0: -20.0})).modes_m
        for a in (configuration_model, plain)
    )
    np.testing.assert_allclose(one, two, atol=1e-15)


@pytest.mark.parametrize("name", NAMES)
def test_forces_of_some_conditions_are_those_of_all(studies, name: str):
    configuration_model = studies[name][0].configuration_models[0]
    beam = base(configuration_model, name)
    configuration_model.solve(beam)
    some, stronger = configuration_model.touching[1::2], replace(beam, eibm=1.15 * beam.eibm)
    whole, part = configuration_model.forces(stronger), configuration_model.forces(stronger, some)
    np.testing.assert_allclose(part[some], whole[some], rtol=1e-9)
    assert np.all(np.isnan(np.delete(part, some)))


@pytest.mark.parametrize("radii_apart", [False, True])
@pytest.mark.parametrize("name", NAMES)
def test_forces_at_other_sizes_are_those_of_the_physical_branch(
    studies, name: str, radii_apart: bool
):
    """A sheet whose EIBM is turned over: from the stated one, the solver may end elsewhere."""
    configuration_model = studies[name][0].configuration_models[0]
    beam = base(configuration_model, name)
    if radii_apart:  # another arc, and curves that pass beside it
        reach = 1e-5 * np.arange(configuration_model.K)
        beam = replace(beam, reach_m=reach, offset_m=np.full(configuration_model.K, 2e-4))
    configuration_model.solve(beam)
    some = configuration_model.touching[
        np.any(beam.eibm[configuration_model.touching] != 0.0, axis=1)
    ]
    begin = configuration_model._contacts.last, configuration_model._contacts.last_beside
    for way in WAYS_FROM_ONE:
        sizes = LEVELS[way,].tolist()
        for found, size in zip(
            configuration_model.forces_at_sizes(beam, sizes, some), sizes, strict=True
        ):
            fresh = ConfigurationModel(
                configuration_model.data_vector, configuration_model.rest
            )  # from the free shape
            own = fresh.forces(replace(beam, eibm=size * beam.eibm))
            np.testing.assert_allclose(found[some], own[some], rtol=1e-6, atol=1e-9)
        # nothing goes on from where a way ended: as far off, the solver may end elsewhere
        assert configuration_model._contacts.last is begin[0]
        assert configuration_model._contacts.last_beside is begin[1]


@pytest.mark.parametrize("name", NAMES)
def test_rows_of_several_steps_are_those_of_each(studies, name: str):
    forward = studies[name][0]
    configuration_model, block = forward.configuration_models[0], forward.row_block(0)
    state, none, steps = (
        forward.state(0, base(configuration_model, name), ()),
        forward.no_step(0),
        [],
    )
    for field in fields(Perturbation):
        like = getattr(none, field.name)
        steps.append(
            replace(none, **{field.name: np.cos(np.arange(like.size)).reshape(like.shape)})
        )
    together = forward.rows_of_each(0, state, [none, *steps])
    for rows, step in zip(together, [none, *steps], strict=True):
        np.testing.assert_allclose(rows, forward.rows_of(0, state, step), rtol=1e-12, atol=1e-15)
    assert not np.any(together[0])
    force = together[1 + [f.name for f in fields(Perturbation)].index("force_N")]
    np.testing.assert_allclose(force[block.trend_rows], block.trend @ steps[3].force_N)


@pytest.mark.slow
def test_parts_of_pulses_are_taken_at_their_moments_in_each_pulse_of_their_condition():
    forward = base_fit().problem.forward
    for block, seen in zip(forward.row_index.blocks, forward.data_vectors, strict=True):
        parts = [(p.condition, at, width) for p in seen.pulses
                 for at, width in zip(p.middle_s, p.width_s, strict=True)]  # fmt: skip
        assert parts
        for i, (k, at, width) in enumerate(parts):
            pulses, own = seen.seen[k].kept_clock, block.bin_at == i
            moments = np.repeat(at + WITHIN * width, len(pulses.run_s))
            np.testing.assert_allclose(block.bin_clock.pulse_s[own], moments)
            begun = np.tile(pulses.run_s - pulses.pulse_s, len(WITHIN))
            np.testing.assert_allclose(block.bin_clock.run_s[own], begun + moments)
            np.testing.assert_array_equal(
                block.bin_sample.voltage_V[own], np.tile(pulses.voltage_V, len(WITHIN))
            )
