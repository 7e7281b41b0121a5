"""Sessions without pixels and volts, but with their course in time."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from sim_hardware.world import (
    CurveErrors,
    Scatter,
    TimedRun,
    Train,
    Visit,
    WorldSettings,
    load_world,
    reduced_session,
    timed_session,
)

SHORT = Train(zero_readings=3, kept=2)
EXACT = CurveErrors(0.0, 0.0)


def world(**changes: Any) -> WorldSettings:
    """The shipped world without scatter, noise and offsets; keys have __ for dots."""
    content = load_world().model_dump()
    quiet = {f"scatter__{key}": 0.0 for key in content["scatter"]}
    quiet |= {f"load_cell__{key}": 0.0 for key in ("noise_mN", "drift_mN", "hum_mN", "offset_uV")}
    quiet["amplifier__offset_mV"] = 0.0
    for path, value in (quiet | changes).items():
        *tables, key = path.split("__")
        table = content
        for part in tables:
            table = table[part]
        table[key] = value
    return WorldSettings.model_validate(content)


def one(settings: WorldSettings, visit: Visit, train: Train = SHORT, **options: Any) -> TimedRun:
    return timed_session(settings, [visit], train=train, **options)[0]


def forces_mN(run: TimedRun, volts: float) -> np.ndarray:
    return np.array([r.force_N * 1e3 for r in run.readings if r.voltage_V == volts])


def test_a_run_holds_its_readings_in_order_with_curves_and_series() -> None:
    run = one(load_world(), Visit(configuration="short", position_m=0.01), series_hz=100.0)
    assert [r.index for r in run.readings] == list(range(9))
    assert [r.kind for r in run.readings] == ["zero"] * 3 + ["discarded"] * 2 + ["kept"] * 4
    assert [r.voltage_V for r in run.readings] == [0, 0, 0, 2, -2, 2, -2, 2, -2]
    assert [r.time_s for r in run.readings] == pytest.approx(0.5 + 0.6 * np.arange(9))
    assert run.start_s == run.wet_s == SHORT.wet_s
    assert run.time_s.size == run.drive_V.size == run.force_N.size == 540
    assert set(run.curves_m) == {0.0, 2.0, -2.0}
    assert all(r.curve_m.shape == (run.s_m.size, 2) for r in run.readings)
    # the drive's edges are where they were planned
    assert np.interp([1.79, 1.81, 2.39, 2.41], run.time_s, run.drive_V) == pytest.approx(
        [0.01, 2.01, 2.01, -1.99],
        abs=0.02,  # with the amplifier's offset
    )


def test_it_agrees_with_the_session_in_which_everything_is_settled() -> None:
    settings = world(
        water__first_pulse_deficit=0.0, water__stiffening_per_min=0.0,
        water__weakening_per_min=0.0, eibm__build_up_s=1e-3, load_cell__hysteresis_mN=0.0,
    )  # fmt: skip
    run = one(settings, Visit(configuration="long", position_m=0.005), errors=EXACT)
    settled = reduced_session(settings, 1, ("long",), (0.005,), curve_errors=EXACT)
    for c in settled.conditions:
        assert forces_mN(run, c.voltage_V)[-1] == pytest.approx(c.forces_N[0] * 1e3, abs=1e-4)
        assert np.allclose(run.curves_m[c.voltage_V][:, 1], c.y_m, atol=3e-8)


def test_its_noise_is_that_of_the_cell_and_readings_are_made_of_the_series() -> None:
    settings = world(load_cell__noise_mN=0.1, load_cell__hum_mN=0.0)
    train = Train(zero_readings=40, kept=1)
    run = one(settings, Visit(configuration="long", position_m=0.0), train, series_hz=200.0)
    still = (run.time_s > 0.1) & (run.time_s < 23.9)
    assert np.std(run.force_N[still]) * 1e3 == pytest.approx(0.1 / np.sqrt(5), rel=0.05)
    zeros = forces_mN(run, 0.0)
    # a window of 0.2 s with weights that fall to 0 holds 2/3 of its 200 samples
    assert np.std(zeros) == pytest.approx(0.1 / np.sqrt(200 * 2 / 3), rel=0.35)
    near = np.abs(run.time_s - 0.5) < 0.1
    weights = 1 + np.cos(np.pi * (run.time_s[near] - 0.5) / 0.1)
    assert zeros[0] == pytest.approx(np.average(run.force_N[near], weights=weights) * 1e3)


@pytest.mark.slow
def test_the_same_seed_gives_the_same_session() -> None:
    visits = [
        Visit(configuration="short", position_m=0.0),
        Visit(configuration="short", position_m=None),
    ]
    first, again = (timed_session(load_world(seed=4), visits, train=SHORT) for _ in range(2))
    other = timed_session(load_world(seed=5), visits, train=SHORT)
    for a, b, c in zip(first, again, other, strict=True):
        assert np.array_equal(a.force_N, b.force_N)
        assert np.array_equal(a.readings[0].curve_m, b.readings[0].curve_m)
        assert not np.array_equal(a.readings[0].curve_m, c.readings[0].curve_m)


def test_what_the_image_shows_late_is_the_pulse_before() -> None:
    now, late = (
        one(world(frame_delay_s=s), Visit(configuration="short", position_m=None), errors=EXACT)
        for s in (0.0, 0.6)
    )
    tip = [run.curves_m[2.0][-1, 1] for run in (now, late)]
    before = now.curves_m[-2.0][-1, 1]
    assert abs(tip[1] - before) < 0.2 * abs(tip[0] - before)


def test_a_set_up_gone_wrong_is_as_it_was_said_to_be() -> None:
    odd = Scatter(eibm=0.5, position_m=1e-3)
    run = one(world(), Visit(configuration="short", position_m=0.004, odd=odd))
    moved = one(world(), Visit(configuration="short", position_m=0.005))
    assert forces_mN(run, 0.0)[0] == pytest.approx(forces_mN(moved, 0.0)[0], abs=0.01)
    swing = [np.ptp([forces_mN(r, 2.0)[-1], forces_mN(r, -2.0)[-1]]) for r in (run, moved)]
    assert swing[0] == pytest.approx(swing[1] / 2, rel=0.01)


def test_a_load_cell_with_hysteresis_knows_from_which_side_it_came() -> None:
    settings = world(load_cell__hysteresis_mN=0.05, load_cell__hysteresis_reach_mN=0.05)
    at_mN = [
        forces_mN(
            one(settings, Visit(configuration="short", position_m=0.015, approach=side)), 0.0
        )[0]
        for side in ("up", "down")
    ]
    # The force falls with the position: from below the cell has been let go, and shows too much.
    assert at_mN[0] - at_mN[1] == pytest.approx(0.1, abs=1e-3)


def test_a_series_has_whole_blocks_of_samples() -> None:
    with pytest.raises(ValueError, match="series_hz = 150 must divide 200"):
        timed_session(world(), [], series_hz=150.0)


def test_a_position_that_cannot_be_held_is_left_out() -> None:
    runs = timed_session(
        world(),
        [Visit(configuration="long", position_m=0.06), Visit(configuration="long", position_m=0.0)],
        train=SHORT,
    )
    assert [run.visit.position_m for run in runs] == [0.0]
    assert runs[0].start_s == SHORT.run_s + SHORT.wet_s
