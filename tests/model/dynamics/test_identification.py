"""Parameters from recorded motions: recovered, with intervals that say what the data know."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model import ModelError
from model.dynamics import ContactSetup, ElectrodeLine, HeldVoltage, Resolution
from model.dynamics.identification import (
    ChannelNoise,
    RecordedRun,
    RecordingNoise,
    RunPlan,
    identify,
    information,
)
from model.dynamics.identification.noise import Whitening
from model.dynamics.identification.parameters import LogParameters
from model.dynamics.identification.predicted_run import predict
from model.dynamics.identification.thresholds import MOST_PRIOR
from model.dynamics.identification.uncertainty import judged, surely
from model.dynamics.load_cell import LoadCellFilter
from tests.cases import few
from tests.model.dynamics.cases import AIR, L, R, driven

SHEET = driven(fluid=AIR)
COARSE = Resolution(step_s=2e-3, degrees=(6, 2), free_degrees=6, line_terms=6)
NOISE = RecordingNoise(
    force=ChannelNoise(white=1e-4), current=ChannelNoise(white=5e-5), curve_m=3e-5
)
PUSH = RunPlan(
    drive=HeldVoltage(np.array([0.1, 0.4]), np.array([2.0, -2.0])),
    time_s=np.arange(0.0, 0.8, 2e-3), setup=ContactSetup(radius_m=R, position_m=0.0),
)  # fmt: skip
RELEASE = RunPlan(
    drive=HeldVoltage(np.array([0.1, 0.5]), np.array([2.0, 0.0])),
    time_s=np.arange(0.0, 1.2, 2e-3), force=False, frame_s=np.arange(0.0, 1.2, 0.04),
    points_m=np.array([0.5 * L, L]),
)  # fmt: skip


def recorded(plan, sheet=SHEET):
    """What the model says, as if it were measured without noise."""
    said = predict(sheet, plan, COARSE)
    return RecordedRun(
        plan=plan, force_N=said.force_N if plan.force else None,
        current_A=said.current_A if plan.current else None,
        x_m=said.x_m if len(plan.frame_s) else None, y_m=said.y_m if len(plan.frame_s) else None,
    )  # fmt: skip


def sigmas(noise, *plans):
    """Standard deviation of the logarithm of each parameter."""
    return {p.name: p.log_sigma for p in information(SHEET, plans, noise, COARSE)}


def begun(seed, off=0.1):
    """Starting values each about 10 % off."""
    parameters = LogParameters(SHEET)
    away = off * np.random.default_rng(seed).standard_normal(len(parameters.theta))
    return parameters.beam(parameters.theta + away)


@pytest.fixture(scope="module")
def found():
    data = [recorded(PUSH), recorded(RELEASE)]
    data[1].x_m[3, 1] = np.nan  # a point that the camera did not see
    return identify(begun(3), data, NOISE, resolution=COARSE, tolerance=1e-3)


@pytest.mark.slow  # some hundred runs of the model
def test_parameters_are_recovered_from_data_without_noise(found):
    assert found.converged
    assert found.chi2 < 1e-2 * found.count
    truth = LogParameters(SHEET)
    for p, value in zip(found.parameters, np.exp(truth.theta), strict=True):
        off = abs(np.log(p.parameter.value / value))
        assert off < 0.1 * p.log_sigma + 1e-4, p.name


@pytest.mark.thorough
def test_a_start_with_a_wrong_frequency_and_loss_still_leads_to_the_answer():
    """A period of the ring-down counted wrongly, or explained by loss, would be another minimum."""
    parameters = LogParameters(SHEET)
    off = {"B": 0.25, "mass_per_length": -0.25, "viscous_time": -1.0, "share_1": 0.7, "time_1": 0.7}
    away = np.array([off.get(q.name, 0.3) for q in parameters.quantities])
    data = [recorded(PUSH), recorded(RELEASE)]
    found = identify(parameters.beam(parameters.theta + away), data, NOISE, resolution=COARSE)
    assert found.converged
    # the truth costs what the priors say against it, and nothing else: the answer costs no more
    assert found.chi2 < float(away**2 @ parameters.precision)
    for p, value in zip(found.parameters, np.exp(parameters.theta), strict=True):
        if p.determined:  # the priors, which are as far off, may pull by a part of a deviation
            assert abs(np.log(p.parameter.value / value)) < p.log_sigma, p.name


# electrodes of which another line, longer or shorter, explains the first instants
LINES = {
    "much longer": (2364.0, 0.182, 0.801, 0.17), "half as long": (7644.0, 0.263, 0.332, 0.036)
}  # fmt: skip
RESOLVED = replace(COARSE, line_terms=12)
CURRENT = RunPlan(
    drive=HeldVoltage(np.array([0.1, 0.5, 0.9, 1.2]), np.array([1.8, -1.8, 1.8, 0.0])),
    time_s=np.arange(0.0, 1.5, 2e-3), force=False,
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("length", few(LINES))
def test_electrodes_of_another_line_that_explains_the_first_instants_are_not_settled_for(length):
    """A line so many times as long, r, c, g as many times less and rho more, begins the same."""
    line = LINES[length]
    names = ("electrode_ohm_per_m", "capacitance_F_per_m", "bulk_ohm_m", "leak_S_per_m")
    electrodes = ElectrodeLine(source_ohm=1.0, **dict(zip(names, line, strict=True)))
    said = predict(replace(SHEET, electrodes=electrodes), CURRENT, RESOLVED).current_A
    noisy = said + 5e-5 * np.random.default_rng(0).standard_normal(len(said))
    run = RecordedRun(plan=CURRENT, current_A=noisy)
    found = identify(SHEET, [run], NOISE, resolution=RESOLVED)
    assert found.converged
    assert found.chi2 / found.count == pytest.approx(1.0, abs=0.15)
    assert found["electrode_resistance"].parameter.value == pytest.approx(line[0], rel=0.05)


@pytest.mark.slow
def test_what_the_release_shows_is_determined(found):
    assert {"B", "mass_per_length", "share_2", "time_2", "capacitance"}.isdisjoint(
        found.undetermined
    )
    assert "90 % interval" in found["B"].text()


@pytest.mark.slow
def test_a_sheet_held_by_the_rolls_says_little_of_its_loss():
    told = {p.name: p for p in information(SHEET, [PUSH], NOISE, COARSE)}
    for name in ("mass_per_length", "share_1", "time_1", "share_2", "time_2"):
        assert not told[name].determined
        assert "these data do not determine it" in told[name].text()
    assert told["time_2"].prior_share > 0.9
    assert told["time_2"].log_sigma == pytest.approx(1.0, abs=0.1)  # as before the data
    for name in ("B", "electrode_resistance", "capacitance", "bulk_resistance"):
        assert told[name].determined


def test_without_the_current_the_electrodes_are_not_determined():
    told = {p.name: p for p in information(SHEET, [replace(PUSH, current=False)], NOISE, COARSE)}
    assert not told["electrode_resistance"].determined
    assert not told["capacitance"].determined


def test_free_shapes_alone_tell_ratios_to_the_stiffness_only():
    """Nothing but a force tells how stiff a sheet is whose mass and moments are not known."""
    found = information(driven(), [RELEASE], NOISE, COARSE)
    told = {p.name: p for p in found}
    assert not told["B"].determined
    assert not told["mass_per_length"].determined


@pytest.mark.slow
@pytest.mark.parametrize(
    "more", few([{"zero": 1e-3}, {"drift_per_sqrt_s": 1e-3}, {"hum": 1e-2}]), ids=str
)
def test_drift_and_hum_widen_the_intervals(more):
    white = sigmas(NOISE, PUSH)
    wider = sigmas(replace(NOISE, force=replace(NOISE.force, **more)), PUSH)
    for name, sigma in wider.items():
        assert sigma > white[name] * (1.0 - 1e-6), name
    # the hum is far from all that the sheet does
    assert wider["B"] > white["B"] * (1.0 + 1e-4 if "hum" in more else 1.1)


def test_determined_is_what_is_so_at_the_ends_of_uncertain_intervals_too():
    parameters = LogParameters(SHEET)
    names = [one.name for one in parameters.quantities]
    share, time = names.index("share_1"), names.index("time_1")
    theta = parameters.theta

    def at(where, guard=1.0):
        """A share known to 30 %; its time is told by the share's square."""
        told = np.full(len(names), 1e4)
        told[share] = 10.0
        told[time] = 6.0 * np.exp(2.0 * (where[share] - theta[share]))
        return judged(parameters, where, np.diag(told), guard=guard)

    found, covariance = at(theta)
    assert all(one.determined for one in found)
    sure = surely(found, covariance, theta, theta, lambda where: at(where)[0])
    assert [one.name for one in sure if not one.determined] == ["time_1"]
    assert sure[time].log_sigma > found[time].log_sigma  # its interval is the wider one
    assert sure[time].parameter.interval()[1] > found[time].parameter.interval()[1]
    # the guard keeps away from the limits themselves
    assert found[time].prior_share > 0.5 * MOST_PRIOR
    assert not at(theta, guard=0.5)[0][time].determined


