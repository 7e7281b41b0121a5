"""How far a form may differ, and what a location's free shapes act on."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from model.discrepancy.prepare import DiagnoseOptions, prepare
from model.discrepancy.search import ranking
from model.discrepancy.search.evidence import Score
from model.discrepancy.search.form_share import form_share
from model.discrepancy.search.nonparametric_terms import linearised, shapes, unknowns
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.verdict.inferred_form import unknown_of
from model.effects import catalogue, effect
from model.effects.conformance import plausible
from model.identification.likelihood import form_ways
from model.identification.likelihood.form_error import effect_columns, whole_step
from model.identification.likelihood.form_ways import (
    FORM,
    HELD,
    OWN,
    SIGN,
    atoms,
    deviations,
    unit,
    waves_along,
)
from model.identification.likelihood.model_state import Found, moved
from model.locations import locations
from model.locations.quantities import Perturbation
from model.measurements import FloatArray
from tests.model.discrepancy.sessions import base_fit, fitted


def steps_of(name: str, values=None) -> tuple:
    base = base_fit()
    forward, states, one = base.problem.forward, base.linear.states, effect(name)
    values = values or plausible(one)
    return one, forward, states, [forward.step(c, states[c], one, values) for c in range(2)]


def test_a_form_differs_by_its_standard_deviation_along_the_sheet():
    """Many draws of the deviations scatter by a third of the form, averaged along the sheet."""
    one, forward, states, steps = steps_of("nonuniform_stiffness")
    G, step = forward.configuration_models[0].count, steps[0]
    ways = list(deviations(one, forward, 0, step, states[0].solved.contact))
    k = int(np.argmax(np.max(np.abs(step.beam[:, G : 2 * G]), axis=1)))
    form = step.beam[k, G : 2 * G]
    ratio = np.stack([way.share * way.step.beam[k, G : 2 * G] / form for way in ways])
    variance = forward.configuration_models[0].weights @ np.sum(ratio**2, axis=0)
    assert np.sqrt(variance) == pytest.approx(FORM, rel=0.05)


def test_what_may_differ_with_the_polarity_differs_with_it():
    one, forward, states, steps = steps_of("nonlinear_stiffness")
    assert "voltage" in one.form_error_along
    ways = [
        w
        for w in deviations(one, forward, 0, steps[0], states[0].solved.contact)
        if w.share == SIGN
    ]
    volts = forward.configuration_models[0].voltage_V
    assert len(ways) == 2
    G = forward.configuration_models[0].count
    odd, zero = (way.step.beam[:, G] / steps[0].beam[:, G] for way in ways)
    np.testing.assert_allclose(odd, np.sign(volts))
    np.testing.assert_allclose(zero, np.where(volts == 0.0, -1.0, 0.5))


def own_ways(name: str, share: float, values=None) -> list[list[FloatArray]]:
    """Return the factors of the ways of a standard deviation by condition, for each sheet."""
    one, forward, states, steps = steps_of(name, values)
    result = []
    for c, step in enumerate(steps):
        ways = deviations(one, forward, c, step, states[c].solved.contact)
        first = np.unique(forward.row_block(c).reading_of, return_index=True)[1]
        force, rows = step.force_N, [w.step.force_N for w in ways if w.share == share]
        some = np.where(force == 0.0, 1.0, force)
        result.append([(row / some)[first] for row in rows])
    return result


def test_what_sticks_differs_at_each_polarity_of_each_sheet():
    everywhere = {"force_mN": 0.2, "from_position_mm": 0.0, "kind": 3.0}
    volts = [
        np.sign(configuration_model.voltage_V)
        for configuration_model in base_fit().problem.forward.configuration_models
    ]
    ways = own_ways("roll_sticking", SIGN, everywhere)
    for sign, V, (alike, at_zero, own) in zip((1.0, -1.0), volts, ways, strict=True):
        touched = alike != 0.0
        assert np.count_nonzero(touched) > 10
        np.testing.assert_allclose(alike[touched], V[touched])
        np.testing.assert_allclose(own, sign * alike)
        assert not np.allclose(at_zero, own)


def test_friction_differs_at_0V_after_each_side_of_approach():
    felt = {"coefficient": 0.1, "force_alone": 1.0, "at_force_mN": 0.0}
    for configuration_model, (up, down) in zip(
        base_fit().problem.forward.configuration_models,
        own_ways("roll_friction", HELD, felt),
        strict=True,
    ):
        at_zero = configuration_model.voltage_V == 0.0
        np.testing.assert_allclose(up + down, at_zero)
        np.testing.assert_allclose(up, at_zero & (configuration_model.up > 0.0))


def test_what_the_approach_did_at_0V_is_no_deviation_from_a_form():
    base, one = base_fit(), effect("roll_friction")
    found = Found(effect=one, values={n: plausible(one) for n in base.problem.forward.names})
    columns, _, _ = effect_columns(base.problem.forward, base.linear, found, (found.active,))
    first, count = base.linear.columns.shape[1], columns.shape[1]
    linear = replace(base.linear, columns=np.concatenate([base.linear.columns, columns], axis=1))

    def share(of_way: int) -> float:
        solution = replace(base.solution, beta=np.eye(first + count)[first + of_way])
        spans = (slice(first, first + count),)
        return form_share(
            replace(base, found=(found,), linear=linear, solution=solution, spans=spans), 0
        )

    assert share(count - 1) == pytest.approx(0.0, abs=1e-9)  # all positions are approached upwards
    assert share(2) > 0.01  # a wave along the arc


def test_a_tolerance_as_wide_as_that_between_sheets_is_not_taken_for_it(monkeypatch):
    """Each sheet's own size is a parameter already; what differs along the sheet is not."""
    base, one = base_fit(), effect("initial_curvature")
    found = Found(effect=one, values={n: plausible(one) for n in base.problem.forward.names})

    def count() -> int:
        return effect_columns(base.problem.forward, base.linear, found, (found.active,))[0].shape[1]

    usual = count()
    monkeypatch.setattr(form_ways, "FORM", OWN)
    monkeypatch.setattr(
        form_ways, "waves_along", lambda count: [(j, 1.0) for j in range(1, count + 1)]
    )
    assert count() == usual


