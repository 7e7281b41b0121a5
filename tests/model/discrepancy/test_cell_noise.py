"""A force that the noise of the load cell would swallow is told as something unknown there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from model.discrepancy import Diagnosis, diagnose
from model.discrepancy.criticism.catalogue import verdict_checks
from model.discrepancy.criticism.cell_noise import CellNoise, unusual_cell_noise
from model.discrepancy.criticism.check_result import Consequence
from model.discrepancy.search.evidence import Candidate, Score
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.thresholds import ALARMING_SCATTER_RATIO
from model.measurements import Condition, Measurements
from tests.fits_unchecked import fits_unchecked
from tests.model.discrepancy.sessions import FALLING, NOTHING, base_fit, fitted, session

GAP_N = 3e-4  # far more than the noise


def with_force(m: Measurements, added_N: Callable[[Condition], float]) -> Measurements:
    """Return the same with a force in all readings of each condition, and no other forces."""

    def one(condition: Condition) -> Condition:
        if condition.position_m is None:
            return condition
        more = added_N(condition)
        readings = (replace(r, force_N=r.force_N + more) for r in condition.readings)
        return replace(condition, readings=tuple(readings))

    return replace(m, series=(), conditions=tuple(map(one, m.conditions)))


def along_the_arc(condition: Condition) -> float:
    """Change its sign amid the arc, alike on both sheets."""
    at_m = condition.position_m or 0.0
    return GAP_N * float(np.tanh((at_m - 0.015) / 0.005))


def by_chance(size_N: float, seed: int = 3) -> Callable[[Condition], float]:
    """Return another force in each run, which does not come back."""
    random, known = np.random.default_rng(seed), dict[tuple[object, ...], float]()

    def one(condition: Condition) -> float:
        key = condition.configuration, condition.position_m, condition.mounting
        return known.setdefault(key, size_N * float(random.standard_normal()))

    return one


@cache
def beside_a_name(kind: str) -> Diagnosis:
    added = {"gap": along_the_arc, "chance": by_chance(0.5 * GAP_N)}[kind]
    with fits_unchecked():
        return diagnose(with_force(session(FALLING), added))


@pytest.mark.thorough
@pytest.mark.slow
def test_a_force_that_goes_with_the_position_is_unknown_beside_a_name():
    found = beside_a_name("gap")
    assert [one.name for one in found.effects] == ["nonuniform_eibm"]
    assert found.verdict == "unknown_effect"
    assert found.unknown is not None
    assert found.unknown.location == "load_cell"
    low, high = np.min(found.unknown.profile), np.max(found.unknown.profile)
    assert low < -0.7e3 * GAP_N  # mN
    assert high > 0.7e3 * GAP_N
    failed = {one.name: one.sentence for one in found.checks if not one.passed}
    assert list(failed) == ["cell_noise"]
    assert "Check 'cell_noise' failed: beside the names the " in found.sentence
    assert "times the usual one, and what it takes up is smooth or comes back" in found.sentence


@pytest.mark.thorough
def test_noise_of_the_load_cell_without_an_order_names_nothing_new():
    found = beside_a_name("chance")
    assert [one.name for one in found.effects] == ["nonuniform_eibm"]
    assert found.unknown is None or found.unknown.location != "load_cell"


@pytest.mark.thorough
@pytest.mark.slow
def test_usual_noise_of_the_load_cell_is_not_looked_at():
    assert unusual_cell_noise(base_fit(NOTHING)) is None


@pytest.mark.thorough
@pytest.mark.slow
def test_what_comes_back_on_the_other_sheet_is_no_noise():
    found = unusual_cell_noise(fitted(with_force(session(NOTHING), along_the_arc)))
    assert found is not None
    assert found.term is not None
    assert found.term.score.candidate.location == "load_cell"


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, pytest.param(4, marks=pytest.mark.thorough)])
def test_what_is_another_one_in_each_run_is_noise(seed: int):
    found = unusual_cell_noise(fitted(with_force(session(NOTHING), by_chance(GAP_N, seed))))
    assert found is not None
    assert found.times > ALARMING_SCATTER_RATIO
    assert found.term is None


def _term() -> RankedCandidate:
    candidate = Candidate(
        name="unknown:load_cell", values={}, columns=np.zeros((1, 1)), sizes=(1.0,)
    )
    one = Score(candidate=candidate, log_bayes=30.0, amplitude=1.0, scale=1.0, length=1.0)
    return RankedCandidate(score=one, ln_bayes_factor=30.0)


@pytest.mark.parametrize(
    ("noise", "said"),
    [
        (None, []),
        (CellNoise(name="sway_slow", times=4.0, order=0.0), []),
        (
            CellNoise(name="sway_slow", times=14.0, order=0.0),
            ["slow wander of the load cell is 14 times the usual one, without any order in it"],
        ),
        (CellNoise(name="force_zero", times=14.0, order=0.0), []),  # `scatter` says it
        (
            CellNoise(name="sway_slow", times=4.0, order=30.0, ranking=(_term(),)),
            ["is 4 times the usual one, and what it takes up is smooth or comes back"],
        ),
    ],
)
def test_the_check_says_what_is_larger_and_whether_it_has_an_order(noise, said):
    check = verdict_checks()["cell_noise"]
    failures = list(check.failures(SimpleNamespace(cell_noise=noise)))
    assert len(failures) == len(said)
    for failure, words in zip(failures, said, strict=True):
        assert words in failure.sentence
        assert (failure.consequence, failure.effects) == (Consequence.REMARK, ())
