"""What the default world's sessions look like: order, signs, free positions, B and EIBM."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

from labrig.analysis import analyze
from model import Measurements, fit
from tests.end_to_end.small_rig import make_rig, run_rig

pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]
FREE_POSITION_M = {"long": 15e-3, "short": 5e-3}  # where the undriven sheet rests, in the paper
E_PA = {"long": 150e6, "short": 100e6}  # of the default world
THICKNESS_M, WIDTH_M = 0.21e-3, 11e-3


@pytest.fixture(
    scope="module", params=[1, *(pytest.param(s, marks=pytest.mark.thorough) for s in (2, 3))]
)
def measured(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = make_rig(tmp_path_factory.mktemp("seed") / "rig", world=f"seed = {request.param}\n")
    path = run_rig(folder)
    analyze(path)
    return path


@pytest.fixture(scope="module")
def measurements(measured: Path) -> Measurements:
    from labrig.session import load_measurements

    return load_measurements(measured)


def forces(measurements: Measurements, configuration: str) -> dict[float, dict[float, float]]:
    """Mean force by position and voltage, N."""
    found: dict[float, dict[float, float]] = {}
    for c in measurements.conditions:
        if c.configuration == configuration and c.position_m is not None:
            mean = float(np.mean([reading.force_N for reading in c.used()]))
            found.setdefault(c.position_m, {})[c.voltage_V] = mean
    return found


@pytest.mark.parametrize("configuration", ["long", "short"])
def test_forces_have_the_papers_order_and_signs(
    measurements: Measurements, configuration: str
) -> None:
    by_position = forces(measurements, configuration)
    assert len(by_position) == 4
    for by_voltage in by_position.values():
        assert by_voltage[2.0] > by_voltage[0.0] > by_voltage[-2.0]
        assert all(abs(force) < 6e-3 for force in by_voltage.values())
    for voltage_V in (2.0, 0.0, -2.0):
        along = [by_position[position][voltage_V] for position in sorted(by_position)]
        assert all(b < a for a, b in itertools.pairwise(along))


@pytest.mark.parametrize("configuration", ["long", "short"])
def test_the_undriven_sheet_rests_where_the_paper_says(
    measurements: Measurements, configuration: str
) -> None:
    by_position = forces(measurements, configuration)
    positions = sorted(by_position)
    undriven = [by_position[position][0.0] for position in positions]
    free_m = np.interp(0.0, undriven[::-1], positions[::-1])
    assert free_m == pytest.approx(FREE_POSITION_M[configuration], abs=1e-3)


def test_every_condition_has_a_curve_that_bends_more_at_more_voltage(
    measurements: Measurements,
) -> None:
    by_place: dict[tuple[str, float], dict[float, float]] = {}
    for c in measurements.conditions:
        assert c.curve is not None
        assert c.position_m is not None
        near = c.curve.s_m < 4e-3
        assert c.curve.curvature_per_m is not None
        root = float(np.mean(c.curve.curvature_per_m[near]))
        by_place.setdefault((c.configuration, c.position_m), {})[c.voltage_V] = root
    # At a held tip a larger bending moment at the root bends the root more.
    assert all(k[2.0] > k[0.0] > k[-2.0] for (name, _), k in by_place.items() if name == "long")


def test_the_fit_finds_the_worlds_stiffness(measurements: Measurements) -> None:
    found = fit(measurements).to_json()["configurations"]
    for configuration, truth_Pa in E_PA.items():
        truth = truth_Pa * WIDTH_M * THICKNESS_M**3 / 12
        B = found[configuration]["B_Nm2"]
        low, high = B["interval90"]
        assert high - low < 0.15 * B["value"]
        # Four positions whose stiffness scatters by 1 % each.
        assert B["value"] == pytest.approx(truth, rel=0.03)
