"""The benchmark of the intervals: its sessions are those of its truth, and a run can go on."""

from __future__ import annotations

import json

import numpy as np
import pytest

from benchmarks.dynamic_coverage.__main__ import collect
from benchmarks.dynamic_coverage.drawn import drawn_session
from benchmarks.dynamic_coverage.measured import measured
from benchmarks.dynamic_coverage.score import summary
from model.dynamics.identification.predicted_run import FINE
from model.dynamics.identification.residuals import RunResiduals

WITH_ALL = 2  # a seed that draws a position with current and a release


@pytest.mark.slow
def test_the_world_without_noise_is_what_the_model_says_of_the_truth():
    session = drawn_session(WITH_ALL, links=160)
    for run in measured(session, noisy=False):
        of = RunResiduals(run.plan, session.noise, FINE)
        off = of.whitened([(of.predict(session.truth), run)])
        assert np.sqrt(np.mean(off**2)) < 0.15  # of the noise: what two discretisations leave


def test_a_session_is_the_same_for_the_same_seed():
    one, other = (measured(drawn_session(WITH_ALL, links=16)) for _ in range(2))
    assert np.array_equal(one[0].force_N, other[0].force_N)
    assert np.array_equal(one[1].y_m, other[1].y_m)


def parameter(value, determined):
    return {
        "truth": 1.0, "value": value, "low": value / 1.1, "high": value * 1.1, "log_sigma": 0.06,
        "prior_share": 0.1, "determined": determined, "true_log_sigma": 0.06,
        "true_prior_share": 0.1, "determinable": True,
    }  # fmt: skip


def row(seed, value, determined=True):
    return {
        "seed": seed, "kind": "both", "identify_s": 1.0, "converged": True, "chi2": 9.0,
        "count": 10, "parameters": {"B": parameter(value, determined)},
    }  # fmt: skip


def test_a_run_goes_on_with_the_sessions_that_are_not_yet_written_down(tmp_path):
    path = tmp_path / "rows.jsonl"
    lines = [json.dumps(row(7, 1.0)), json.dumps(row(8, 1.5)), '{"seed": 9, "kin']
    path.write_text("\n".join(lines) + "\n")
    assert [r["seed"] for r in collect(path, range(7, 9), workers=1, links=16)] == [7, 8]


def test_only_stated_intervals_are_counted():
    table = summary([row(1, 1.05), row(2, 1.5), row(3, 1.5, determined=False)]).tables[0]
    assert table.rows[0][:2] == ("B", "2")
    assert table.rows[0][2].startswith("50.0")
