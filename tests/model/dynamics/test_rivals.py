"""Where two places explain the data as well as each other, both are said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model.dynamics import ElectrodeLine, HeldVoltage, Resolution
from model.dynamics.identification import ChannelNoise, RecordedRun, RecordingNoise, RunPlan
from model.dynamics.identification.electrode_lines import other_electrodes
from model.dynamics.identification.parameters import LogParameters
from model.dynamics.identification.predicted_run import predict
from model.dynamics.identification.rivals import best_and_rivals, covering_both
from model.dynamics.identification.search import Derivatives, SearchPoint, SearchProblem, search
from model.dynamics.identification.uncertainty import judged
from tests.model.dynamics.cases import driven

SHEET = driven()
PARAMETERS = LogParameters(SHEET)
LINE = PARAMETERS.length_of_line
SIGMA = 0.01


class TwoValleys(SearchProblem):
    """Data that tell each logarithm to `SIGMA`, but not which of two places it is."""

    count = 100

    def __init__(self, apart: float, dearer: float) -> None:
        """`dearer`: what the second place costs more."""
        self.parameters, self.runs = PARAMETERS, []
        self.places = [PARAMETERS.theta, PARAMETERS.theta + apart * LINE]
        moved = apart * LINE
        self._left = [90.0, 90.0 + dearer - float(moved @ (PARAMETERS.precision * moved))]

    def point(self, theta):
        towards = [place - theta for place in self.places]
        near = int(np.argmin([one @ one for one in towards]))
        residuals = np.append(towards[near] / SIGMA, np.sqrt(self._left[near]))
        chi2, moved = float(residuals @ residuals), theta - PARAMETERS.theta
        cost = chi2 + float(moved @ (PARAMETERS.precision * moved))
        return SearchPoint(theta, [residuals], chi2, cost)

    def derivatives(self, theta, *, exact=False):
        rows = np.vstack([np.eye(len(theta)) / SIGMA, np.zeros(len(theta))])
        return Derivatives(theta, [rows], exact, theta)


def told(apart, dearer):
    """Identify as `identify` does: names of what is not determined, the parameters, the end."""
    problem = TwoValleys(apart, dearer)
    first = search(problem, PARAMETERS.theta + 0.1, 0.02, finish=True)
    best, rivals = best_and_rivals(problem, first, [problem.places[1] - 0.02 * LINE], 0.02)
    told = [
        judged(PARAMETERS, end.at.theta, end.information(problem))[0] for end in (best, *rivals)
    ]
    found = told[0]
    for rival in told[1:]:
        found = covering_both(found, rival)
    return found, best


def test_another_place_as_good_is_not_determined_and_named():
    found, _ = told(apart=np.log(16.0), dearer=1.0)
    of = {one.name: one for one in found}
    names = {"electrode_resistance", "capacitance", "bulk_resistance", "leak"}
    assert {one.name for one in found if not one.determined} == names
    other = 16.0 * SHEET.electrodes.capacitance_F_per_m
    assert of["capacitance"].other_value == pytest.approx(other, rel=0.05)
    assert (
        f"{of['capacitance'].other_value:.3g} F/m explains them as well" in of["capacitance"].text()
    )
    assert of["B"].log_sigma == pytest.approx(SIGMA, rel=0.01)  # it is the same at both


def test_a_near_place_as_good_widens_the_interval_over_both():
    found, _ = told(apart=0.1, dearer=1.0)
    capacitance = {one.name: one for one in found}["capacitance"]
    value = SHEET.electrodes.capacitance_F_per_m
    low, high = capacitance.parameter.interval()
    assert low < value
    assert high > value * np.exp(0.1 + 1.6 * SIGMA)  # the end of the other's own interval
    assert capacitance.determined


def test_a_worse_place_changes_nothing():
    found, _ = told(apart=np.log(16.0), dearer=6.0)
    assert all(one.determined and one.other_value is None for one in found)


def test_a_better_place_is_gone_on_from():
    found, best = told(apart=np.log(16.0), dearer=-6.0)
    assert best.at.theta == pytest.approx(PARAMETERS.theta + np.log(16.0) * LINE, abs=1e-3)
    assert all(one.determined for one in found)


@pytest.mark.slow
def test_from_a_false_line_the_current_leads_to_the_true_one():
    """One sixteen times longer, of too few polynomials, explains the current nearly as well."""
    line = ElectrodeLine(
        electrode_ohm_per_m=4166.0, capacitance_F_per_m=0.561, bulk_ohm_m=0.42, leak_S_per_m=0.0596,
        source_ohm=1.0,
    )  # fmt: skip
    true = replace(SHEET, electrodes=line)
    plan = RunPlan(
        drive=HeldVoltage(np.array([0.1, 0.5, 0.9, 1.2]), np.array([1.8, -1.8, 1.8, 0.0])),
        time_s=np.arange(0.0, 1.5, 4e-3), force=False,
    )  # fmt: skip
    by = Resolution(line_terms=12)
    said = predict(true, plan, by).current_A
    run = RecordedRun(
        plan=plan, current_A=said + 5e-5 * np.random.default_rng(0).standard_normal(len(said))
    )
    noise = RecordingNoise(
        force=ChannelNoise(white=1e-4), current=ChannelNoise(white=5e-5), curve_m=3e-5
    )
    theta = LogParameters(true).theta
    ends = list(other_electrodes(PARAMETERS, [run], noise, by, theta + np.log(16.0) * LINE))
    assert min(np.max(np.abs(end - theta)[LINE != 0.0]) for end in ends) < 0.1
