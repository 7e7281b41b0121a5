"""Stated intervals against a world that shares no code with the model."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.interval_coverage import FEW, measurements, tally
from model import FitOptions
from model.identification.joint import joint_fit
from model.identification.likelihood.noise.row_noise import scatter_precision
from model.identification.observations import observe
from sim_hardware.world import load_world
from sim_hardware.world.reduced import reduced_session


@pytest.mark.thorough
def test_stated_intervals_cover_the_world_s_truth_and_are_narrow():
    """A small edition of `benchmarks.interval_coverage.py`, which states the figures."""
    found = tally(load_world(None), range(900, 912))
    assert len(found.inside) == 12
    share = float(np.mean(found.inside))
    assert share > 0.75  # 72 intervals of 90 %, twelve of them independent
    assert np.max(found.width) < 0.15


@pytest.mark.slow
def test_intervals_of_few_set_ups_hold_the_truth_as_often():
    found = tally(load_world(None), range(997000, 997040), FEW["three positions, +2 V alone"])
    assert found.names == ["long B", "long EIBM +2 V"]
    assert np.all(np.mean(found.inside, axis=0) > 0.8)  # of 40


def test_the_noises_of_a_curve_s_modes_are_unsure_together():
    """Curves may be ten times as noisy as assumed, and then all their modes are."""
    world = load_world(None)
    session = reduced_session(
        world, seed=1, configurations=("long",), positions_m=(0.0, 0.02), voltages=(2.0,)
    )
    data = measurements(session, world)
    noise = joint_fit(data, [observe(data, "long")], FitOptions()).fitted.problem.noise
    covariance = np.linalg.inv(scatter_precision(noise))
    modes = [
        len(noise.random_effects) + i for i, name in enumerate(noise.names) if " mode " in name
    ]
    one, other = modes[:2]
    together = covariance[one, one]
    apart = together + covariance[other, other] - 2.0 * covariance[one, other]
    assert np.sqrt(together) > 2.0  # of ln sigma
    assert np.sqrt(apart) < 1.1
    force = len(noise.random_effects) + noise.names.index("long force")
    assert covariance[one, force] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.thorough
def test_noisier_set_ups_give_wider_intervals():
    world = load_world(None)
    rough = world.scatter.model_copy(update={"eibm": 0.05, "stiffness": 0.05})
    wide, narrow = (
        tally(w, range(3)) for w in (world.model_copy(update={"scatter": rough}), world)
    )
    assert np.mean(wide.width) > 2.0 * np.mean(narrow.width)


def test_a_reduced_session_becomes_measurements():
    world = load_world(None)
    session = reduced_session(world, seed=1, configurations=("short",), positions_m=(0.0, 0.02))
    found = measurements(session, world)
    assert len(found.conditions) == 6
    assert found.conditions[0].used()[0].kind == "zero"
    assert found.sheets["short"].initial_curvature is not None