@pytest.mark.parametrize(("name", "share"), [("initial_curvature", OWN), ("clamp_angle", SIGN)])
def test_the_second_column_is_the_difference_between_the_sheets(name: str, share: float):
    one, forward, states, steps = steps_of(name)
    found = atoms(forward, states, one, steps)
    long, short = (forward.rows_of(c, states[c], s) for c, s in enumerate(steps))
    rounding = 1e-15 * float(np.max(np.abs([long, short])))
    np.testing.assert_allclose(found[:, 0], long + short, atol=rounding)
    np.testing.assert_allclose(found[:, 1], share * (long - short), atol=rounding)


@pytest.mark.parametrize("name", list(catalogue()))
def test_every_effect_is_columns_that_count(name: str):
    one, forward, states, steps = steps_of(name)
    found = atoms(forward, states, one, steps)
    assert np.all(np.isfinite(found))
    assert found.shape[0] == forward.row_index.size
    assert np.all(np.any(found[:, 1:], axis=0))


def test_an_effect_in_the_model_has_its_parameters_first_then_its_form_errors():
    base = base_fit()
    problem = base.problem
    for name, by_sheet in (("initial_curvature", 2), ("force_offset", 1)):
        one = effect(name)
        found = Found(effect=one, values={n: plausible(one) for n in problem.forward.names})
        assert len(found.parameters()) == by_sheet
        columns, precision, away = effect_columns(
            problem.forward, base.linear, found, (found.active,)
        )
        step = 1e-4 * one.amplitude.prior_scale
        rows = []
        for sign in (-1.0, 1.0):
            p = {**plausible(one), one.amplitude.name: one.amplitude.prior_scale + sign * step}
            whole = [
                study_rows(base, c, replace(found, values=dict.fromkeys(problem.forward.names, p)))
                for c in range(2)
            ]
            rows.append(whole if by_sheet == 2 else [np.sum(whole, axis=0)])
        for j in range(by_sheet):
            slope = (rows[1][j] - rows[0][j]) / (2.0 * step)
            size = np.max(np.abs(slope))
            np.testing.assert_allclose(columns[:, j], slope, atol=2e-3 * size)
        assert np.all(precision[by_sheet:] == 1.0)
        assert not np.any(away[by_sheet:])
        assert away[0] == pytest.approx(one.amplitude.prior_scale - one.amplitude.neutral)


