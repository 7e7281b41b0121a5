"""Evidence is that of a Gaussian model; sizes have the signs that effects can have."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model.discrepancy.search.evidence import (
    Candidate,
    Projected,
    Score,
    allowed,
    averaged,
    candidates,
    members,
    score,
    surprise,
    unit_values,
)
from model.effects import catalogue, effect
from model.identification.likelihood.mixed_model import weigh
from model.identification.likelihood.noise.row_covariance import Data
from tests.model.discrepancy.sessions import base_fit


class SmallRowIndex:
    """Three runs of four rows."""

    run_of, row_of = np.repeat(np.arange(3), 4), np.tile(np.arange(4), 3)

    def pad(self, flat):
        return flat.reshape(3, 4, *flat.shape[1:])


class SmallStudy:
    row_index = SmallRowIndex()


class SmallLinear:
    def __init__(self, data):
        self.data = data


def small(seed: int = 0):
    random = np.random.default_rng(seed)
    X, Z = random.standard_normal((3, 4, 2)), random.standard_normal((3, 4, 1))
    y = random.standard_normal((3, 4))
    data = Data(
        y=y,
        X=X,
        groups=[Z],
        masks=[np.ones((3, 4))],
        fixed=np.full((3, 4), 0.1),
        precision=np.full(2, 0.25),
        away=np.zeros(2),
    )
    return data, weigh(data, np.log([0.7, 0.6])), random.standard_normal((12, 3))


@pytest.mark.slow
def test_evidence_is_the_ratio_of_marginal_likelihoods():
    from scipy.stats import multivariate_normal  # slow to import

    data, solution, columns = small()
    X, Z, y = data.X.reshape(12, 2), data.groups[0][:, :, 0], data.y.ravel()
    V = np.diag(np.full(12, 0.1 + 0.36)) + X @ X.T / 0.25
    for r in range(3):
        own = slice(4 * r, 4 * r + 4)
        V[own, own] += 0.49 * np.outer(Z[r], Z[r])
    sizes = (0.1, 1.0, 3.0)
    with_it = [
        multivariate_normal(np.zeros(12), V + s**2 * columns @ columns.T).logpdf(y) for s in sizes
    ]
    wanted = np.logaddexp.reduce(with_it) - np.log(3) - multivariate_normal(None, V).logpdf(y)
    weighed = Projected.of(SmallStudy(), SmallLinear(data), solution)
    found = score(
        SmallStudy(), weighed, Candidate(name="it", values={}, columns=columns, sizes=sizes)
    )
    assert found.log_bayes == pytest.approx(wanted, rel=1e-9)
    best = int(np.argmax(with_it))
    assert found.scale == sizes[best]
    # the amplitude is the posterior mean of the first column's factor
    K = sizes[best] ** 2 * columns.T @ np.linalg.inv(V + sizes[best] ** 2 * columns @ columns.T)
    assert found.amplitude == pytest.approx((K @ y)[0], rel=1e-9)
    W = np.linalg.inv(V)
    assert found.length == pytest.approx(np.sqrt(columns[:, 0] @ W @ columns[:, 0]), rel=1e-9)


def test_what_is_in_the_data_scores_and_what_is_not_pays():
    data, _, columns = small(1)
    shown = replace(data, y=(10.0 * columns[:, 0]).reshape(3, 4))
    one = Candidate(name="it", values={}, columns=columns[:, :1], sizes=(1.0, 3.0, 10.0))
    gains = []
    for of in (shown, replace(data, y=np.zeros((3, 4)))):
        weighed = Projected.of(SmallStudy(), SmallLinear(of), weigh(of, np.log([0.7, 0.6])))
        gains.append(score(SmallStudy(), weighed, one).log_bayes)
    assert gains[0] > 10.0
    assert gains[1] < 0.0


def test_each_shape_of_an_effect_is_a_candidate_of_its_own():
    found = candidates(base_fit(), [effect("nonuniform_eibm"), effect("stiffness_drift")])
    for name in ("nonuniform_eibm", "stiffness_drift"):
        own = [c for c in found if c.name == name]
        assert [dict(c.values) for c in own] == members(effect(name))
        assert len({c.columns[:, 0].tobytes() for c in own}) == len(own)
    assert all(np.all(np.isfinite(c.columns)) for c in found)


def test_every_effect_of_the_catalogue_has_a_shape_to_try():
    for one in catalogue().values():
        for values in members(one):
            assert set(values) == {k.name for k in one.parameters}
            assert values[one.amplitude.name] != one.amplitude.neutral


def made(name: str, amplitude: float) -> Score:
    one = effect(name)
    values = members(one)[0]
    candidate = Candidate(
        name=name,
        values=values,
        columns=np.zeros((1, 1)),
        sizes=(1.0,),
        effect=one,
        location=one.location,
    )
    return Score(candidate=candidate, log_bayes=0.0, amplitude=amplitude, scale=1.0, length=1.0)


@pytest.mark.parametrize(
    ("name", "amplitude", "may_be"),
    [
        ("force_offset", -1.0, True),
        ("roll_friction", -1.0, False),  # no friction pushes
        ("roll_friction", 1.0, True),
        ("charging_lag", -1.0, False),  # found by trying time constants, all positive
        ("gravity", -1.0, True),
        ("nonuniform_stiffness", -24.0, True),  # beyond its bound, as strong effects lead to
        ("nonuniform_stiffness", -100.0, False),
    ],
)
def test_a_size_that_an_effect_cannot_have_is_not_allowed(name, amplitude, may_be):
    assert allowed(made(name, amplitude)) is may_be


def test_an_amplitude_is_a_value_in_the_units_of_the_effect():
    one = effect("force_offset")
    assert unit_values(one, {"force_mN": 0.1}, 2.5) == {"force_mN": pytest.approx(0.25)}
    ratio = effect("eibm_asymmetry")
    usual = (
        ratio.amplitude.prior_scale
        if ratio.amplitude.log
        else ratio.amplitude.neutral + ratio.amplitude.prior_scale
    )
    twice = unit_values(ratio, {"ratio": usual}, 2.0)["ratio"]
    assert abs(twice - ratio.amplitude.neutral) > abs(usual - ratio.amplitude.neutral)
    assert unit_values(ratio, {"ratio": usual}, 0.0)["ratio"] == pytest.approx(
        ratio.amplitude.neutral
    )


def test_shapes_that_nobody_knows_beforehand_share_their_evidence():
    assert averaged([3.0]) == pytest.approx(3.0)
    assert averaged([3.0, 3.0, 3.0]) == pytest.approx(3.0)  # it does not matter which it is
    assert averaged([9.0, -9.0, -9.0]) == pytest.approx(9.0 - np.log(3.0), abs=1e-6)


def test_first_pulses_that_exceed_the_others_are_a_surprise():
    columns = np.zeros((3, 1))
    transient = effect("first_pulse_transient")
    values = members(transient)[0]
    for amplitude, wanted in ((1.0, 0.0), (-1.0, -4.0)):
        one = Candidate(
            name=transient.name,
            values=values,
            columns=columns,
            sizes=(1.0,),
            effect=transient,
            location=transient.location,
        )
        assert (
            surprise(
                Score(candidate=one, log_bayes=0.0, amplitude=amplitude, scale=1.0, length=1.0)
            )
            == wanted
        )
    either = effect("initial_curvature")
    one = Candidate(
        name=either.name,
        values=members(either)[0],
        columns=columns,
        sizes=(1.0,),
        effect=either,
        location=either.location,
    )
    assert (
        surprise(Score(candidate=one, log_bayes=0.0, amplitude=-1.0, scale=1.0, length=1.0)) == 0.0
    )
