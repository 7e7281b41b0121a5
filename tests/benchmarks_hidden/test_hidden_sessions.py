"""Sessions with something hidden: what they hold, and that the truth stays apart."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.hidden_effects import Case, Extras, Hidden, case, hidden_session, write
from benchmarks.hidden_effects.recipe import RISE_S
from benchmarks.hidden_effects.sessions import prepared
from labrig.config import load_sheet
from labrig.session.tables.read import read_tables
from model import FitOptions, Measurements
from model.identification.fit import fit
from model.identification.fit_result import Fit
from sim_hardware.world import Visit, timed_session

pytestmark = pytest.mark.thorough

ALL_EXTRAS = Extras(free_shapes=True, remounts=2, random_order=True, reversed_approach=True)


def test_a_session_is_the_paper_s_with_its_course_in_time() -> None:
    found = hidden_session(case(seed=2)).measurements
    assert len(found.conditions) == 2 * 7 * 3
    assert len(found.series) == 2 * 7
    began = -np.inf
    for zero, plus, minus in zip(*(found.conditions[k::3] for k in range(3)), strict=True):
        assert [c.voltage_V for c in (zero, plus, minus)] == [0.0, 2.0, -2.0]
        assert [len(c.used()) for c in (zero, plus, minus)] == [10, 10, 10]
        assert [r.kind for r in plus.readings] == ["discarded"] + ["kept"] * 10
        assert [r.index for r in plus.readings] == list(range(10, 32, 2))
        for r in (*zero.readings, *plus.readings, *minus.readings):
            assert r.time_s == pytest.approx(0.6 * r.index + 0.5)
            assert r.wetted_s is not None
            assert r.wetted_s - r.time_s == pytest.approx(8.0)
            assert r.curve is not None
        first = zero.readings[0].session_s
        assert first is not None
        assert first > began + 19.2
        began = first
    for series in found.series:
        assert series.force_N is not None
        assert series.force_N.size == series.drive_V.size == 1920
    assert all(sheet.rise_time_s == 0.03 for sheet in found.sheets.values())


def test_means_alone_have_neither_times_nor_series_nor_curves_of_readings() -> None:
    full = hidden_session(case(seed=2)).measurements
    means = hidden_session(case(seed=2, streams="means")).measurements
    assert means.series == ()
    for a, b in zip(full.conditions, means.conditions, strict=True):
        assert [r.force_N for r in a.readings] == [r.force_N for r in b.readings]
        assert np.array_equal(a.curve.y_m, b.curve.y_m)  # type: ignore[union-attr]
        assert all(r.time_s is r.session_s is r.wetted_s is r.curve is None for r in b.readings)


def test_extras_are_measured_where_they_are_asked_for() -> None:
    found = hidden_session(case(seed=4, extras=ALL_EXTRAS)).measurements
    for name in ("long", "short"):
        mine = [c for c in found.conditions if c.configuration == name and c.voltage_V == 0]
        assert mine[0].position_m is None
        assert [r.kind for r in mine[0].readings] == ["no_contact"] * 2
        ordered = [c.position_m for c in mine[1:8]]
        assert sorted(ordered) == pytest.approx(0.005 * np.arange(7))  # type: ignore[type-var]
        assert ordered != sorted(ordered)  # type: ignore[type-var]
        assert (mine[8].approach, mine[8].run, mine[8].position_m) == ("down", 1, 0.015)
        assert [(c.position_m, c.mounting) for c in mine[9:]] == [(0.0, 1), (0.03, 1)]
    keys = [(s.configuration, s.position_m, s.mounting, s.run) for s in found.series]
    assert len(set(keys)) == len(keys) == 2 * (1 + 7 + 1 + 2)


def test_before_each_position_the_load_cell_is_read_alone_where_that_is_asked_for() -> None:
    plain, found = (
        hidden_session(case(seed=4, extras=Extras(no_touch_zero=zeros))).measurements
        for zeros in (False, True)
    )
    alone = [c for c in found.conditions if c.position_m is None]
    assert len(alone) == 14 == len({(c.configuration, c.run) for c in alone})
    for c in alone:
        assert (c.voltage_V, c.curve, {r.kind for r in c.readings}) == (0.0, None, {"no_contact"})
        assert len(c.readings) == 10
        assert abs(np.mean([r.force_N for r in c.readings])) < 1e-4  # nothing touches it
    assert len(found.conditions) == len(plain.conditions) + 14


def test_scatter_outliers_and_correlation_are_as_asked_for() -> None:
    usual, none, outlier, wandering = (
        hidden_session(case(seed=6, **options))
        for options in ({}, {"scatter": 0.0}, {"outlier": True}, {"correlated": True})
    )
    assert all(s.eibm == s.stiffness == 1.0 and s.position_m == 0 for s in none.truth.scatter)
    assert np.std([s.eibm for s in usual.truth.scatter]) == pytest.approx(0.01, rel=0.5)
    odd = outlier.truth.outlier
    assert odd is not None
    for k, (a, b) in enumerate(zip(usual.truth.scatter, outlier.truth.scatter, strict=True)):
        assert (a == b) == (k != odd)
        assert k != odd or b.position_m - a.position_m == pytest.approx(0.6e-3)

    def alike(hidden: Hidden) -> float:
        products, squares = [], []
        for c in hidden.measurements.conditions:
            off = np.array([r.force_N for r in c.used()])
            off -= off.mean()
            products.append(np.mean(off[1:] * off[:-1]))
            squares.append(np.mean(off**2))
        return float(np.sum(products) / np.sum(squares))

    assert alike(wandering) > max(0.5, alike(usual) + 0.1)


def test_the_same_case_gives_the_same_data_and_another_seed_other_data() -> None:
    small = case("charging_lag", seed=8)
    first, again = hidden_session(small), hidden_session(replace(small))
    for a, b in zip(first.measurements.conditions, again.measurements.conditions, strict=True):
        assert a.readings[-1].curve is not None
        assert [r.force_N for r in a.readings] == [r.force_N for r in b.readings]
        assert np.array_equal(a.curve.x_m, b.curve.x_m)  # type: ignore[union-attr]
    assert first.truth == again.truth
    other = hidden_session(replace(small, seed=9))
    assert (
        other.measurements.conditions[0].readings[0].force_N
        != first.measurements.conditions[0].readings[0].force_N
    )


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Hidden, Path]:
    hidden = hidden_session(
        case("local_eibm", seed=5, extras=replace(ALL_EXTRAS, remounts=1), series_hz=10.0)
    )
    folder = tmp_path_factory.mktemp("hidden") / "session"
    write(hidden, folder)
    return hidden, folder


def test_the_files_are_what_labrig_imports(written: tuple[Hidden, Path]) -> None:
    hidden, folder = written
    sheets = load_sheet(folder / "sheet.toml")
    read = read_tables(sheets, *(folder / f"{n}.csv" for n in ("forces", "curves", "signals")))
    was = hidden.measurements
    for name, sheet in was.sheets.items():
        mine = sheets[name]
        assert mine.rise_time_s == sheet.rise_time_s
        assert mine.free_length_m == pytest.approx(sheet.free_length_m)
        assert mine.initial_curvature is not None
        for a, b in zip(mine.initial_curvature, sheet.initial_curvature, strict=True):  # type: ignore[arg-type]
            assert a == pytest.approx(b)
    assert len(read.conditions) == len(was.conditions)
    for a, b in zip(was.conditions, read.conditions, strict=True):
        assert replace(a, readings=(), curve=None) == replace(b, readings=(), curve=None)
        for r, s in zip(a.readings, b.readings, strict=True):
            assert replace(r, curve=None) == replace(s, curve=None)
            assert np.array_equal(r.curve.y_m, s.curve.y_m)  # type: ignore[union-attr]
    assert len(read.series) == len(was.series)


def test_the_truth_is_in_none_of_the_files_but_its_own(written: tuple[Hidden, Path]) -> None:
    hidden, folder = written
    assert sorted(p.name for p in folder.iterdir()) == [
        "curves.csv", "forces.csv", "sheet.toml", "signals.csv"
    ]  # fmt: skip
    truth = json.loads(folder.with_name("session.truth.json").read_text())
    (effect,) = truth["effects"]
    assert (effect["effect"], effect["slot"], effect["place_mm"]) == (
        "local_eibm",
        "eibm",
        [22, 38],
    )
    bare = write(hidden_session(replace(hidden.case, hidden=())), folder.with_name("bare"))
    for path in bare:  # the same columns and rows, whatever is hidden
        lines = [(folder / path.name).read_text().splitlines(), path.read_text().splitlines()]
        assert lines[0][0] == lines[1][0]
        assert len(lines[0]) == len(lines[1])
    assert (folder / "sheet.toml").read_text() == (folder.parent / "bare/sheet.toml").read_text()
    words = {"local_eibm", "eibm", "bump", "hidden", "truth", "world", "seed", "scatter"}
    for path in folder.iterdir():
        text = path.read_text().lower()
        assert not [word for word in words if word in text]


# ------------------------------------------------------------------------------- nothing hidden

CONSTANT = FitOptions(eibm_form="constant", initial_curvature_sigma_per_m=0.0)


def base_fit(measurements: Measurements) -> Fit:
    return fit(measurements, CONSTANT)


def test_where_nothing_is_hidden_the_moment_goes_with_the_voltage_at_the_sheet() -> None:
    recipe, _ = prepared(case(scatter=0.0))
    for key in ("noise_mN", "drift_mN"):
        recipe.set(f"load_cell.{key}", 0.0)
    (run,) = timed_session(
        recipe.settings(), [Visit(configuration="short", position_m=0.01)], series_hz=200.0
    )
    since = run.time_s - 0.6 * np.floor(run.time_s / 0.6)
    risen = np.exp(-since / RISE_S)

    def settled(volts: float) -> float:
        return next(r.force_N for r in reversed(run.readings) if r.voltage_V == volts)

    for volts, ratio, other in ((2.0, 1.0, -2.0), (-2.0, 0.8, 2.0)):
        now = (np.sign(run.drive_V) == np.sign(volts)) & (run.time_s > 6.6)
        sheet_V = volts + (other - volts) * risen[now]
        share = np.where(sheet_V * volts > 0, sheet_V / volts, 0.8 / ratio**2 * sheet_V / volts)
        expected = settled(0.0) + share * (settled(volts) - settled(0.0))
        # the short sheet's force is straight in the moment within some parts in a thousand
        assert np.abs(run.force_N[now] - expected).max() < 5e-3 * np.ptp(run.force_N)


def chi2_per_number(found: Fit) -> float:
    """Of what the fit leaves, with the scatter that it found, over the numbers it is made of."""
    data, solution = found.joint.fitted.linear.data, found.joint.fitted.solution
    left = data.y - data.X @ solution.beta
    chi2 = float(np.einsum("ri,rij,rj", left, solution.weights, left))
    there = data.fixed < 0.5  # rows that a run does not have have the variance one
    return chi2 / (int(there.sum()) - data.X.shape[2])


@pytest.mark.parametrize("rest", ["exp", "nodes", "constant"])
@pytest.mark.parametrize("seed", [21, 22])
def test_where_nothing_is_hidden_the_base_model_fits(rest: str, seed: int) -> None:
    hidden = hidden_session(Case(seed=seed, rest=rest))  # type: ignore[arg-type]
    found = base_fit(hidden.measurements)
    for name, one in found.configurations.items():
        assert one.B.value == pytest.approx(hidden.truth.B_Nm2[name], rel=0.02)
        for volts, eibm in one.eibm.items():
            assert eibm.value == pytest.approx(hidden.truth.mean_eibm_Nm[name][volts], rel=0.02)
    # forces and shapes miss by no more than positions off by 0.05 mm and moments by 1 % make them
    assert found.rmse["constant"].force_N < 0.05e-3
    assert found.rmse["constant"].curve_m < 0.05e-3
    assert 0.7 < chi2_per_number(found) < 1.3
    # and the scatter that the fit needs for that is the one that there was
    there = hidden.truth.scatter
    for name, values in (
        ("stiffness", [s.stiffness for s in there]), ("eibm", [s.eibm for s in there]),
        ("position", [s.position_m for s in there]),
    ):  # fmt: skip
        assert found.scatter[name] < 1.7 * np.std(values)


def test_where_something_is_hidden_the_base_model_does_not_fit() -> None:
    found = base_fit(hidden_session(case("nonuniform_eibm", size=0.5, seed=21)).measurements)
    assert found.rmse["constant"].force_N > 0.2e-3