def study_rows(base, c: int, found: Found):
    forward = base.problem.forward
    start = base.problem.bases.beam(forward, c, base.theta)
    step = whole_step(forward, c, base.linear.states[c], start, (), found.active)
    return forward.rows_of(c, base.linear.states[c], step)


def test_a_step_of_the_fit_keeps_values_within_their_bounds():
    one = effect("roll_friction")
    found = Found(effect=one, values={"long": plausible(one)})
    ((after,), largest) = moved((found,), np.array([-50.0]), np.array([0.01]), [slice(0, 1)])
    assert after.values["long"]["coefficient"] == one.amplitude.low == 0.0
    assert after.values["long"]["force_alone"] == plausible(one)["force_alone"]
    assert largest == pytest.approx(5000.0)
    assert moved((found,), np.array([1e-4]), np.array([0.01]), [slice(0, 1)])[1] == pytest.approx(
        0.01
    )


def test_finite_values_are_brought_to_nought_and_one():
    np.testing.assert_allclose(unit(np.array([2.0, np.nan, 4.0, 3.0])), [0.0, 0.5, 1.0, 0.5])
    np.testing.assert_allclose(unit(np.array([7.0, 7.0])), 0.5)
    np.testing.assert_allclose(unit(np.full(2, np.nan)), 0.5)


# ------------------------------------------------------------------------------- locations


def acting(step: Perturbation, G: int) -> set[str]:
    """What a step changes; of the beam problem: curvature, softness, or contact."""
    parts = {"curvature": slice(0, G), "soft": slice(G, 2 * G), "contact": slice(2 * G, None)}
    found = {name for name, place in parts.items() if np.any(step.beam[:, place])}
    others = [f.name for f in fields(Perturbation) if f.name != "beam"]
    return found | {name for name in others if np.any(getattr(step, name))}


ALLOWED = {
    "rest_curvature": {"curvature", "contact"},  # a kink at the clamp turns the arc
    "eibm": {"curvature"},
    "even_moment": {"curvature"},
    "compliance": {"curvature", "soft"},
    "position": {"contact", "curvature"},  # rolls that turn the sheet
    "load_cell": {"force_N"},
    "camera": {"points_m", "frame_eibm"},
    # a clamp that slips, a sheet that curls, too
    "time": {"curvature", "eibm", "stiffness", "force_N", "bin_eibm", "bin_stiffness", "contact"},
}


@pytest.mark.parametrize("location", locations())
def test_free_shapes_act_on_what_their_slot_says_and_nothing_else(location):
    base = base_fit()
    forward = base.problem.forward
    made = [one.step for one in locations()[location].bases(linearised(base, 0))]
    found = set().union(*(acting(step, forward.configuration_models[0].count) for step in made))
    assert found == ALLOWED[location]


def test_the_eibm_s_shapes_change_sign_with_the_voltage_and_the_even_ones_do_not():
    base = base_fit()
    forward = base.problem.forward
    volts, G = forward.configuration_models[0].voltage_V, forward.configuration_models[0].count
    for location, sign in (("eibm", -1.0), ("even_moment", 1.0)):
        for one in locations()[location].bases(linearised(base, 0)):
            step = one.step
            assert not np.any(step.beam[volts == 0.0])
            if one.along == "bending":  # the way the sheet is bent goes with the voltage, too
                continue
            up, down = (step.beam[volts == v, :G][0] for v in (2.0, -2.0))
            assert np.all(np.sign(up) == sign * np.sign(down))


