"""Parameters that are uncertain together: in the model, in its file, and in design's answers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import labrig
from model import Along, FitOptions, ModelError, SheetModel, fit, predict
from model.design.deviated import deviated
from model.design.force_map import force_map, resized
from model.design.propagation import propagate
from model.design.sizing import least_area
from model.design.working_section import shortest_sheet
from model.discrepancy.diagnose import diagnose
from model.identification.along_runs import eibm_along_runs
from model.identification.likelihood.noise.scatter_uncertainty import freedom
from model.sheet.deviations import (
    STIFFNESS,
    USUAL_FREEDOM,
    Deviations,
    columns_of,
    eibm_key,
    few_changes,
    few_columns,
    independent,
)

FALL_M = 0.012
PLACES_M = np.array([0.005, 0.01, 0.02, 0.035, 0.05])


@pytest.fixture(scope="module")
def falling(truth: SheetModel) -> SheetModel:
    """The long sheet with an EIBM that falls along it, written down place by place."""
    one = truth.sheet("long")
    s = np.linspace(0.0, one.sheet.free_length_m, 101)
    eibm = {
        v: Along(s, np.sign(v) * much * one.B.value * np.exp(-s / FALL_M), 0.0 * s, "N m")
        for v, much in ((2.0, 100.0), (-2.0, 80.0))
    }
    return SheetModel(sheets={"long": replace(one, eibm=eibm)})


@pytest.fixture(scope="module")
def fitted(falling: SheetModel, measure):
    return fit(measured(falling, measure, 3), FitOptions())


def measured(falling: SheetModel, measure, seed: int, force_N: float = 1e-4):
    """Four positions, and noise twice as large as usual."""
    return measure(seed, ("long",), (0, 7, 14, 21), force_N=force_N, curve_m=2e-5, model=falling)


def bent(model: SheetModel) -> list[float]:
    """How far the EIBM at +2 V turns the sheet up to some places, in rad."""
    one = model.sheet("long")
    return [float(one.eibm_at(2.0).integral(s)) / one.B.value for s in PLACES_M]


@pytest.mark.slow
def test_deviations_of_a_fit_have_its_uncertainties(fitted):
    model, found = fitted.varying_model, fitted.configurations["long"]
    answers = propagate(model, "long", lambda m: [m.sheet("long").B.value], ("N m^2",))
    assert answers[0].sigma == pytest.approx(found.B.sigma, rel=0.01)
    joint = fitted.joint
    rows = []
    for s in PLACES_M:
        row, doubt = joint._mean(0, 2.0, [s])
        assert doubt < 0.2 * np.sqrt(row @ joint.fitted.covariance @ row)
        row /= found.B.value / s  # Me/B is a parameter, and so B is not in it
        rest = list(joint.fitted.problem.bases.parts[0].rest)
        row[rest] = 0.0  # k0 is varied by itself
        rows.append(row)
    wanted = np.sqrt([row @ joint.fitted.covariance @ row for row in rows])
    told = [one.sigma for one in propagate(model, "long", bent, ("rad",) * len(PLACES_M))]
    np.testing.assert_allclose(told, wanted, rtol=0.02)
    # and so are their degrees of freedom: the same few set-ups are behind all columns
    assert answers[0].freedom == pytest.approx(found.B.freedom, rel=0.05)
    free = [freedom(joint.fitted.solution, joint.fitted.spread, row) for row in rows]
    told = [one.freedom for one in propagate(model, "long", bent, ("rad",) * len(PLACES_M))]
    np.testing.assert_allclose(told, free, rtol=0.05)


@pytest.mark.slow
def test_an_eibm_that_changes_along_runs_is_uncertain_by_as_much(falling, measure, fitted):
    assert eibm_along_runs(fitted.joint, 0)[2.0] < 0.005
    assert not any("along a run" in note for note in fitted.notes)
    data = measured(falling, measure, 3, force_N=2e-5)
    found = fit(first_pulse_weaker(data, 0.1), FitOptions())
    # of ten readings one is a tenth less
    assert eibm_along_runs(found.joint, 0)[2.0] == pytest.approx(0.1 / np.sqrt(10.0), rel=0.15)
    assert any("at +2 V changes by 3 % along a run" in note for note in found.notes)
    (angle,) = propagate(found.varying_model, "long", lambda m: bent(m)[-1:], ("rad",))
    assert angle.sigma == pytest.approx(0.1 / np.sqrt(10.0) * angle.value, rel=0.2)


@pytest.mark.slow
def test_noise_of_a_single_run_is_no_change_of_the_eibm_along_it(falling, measure):
    found = fit(measure(3, ("long",), (10,), force_N=2e-4, model=falling), FitOptions())
    assert eibm_along_runs(found.joint, 0) == {-2.0: 0.0, 2.0: 0.0}


def first_pulse_weaker(data, share: float):
    """The first reading at +2 V of each position has less of what the voltage adds."""
    at_rest = {c.position_m: np.mean([r.force_N for r in c.readings])
               for c in data.conditions if c.voltage_V == 0.0}  # fmt: skip

    def weaker(one):
        if one.voltage_V != 2.0:
            return one
        first, *others = one.readings
        less = share * (np.mean([r.force_N for r in one.readings]) - at_rest[one.position_m])
        return replace(one, readings=(replace(first, force_N=first.force_N - less), *others))

    return replace(data, conditions=tuple(map(weaker, data.conditions)))


@pytest.mark.slow
def test_a_model_file_keeps_how_parameters_are_uncertain_together(fitted):
    model = fitted.varying_model
    again = SheetModel.from_dict(model.to_dict())
    assert len(model.deviations["long"]) > 3
    for one, other in zip(*(propagate(m, "long", bent, ("rad",) * 5) for m in (model, again)),
                          strict=True):  # fmt: skip
        assert other.value == one.value
        assert other.sigma == one.sigma
        assert other.freedom == pytest.approx(one.freedom, rel=1e-3)


@pytest.mark.slow
def test_a_sheet_that_is_cut_deviates_at_the_same_places(fitted):
    model = fitted.varying_model
    change = model.deviations["long"].column(0)
    cut_first = deviated(resized(model, "long", 0.02, 0.06), "long", change, 1.0)
    cut_last = resized(deviated(model, "long", change, 1.0), "long", 0.02, 0.06)
    maps = [force_map(one, "long", (0.0, 0.01), (0.0, 2.0)) for one in (cut_first, cut_last)]
    np.testing.assert_array_equal(maps[0].tangential_N, maps[1].tangential_N)


def test_a_constant_eibm_that_deviates_along_the_sheet_is_one_along_it(truth):
    moved = deviated(truth, "long", {eibm_key(2.0, 1): 1e-6, eibm_key(-2.0, 0): 2e-6}, -1.0)
    one, before = moved.sheet("long"), truth.sheet("long")
    end = one.sheet.free_length_m
    mean = before.mean_eibm(2.0)
    assert one.eibm_at(2.0)(np.array([0.0, end])) == pytest.approx([mean + 1e-6, mean - 1e-6])
    assert one.mean_eibm(-2.0) == pytest.approx(before.mean_eibm(-2.0) - 2e-6)
    assert len(one.eibm[-2.0].s_m) == 1


def test_few_columns_lose_little_of_what_is_seen():
    random = np.random.default_rng(1)
    factor = random.standard_normal((6, 6)) * 10.0 ** -np.arange(6)
    rows = {f"row {i}": row for i, row in enumerate(factor)}
    found = Deviations(rows, independent(np.full(6, 9.0)))
    whole = factor @ factor.T
    np.testing.assert_allclose(columns_of(whole) @ columns_of(whole).T, whole, rtol=1e-6)
    turn = few_columns(found, [factor[:3]], 0.01)
    kept = np.stack(list(found.turned(turn).rows.values()))
    assert kept.shape[1] < 6
    share = np.diag(kept @ kept.T)[:3] / np.diag(whole)[:3]
    assert share.min() > 0.99


def test_variances_that_go_together_have_no_more_freedom_than_one_of_them():
    """Four set-ups are four, however many parameters they are seen in."""
    parts = np.array([[1.0, 1.0], [2.0, 0.0], [-1.0, 0.0]])  # (columns, answers)
    alike = Deviations({}, np.sqrt(2.0 / 5.0) * np.eye(3)[None])
    np.testing.assert_allclose(alike.freedom(parts), [5.0, 5.0])
    apart = Deviations({}, independent(np.full(3, 5.0)))
    np.testing.assert_allclose(apart.freedom(parts), [5.0 * 36.0 / 18.0, 5.0])
    turn = np.linalg.qr(np.random.default_rng(2).standard_normal((3, 3)))[0]
    np.testing.assert_allclose(apart.turned(turn).freedom(turn.T @ parts), apart.freedom(parts))
    known = alike.with_column({"B": 1.0})
    assert known.freedom(np.array([[0.0], [0.0], [0.0], [1.0]])) == USUAL_FREEDOM


def test_few_changes_of_a_covariance_say_what_all_say():
    random = np.random.default_rng(3)
    made = random.standard_normal((9, 4, 4)) * 4.0 ** -np.arange(9)[:, None, None]
    every = Deviations({}, made + made.transpose(0, 2, 1))
    few = Deviations({}, few_changes(every.changes))
    assert len(few.changes) < 7
    parts = random.standard_normal((4, 20))
    np.testing.assert_allclose(few.freedom(parts), every.freedom(parts), rtol=0.2)


def test_a_table_of_deviations_without_changes_has_independent_columns():
    data = {"freedom": [4.0, 9.0], "B": [1.0, 2.0]}
    found = Deviations.from_dict(data, "deviations")
    np.testing.assert_allclose(found.freedom(np.eye(2)), [4.0, 9.0])
    again = Deviations.from_dict(found.to_dict(), "deviations")
    np.testing.assert_allclose(again.changes, found.changes, rtol=1e-3)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        ([], "a table with a list 'freedom' is wanted"),
        ({"B": [1.0]}, "a table with a list 'freedom' is wanted"),
        ({"freedom": [9.0], "B": [1.0, 2.0]}, "as many numbers as in 'freedom' are wanted"),
        ({"freedom": [0.0], "B": [1.0]}, "positive numbers are wanted"),
        ({"freedom": [9.0], "B": ["much"]}, "B"),
        ({"freedom": [9.0], "covariance_changes": 1.0}, "a list of lists of numbers is wanted"),
        ({"freedom": [9.0, 9.0], "covariance_changes": [[1.0]]}, "3 numbers in each list"),
    ],
)
def test_a_wrong_table_of_deviations_is_named(data, said):
    with pytest.raises(ModelError, match=said):
        Deviations.from_dict(data, "configurations.long.deviations")


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(11, 16))
def test_a_fit_and_a_diagnosis_say_the_same_of_a_design_and_hold_the_truth(falling, measure, seed):
    """From one session: the EIBM along the sheet as polynomials, or as one of the catalogue."""
    data = measured(falling, measure, seed)
    named = diagnose(data)
    assert [one.name for one in named.model.effects] == ["nonuniform_eibm"]
    true, *found = (
        _sizes(model) for model in (falling, labrig.fit(data).varying_model, named.model)
    )
    for wanted, one, other in zip(true, *found, strict=True):
        apart = np.hypot(one.sigma, other.sigma)
        assert abs(one.value - other.value) < 3.0 * apart
        assert abs(one.value - wanted.value) < 3.5 * one.sigma
        assert abs(other.value - wanted.value) < 3.5 * other.sigma


def _sizes(model: SheetModel):
    place = (model, "long", 0.0, 0.025)
    with_elongation = least_area(*place, 5e-4, elongated=True).area_m2
    return shortest_sheet(*place).length_m, with_elongation


@pytest.mark.parametrize("joint", [True, False])
def test_forces_of_a_stiffness_that_is_unknown_are_as_uncertain(truth, joint):
    """As where shapes alone were measured: Me/B is known, and B is taken."""
    one = truth.sheet("long")
    rows = {STIFFNESS: np.array([one.B.value])}
    rows |= {eibm_key(v, 0): along.values[:1] for v, along in one.eibm.items()}
    known = {v: replace(along, sigma=along.values * 0.0) for v, along in one.eibm.items()}
    model = replace(
        truth,
        sheets={"long": replace(one, B=replace(one.B, sigma=one.B.value), eibm=known)},
        deviations={"long": Deviations(rows, np.zeros((0, 1, 1)))} if joint else {},
    )
    (force,) = propagate(model, "long", lambda m: [predict(m, "long", 0.0, 2.0).F_N], ("N",))
    assert force.sigma == pytest.approx(abs(force.value))