def test_a_viscous_loss_found_too_small_to_be_seen_hides_nothing_of_the_others():
    """Its logarithm has no effect then, so that the first Prony term seems to be known alone."""
    parameters = LogParameters(SHEET)
    names = [one.name for one in parameters.quantities]
    eta, time = names.index("viscous_time"), names.index("time_1")
    begun = parameters.theta
    theta = begun - 3.0 * (np.arange(len(names)) == eta)

    def at(where):
        """Data tell the time, beside as much of the loss as there is."""
        told = 1e4 * np.eye(len(names))
        seen = np.zeros(len(names))
        seen[time], seen[eta] = 1.0, np.exp(where[eta] - begun[eta])
        told[eta] = told[:, eta] = told[time] = told[:, time] = 0.0
        return judged(parameters, where, told + 100.0 * np.outer(seen, seen))

    found, covariance = at(theta)
    assert found[time].determined
    assert not found[eta].determined
    sure = surely(found, covariance, theta, begun, lambda where: at(where)[0])
    assert [one.name for one in sure if not one.determined] == ["viscous_time", "time_1"]


@pytest.mark.thorough
@pytest.mark.slow
def test_worse_residuals_than_the_noise_explains_widen_the_intervals():
    quiet = replace(NOISE, current=replace(NOISE.current, white=2.5e-5))
    data = recorded(replace(PUSH, force=False, setup=None, time_s=PUSH.time_s[::2]))
    random = np.random.default_rng(1)
    noisy = replace(data, current_A=data.current_A + 5e-5 * random.standard_normal(200))
    one, other = (identify(SHEET, [noisy], n, resolution=COARSE) for n in (NOISE, quiet))
    assert one.chi2 / one.count == pytest.approx(1.0, abs=0.2)
    assert other.chi2 / other.count == pytest.approx(4.0, abs=0.8)
    assert other.misses_data
    assert not one.misses_data
    for p, q in zip(one.parameters, other.parameters, strict=True):
        assert q.log_sigma == pytest.approx(p.log_sigma, rel=0.15), p.name