def test_the_load_cell_s_shapes_leave_the_curves_alone_and_the_camera_s_the_forces():
    base = base_fit()
    row_index = base.problem.forward.row_index
    modes = np.concatenate([p.mode_rows.ravel() for p in row_index.blocks])
    means = np.concatenate([p.trend_rows for p in row_index.blocks])
    assert not any(np.any(s.rows[modes]) for s in shapes(base, "load_cell"))
    assert not any(np.any(s.rows[means]) for s in shapes(base, "camera"))


@pytest.mark.slow
def test_there_is_one_candidate_for_each_slot_and_none_for_what_nobody_could_see(measure):
    found = [c.name for c in unknowns(base_fit()) if not c.part]
    assert found == [f"unknown:{s}" for s in locations()]
    blind = prepare(measure(curves=False, scatter=0.0), DiagnoseOptions())
    assert "unknown:camera" not in [c.name for c in unknowns(fitted(measure(curves=False)))]
    assert any("has no curves" in note for note in blind.notes)


def test_what_the_rig_does_it_does_to_every_configuration_alike():
    for name in ("load_cell_compliance", "position_error", "camera_scale"):
        one, forward, states, steps = steps_of(name)
        assert one.of_the_rig
        columns = atoms(forward, states, one, steps)
        whole = [forward.rows_of(c, states[c], step) for c, step in enumerate(steps)]
        np.testing.assert_allclose(columns[:, 0], whole[0] + whole[1])
        opposite = whole[0] - whole[1]
        for column in columns[:, 1:].T:
            cosine = column @ opposite / np.linalg.norm(column) / np.linalg.norm(opposite)
            assert abs(cosine) < 0.99, name


@pytest.mark.parametrize(
    ("name", "within"),
    [("force_offset", ()), ("force_drift", ("session",)), ("surface_tension", ("run",))],
)
def test_a_zero_wanders_over_the_session_alone_and_a_meniscus_dries_in_each_run(name, within):
    one, forward, states, steps = steps_of(name)
    contact = states[0].solved.contact
    some = list(deviations(one, forward, 0, steps[0], contact))
    terms = [term for way in some for term in way.terms()]
    timed = {term.along for term in terms} & {"pulse", "session", "run"}
    assert timed == set(within)
    assert bool(some) is (name != "force_offset")


def test_a_slot_is_looked_for_as_a_whole_and_part_by_part():
    base = base_fit()
    found = [(c.name, c.part) for c in unknowns(base) if c.location in ("position", "eibm")]
    assert found == [
        ("unknown:eibm", ""), ("unknown:eibm", "s"), ("unknown:eibm", "position"),
        ("unknown:eibm", "curvature"), ("unknown:eibm", "bending, which way"),
        ("unknown:position", ""), ("unknown:position", "position"),
        ("unknown:position", "polarity"), ("unknown:position", "zero"),
        ("unknown:position", "reach"), ("unknown:position", "position and reach"),
        ("unknown:position", "force"), ("unknown:position", "reach, by place"),
        ("unknown:position", "position, run"),
        ("unknown:position", "moment"),
    ]  # fmt: skip
    whole, *parts = [c.columns for c in unknowns(base) if c.location == "position"]
    # what is constant is a wave of "position", too; what goes with the force is looked for alone
    assert [p.shape[1] for p in parts] == [7, 7, 1, 7, 14, 5, 12, 3, 10]
    assert whole.shape[1] == 7 + 7
    assert len(shapes(base, "position", "polarity")) == parts[1].shape[1]


def test_a_screw_s_error_at_each_position_is_one_shape_for_both_sheets():
    base = base_fit()
    row_index = base.problem.forward.row_index
    own = [np.concatenate([p.trend_rows for p in (block,)]) for block in row_index.blocks]
    for shape in shapes(base, "position", "position"):
        assert all(np.any(shape.rows[rows]) for rows in own)