@pytest.mark.slow
def test_a_load_cell_follows_in_long_runs_of_equal_steps_as_step_by_step():
    steps_s = np.concatenate([np.full(80, 1e-3), [3e-4, 7e-4], np.full(60, 5e-4)])
    force = np.random.default_rng(2).standard_normal(len(steps_s) + 1)
    setup = ContactSetup(radius_m=R, position_m=0.0, resonance_hz=90.0, damping=0.05)
    whole, piecewise = LoadCellFilter(setup), LoadCellFilter(setup)
    alone = [piecewise.follow(h[None], force[n : n + 2])[1] for n, h in enumerate(steps_s)]
    assert whole.follow(steps_s, force)[1:] == pytest.approx(alone, rel=1e-9, abs=1e-12)


def test_whitening_is_that_of_the_whole_covariance():
    t = np.array([0.0, 0.001, 0.003, 0.1, 0.4, 0.41])
    noise = ChannelNoise(white=0.3, zero=0.5, drift_per_sqrt_s=2.0, hum=0.7)
    turn = 2.0 * np.pi * 50.0 * t
    knots = 1.0 - t / t[-1], t / t[-1]
    hum = sum(np.outer(k, k) for k in knots) * np.cos(turn[:, None] - turn)
    C = 0.3**2 * np.eye(6) + 0.5**2 + 2.0**2 * np.minimum(t[:, None], t) + 0.7**2 * hum
    r = np.random.default_rng(0).standard_normal((6, 2))
    white = Whitening(noise, t, 50.0)(r)
    assert white.T @ white == pytest.approx(r.T @ np.linalg.solve(C, r), rel=1e-10)


GONE = np.full(len(PUSH.time_s), np.nan)
OTHER = replace(recorded(replace(PUSH, force=False, setup=None)), plan=replace(
    PUSH, force=False, setup=None, configuration="short"
))  # fmt: skip
BAD = {
    "no recorded run": lambda: identify(SHEET, [], NOISE),
    "no run whose information": lambda: information(SHEET, [], NOISE),
    "one configuration": lambda: identify(
        SHEET, [replace(OTHER, plan=replace(OTHER.plan, configuration="long")), OTHER], NOISE
    ),
    "no force where the load cell is away": lambda: replace(RELEASE, force=True),
    "nothing is measured": lambda: replace(PUSH, force=False, current=False),
    "frames need points": lambda: replace(RELEASE, points_m=np.zeros(0)),
    "must be finite and ascend": lambda: replace(PUSH, time_s=PUSH.time_s[::-1]),
    "begin before the run": lambda: replace(PUSH, time_s=PUSH.time_s - 1.0),
    "force is missing": lambda: RecordedRun(plan=PUSH, current_A=np.zeros(400)),
    "force is not part of the run": lambda: replace(OTHER, force_N=np.zeros(400)),
    "current has": lambda: replace(OTHER, current_A=np.zeros(3)),
    "current must be finite": lambda: replace(OTHER, current_A=GONE),
    "away from the voltage edges": lambda: information(
        SHEET, [PUSH], replace(NOISE, edge_s=1.0), COARSE
    ),
    "white noise of a channel must be positive": lambda: ChannelNoise(white=0.0),
    "zero, drift and hum": lambda: ChannelNoise(white=1.0, hum=-1.0),
    "deviation of the curves must be positive": lambda: replace(NOISE, curve_m=0.0),
    "mains' frequency": lambda: replace(NOISE, mains_hz=0.0),
    "electrodes must be described": lambda: information(
        replace(SHEET, electrodes=None), [PUSH], NOISE
    ),
    "slips out of the rolls": lambda: information(
        SHEET, [replace(PUSH, setup=ContactSetup(
            radius_m=R, position_m=lambda t: 0.02 + 0.1 * t))], NOISE, COARSE,
    ),
}  # fmt: skip


@pytest.mark.parametrize("sentence", list(BAD))
def test_bad_input_is_refused_in_a_sentence(sentence):
    with pytest.raises(ModelError, match=sentence) as caught:
        BAD[sentence]()
    assert "\n" not in str(caught.value)