def test_waves_along_the_sheet_have_the_form_s_standard_deviation_however_many():
    for count in (1, 3, 7):
        numbers, shares = zip(*waves_along(count), strict=True)
        assert numbers == tuple(range(1, count + 1))
        assert np.sum(np.square(shares)) == pytest.approx(1.0)
        assert np.all(np.diff(shares) < 0.0)


@pytest.mark.thorough
def test_what_is_looked_for_alone_has_a_profile_to_be_told():
    base = base_fit()
    for one in unknowns(base):
        found = shapes(base, one.location, one.part)
        assert len(found) == one.columns.shape[1]
        assert one.location == "camera" or any(shape.function for shape in found), (
            one.location,
            one.part,
        )


@pytest.mark.slow
def test_whatever_is_unknown_can_be_told():
    base = base_fit()
    for one in unknowns(base):
        told = unknown_of(
            base,
            RankedCandidate(
                score=Score(candidate=one, log_bayes=9.0, amplitude=1.0, scale=0.1, length=1.0),
                ln_bayes_factor=9.0,
            ),
        )
        assert told.location == one.location
        assert np.all(np.isfinite(told.profile)), (one.location, one.part)
        assert np.any(told.band > 0.0), (one.location, one.part)
        in_mm = one.location in ("position", "camera") and one.part not in ("age", "moment")
        in_mm |= one.part == "elongation"
        assert (told.unit == "mm") == in_mm


@pytest.mark.thorough
def test_a_profile_is_that_of_one_part_along_its_own_coordinate():
    """Error at both polarities alike and error of opposite sign are not added up, nor are times."""
    base = base_fit()
    ends = {
        "session": (1.0, "of the session"), "run": (20.0, "s into the run"),
        "pulse": (0.6, "s into the pulse"), "train": (13.2, "s under voltage"),
    }  # fmt: skip
    for one in (c for c in unknowns(base) if c.part and c.location in ("position", "time")):
        found = shapes(base, one.location, one.part)
        keys = {(s.configuration, s.part, s.along, s.under) for s in found}
        # the place that is touched is one of each sheet's own
        sheets = 2 if one.part == "reach, by place" else 1
        assert len({key[:3] for key in keys}) == sheets
        assert len(keys) == {"moment": 3, "EIBM, train": 2}.get(one.part, sheets)
        told = unknown_of(
            base,
            RankedCandidate(
                score=Score(candidate=one, log_bayes=9.0, amplitude=1.0, scale=0.1, length=1.0),
                ln_bayes_factor=9.0,
            ),
        )
        assert told.along == found[0].along
        end_mm = 30.0
        if sheets > 1:  # of one sheet, over all of its length
            end_mm = next(s.span[1] for s in found if s.configuration == told.configuration)
        during = one.part.rpartition(", ")[2]
        if during in ends:
            assert (told.s_mm[-1], told.at_unit) == ends[during]
            other_way = ", the other way at the other polarity"
            assert told.depends.removesuffix(other_way).endswith(during)
        elif one.part == "force":
            assert (told.along, told.at_unit) == ("force", "mN")
        else:
            assert (told.s_mm[-1], told.at_unit) == (pytest.approx(end_mm), "mm")
        units = {
            "force, run": "mN",
            "clamp, session": "rad",
            "moment": "1/m",
            "curvature, session": "1/m",
        }
        assert told.unit == units.get(one.part, "mm" if one.location == "position" else "relative")


def test_what_is_a_function_of_the_force_has_a_profile_along_the_force():
    base = base_fit()
    one = next(c for c in unknowns(base) if (c.location, c.part) == ("load_cell", "force"))
    told = unknown_of(
        base,
        RankedCandidate(
            score=Score(candidate=one, log_bayes=9.0, amplitude=1.0, scale=0.1, length=1.0),
            ln_bayes_factor=9.0,
        ),
    )
    measured_mN = 1e3 * np.concatenate(
        [p.measured_N for p in base.problem.forward.row_index.blocks]
    )
    assert (told.along, told.at_unit, told.unit) == ("force", "mN", "mN")
    assert told.s_mm[[0, -1]] == pytest.approx([measured_mN.min(), measured_mN.max()])
    assert told.depends.endswith("a function of the force")


@pytest.mark.parametrize("power", [2, 3])
def test_whatever_the_load_cell_makes_of_the_force_is_among_its_shapes(power: int):
    """Beside a wrong gain, which is B, and a wrong zero."""
    base = base_fit()
    forward = base.problem.forward

    def added(power: int) -> FloatArray:
        steps = [
            (c, state, 1e-4 * (state.weighed.force_N / 1e-3) ** power)
            for c, state in enumerate(base.linear.states)
        ]
        return sum(
            forward.rows_of(c, state, replace(forward.no_step(c), force_N=force))
            for c, state, force in steps
        )

    own = [shape.rows for shape in shapes(base, "load_cell", "force")]
    known = np.stack([added(0), added(1), *own], axis=1)
    rows = added(power)
    left = rows - known @ np.linalg.lstsq(known, rows, rcond=None)[0]
    assert np.linalg.norm(left) < 1e-6 * np.linalg.norm(rows)


@pytest.mark.parametrize("location", ["load_cell", "compliance"])
def test_what_is_there_under_voltage_only_is_alike_at_both_polarities(location):
    base = base_fit()
    forward = base.problem.forward
    block, volts = forward.row_block(0), forward.configuration_models[0].voltage_V
    for one in locations()[location].bases(linearised(base, 0)):
        if one.part != "voltage":
            continue
        acts = block.mean(one.step.force_N) if location == "load_cell" else one.step.beam[:, -10]
        assert not np.any(acts[volts == 0.0])
        np.testing.assert_allclose(acts[volts == 2.0], acts[volts == -2.0])
    names = [s.part for s in shapes(base, location)]
    assert "voltage" in names


def test_a_clamp_may_turn_while_the_session_goes_on():
    base = base_fit()
    turns = shapes(base, "time", "clamp, session")
    assert len(turns) == 8
    block = base.problem.forward.row_index.blocks[0]
    assert all(np.any(s.rows[block.mode_rows]) for s in turns)  # shapes turn with it


def test_what_only_the_usual_scatter_allows_is_looked_at_too(monkeypatch):
    """With scatter that a misfit has blown up, an effect may seem to have the wrong sign."""
    base, seen = base_fit(), list[str]()

    def scores(fitted, every, solution):
        found = best_of(fitted, every, solution)
        usual = solution is not fitted.solution
        return {n: s for n, s in found.items() if usual or n != "gravity"}

    best_of = ranking._by_name
    monkeypatch.setattr(ranking, "_by_name", scores)
    monkeypatch.setattr(ranking, "RESCORED_CANDIDATES", 40)
    monkeypatch.setattr(ranking, "RESCORED_EVIDENCE_LN", -np.inf)  # gravity explains nothing here

    def rescored(fitted, one):
        seen.append(one.candidate.name)
        return one.log_bayes, fitted.solution

    monkeypatch.setattr(ranking, "rescored", rescored)
    found = ranking.rank(base, [effect("gravity"), effect("clamp_angle")], locations=False)
    assert {c.name for c in found} >= {"gravity", "clamp_angle"}
    assert "gravity" in seen


def test_a_slot_as_a_whole_has_each_shape_once():
    base = base_fit()
    for location in ("rest_curvature", "position", "load_cell"):
        rows = np.stack([s.rows for s in shapes(base, location)], axis=1)
        unit = rows / np.linalg.norm(rows, axis=0)
        cosine = unit.T @ unit - np.eye(rows.shape[1])
        assert np.max(np.abs(cosine)) < 1.0 - 1e-9, location
