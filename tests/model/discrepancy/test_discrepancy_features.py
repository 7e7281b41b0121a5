"""Readings become means and trends, series parts of pulses, curves modes; each with its limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from model import Condition, Measurements, ModelError, Reading, TimeSeries
from model.discrepancy.prepare import DiagnoseOptions, prepare
from model.identification.data.data_vector import data_vector_of, trends
from model.identification.data.pulses import BINS_S, begin_from_rest, parts_of_pulses
from tests.model.discrepancy.sessions import (
    base_fit,
    fitted,
    means_of,
    session,
    without_first_pulses,
)


def forward():
    return base_fit().problem.forward


# ---------------------------------------------------------------------------- readings


def test_a_mean_and_three_trends_stand_for_the_readings_of_a_condition():
    seen = data_vector_of(session(), "long").seen[1]
    T = trends(seen.kept_clock)
    n = len(seen.kept_N)
    assert (n, len(seen.force_N)) == (10, 11)  # the first is discarded
    assert T.shape == (4, n)
    assert T[0] @ seen.kept_N == pytest.approx(np.mean(seen.kept_N))
    np.testing.assert_allclose(T[1:] @ T[1:].T, np.eye(3), atol=1e-12)  # as noisy as one reading
    np.testing.assert_allclose(T[1:] @ np.ones(n), 0.0, atol=1e-12)
    run_s = seen.kept_clock.run_s
    rising = T @ (run_s - np.mean(run_s))
    assert rising[1] > 0.0
    np.testing.assert_allclose(rising[[0, 2, 3]], 0.0, atol=1e-9)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_few_readings_have_fewer_trends(n: int):
    clock = data_vector_of(session(), "long").seen[1].clock
    few = clock.of(np.arange(len(clock.voltage_V)) < n)
    assert trends(few).shape == (n, n)


def test_readings_without_times_are_spaced_by_the_pulses():
    m = session()
    timed, plain = (data_vector_of(each, "long").seen[2].clock for each in (m, means_of(m)))
    np.testing.assert_allclose(plain.run_s, timed.run_s, atol=0.05)
    np.testing.assert_array_equal(plain.pulse, timed.pulse)
    assert np.ptp(plain.session) == 0.0  # when in the run's part of the session nobody knows
    assert np.ptp(timed.session) > 0.0


def test_without_times_of_the_session_runs_go_by_the_order_of_the_table():
    bare = means_of(session())
    every = [s for name in ("long", "short") for s in data_vector_of(bare, name).seen]
    shares = [float(s.clock.session[0]) for s in every]
    wanted = np.repeat((np.arange(14) + 0.5) / 14.0, 3)  # seven positions of each sheet
    np.testing.assert_allclose(shares, wanted)
    turned = replace(bare, conditions=bare.conditions[::-1])
    other = [float(s.clock.session[0]) for s in data_vector_of(turned, "long").seen]
    np.testing.assert_allclose(sorted(other), wanted[21:])  # the short sheet came first


@pytest.mark.parametrize("at_s", [200.0, 700.0])
def test_a_free_shape_counts_as_when_it_was_acquired(at_s: float):
    """Not as when the first position was: a drift would seem to have bent it otherwise."""
    m = session()
    held = next(c for c in m.conditions if c.voltage_V > 0.0)
    readings = [Reading(kind="no_contact", index=i, force_N=0.0) for i in range(3)]
    timed = tuple(replace(r, session_s=at_s + r.index) for r in readings)
    times = [r.session_s for c in m.conditions for r in c.readings if r.session_s is not None]
    share = (at_s + 1.0 - min(times)) / (max(times) - min(times))
    assert _free_at(m, held, timed) == pytest.approx(share)
    assert _free_at(m, held, tuple(readings)) < 0.01  # nobody knows: before the positions


def _free_at(m: Measurements, held: Condition, readings: tuple[Reading, ...]) -> float:
    """Return the part of the session at which the shape, now without the load cell, counts."""
    free = replace(held, position_m=None, readings=readings)
    every = data_vector_of(replace(m, conditions=(*m.conditions, free)), "long").seen
    (clock,) = (s.clock for s in every if s.free)
    return float(clock.session[0])


def test_pulses_are_counted_from_the_first_that_is_driven():
    every = {s.voltage_V: s for s in data_vector_of(session(), "long").seen[:3]}
    clocks = {volts: seen.kept_clock for volts, seen in every.items()}
    assert np.all(clocks[0.0].pulse == -1.0)
    both = np.sort(np.concatenate([clocks[2.0].pulse, clocks[-2.0].pulse]))
    np.testing.assert_array_equal(both, np.arange(2.0, 22.0))  # two are discarded
    firsts = [every[v].clock.of(~every[v].counts) for v in (2.0, -2.0)]
    assert [one.pulse.tolist() for one in firsts] == [[0.0], [1.0]]
    assert firsts[0].opposite.tolist() == [0.0]  # before the first there was 0 V
    up, down = clocks[2.0].opposite, clocks[-2.0].opposite
    np.testing.assert_allclose(up, -0.8, atol=0.08)  # before +2 V there was -2 V
    np.testing.assert_allclose(up * down, 1.0)


@pytest.mark.thorough
@pytest.mark.slow
def test_first_pulses_stand_for_themselves_and_are_in_no_mean():
    """Force and shape of each, less the mean of those that count."""
    m = session()
    both = [prepare(one, DiagnoseOptions()).problem.forward for one in (m, without_first_pulses(m))]
    for block, plain, data_vector in zip(
        *(s.row_index.blocks for s in both), both[0].data_vectors, strict=True
    ):
        assert (block.is_early.sum(), plain.is_early.sum()) == (14, 0)
        numbers = block.trend @ block.measured_N
        np.testing.assert_allclose(numbers[~block.is_early], plain.trend @ plain.measured_N)
        wanted = [s.force_N[0] - s.kept_N.mean() for s in data_vector.seen if s.voltage_V != 0.0]
        np.testing.assert_allclose(numbers[block.is_early], wanted)
        assert len(block.sway_rows) == len(plain.sway_rows) + 14


def test_a_first_pulse_without_a_curve_leaves_those_of_the_others():
    m = session()
    c = m.conditions[1]
    bare = tuple(replace(r, curve=None) if r.kind == "discarded" else r for r in c.readings)
    seen = data_vector_of(
        replace(m, conditions=(m.conditions[0], replace(c, readings=bare))), "long"
    ).seen[1]
    assert (len(seen.own_curves), len(seen.force_N)) == (10, 11)


@pytest.mark.parametrize("what", ["not valid", "later", "at 0 V"])
def test_what_is_no_first_pulse_is_not_taken_for_one(what: str):
    """Such as what is read while a sheet relaxes from a hold."""
    m = session()
    c = m.conditions[1]
    first, *others = c.readings
    assert first.kind == "discarded"
    if what == "not valid":
        c = replace(c, readings=(replace(first, valid=False), *others))
    elif what == "later":
        c = replace(c, readings=(*others, replace(first, index=99)))
    else:
        c = replace(c, voltage_V=0.0, readings=(first, *(replace(r, kind="zero") for r in others)))
    seen = data_vector_of(replace(m, conditions=(m.conditions[0], c)), "long").seen[1]
    assert np.all(seen.counts)
    assert len(seen.force_N) == 10


def test_identical_readings_are_one_reading():
    m = session()
    c = m.conditions[1]
    same = replace(c, readings=tuple(replace(r, force_N=1e-3) for r in c.readings))
    seen = data_vector_of(
        replace(m, conditions=(m.conditions[0], same, *m.conditions[2:])), "long"
    ).seen[1]
    assert seen.identical
    assert seen.force_N.tolist() == [1e-3]
    assert trends(seen.clock).tolist() == [[1.0]]


def test_readings_that_are_not_valid_do_not_count():
    m = session()
    c = m.conditions[1]
    bad = [replace(r, valid=False, force_N=9.0) if i == 3 else r for i, r in enumerate(c.readings)]
    odd = replace(m, conditions=(replace(c, readings=tuple(bad)), *m.conditions[2:]))
    assert np.max(data_vector_of(odd, "long").seen[0].force_N) < 1.0


def test_a_position_with_the_rig_turned_over_is_a_run_of_its_own():
    m = session()
    over = tuple(replace(c, tilt_rad=np.pi) for c in m.conditions)
    seen = data_vector_of(replace(m, conditions=(*m.conditions, *over)), "long").seen
    half = len(seen) // 2
    assert [s.tilt_rad for s in seen] == [0.0] * half + [np.pi] * half
    assert not {s.run for s in seen[:half]} & {s.run for s in seen[half:]}
    # its pulses are counted on their own
    np.testing.assert_array_equal(seen[1].clock.pulse, seen[half + 1].clock.pulse)


@pytest.mark.slow
def test_a_free_shape_has_a_curve_and_no_force(measure):
    made_here = measure(names=("long",), free=True)
    every = data_vector_of(made_here, "long").seen
    seen = [s for s in every if s.free]
    assert len(seen) == 3
    assert all(s.curve is not None and len(s.force_N) == 0 for s in seen)
    first = min(s.clock.session[0] for s in every if not s.free)
    assert all(s.clock.session[0] == first for s in seen)
    one = prepare(made_here, DiagnoseOptions()).problem.forward
    block, configuration_model = one.row_block(0), one.configuration_models[0]
    assert np.all(block.mode_rows[configuration_model.free] >= 0)
    assert not np.isin(block.trend_of, configuration_model.free).any()


def test_free_shapes_are_as_old_as_their_sheet_s_first_position(measure):
    made_here = measure(names=("long", "short"), free=True)
    after_s = {"long": 100.0, "short": 900.0}
    later = [
        replace(c, readings=tuple(
            replace(r, session_s=after_s[c.configuration] + 10.0 * r.index) for r in c.readings
        ))
        for c in made_here.conditions
    ]  # fmt: skip
    made_here = replace(made_here, conditions=tuple(later))
    last_s = max(r.session_s for c in later for r in c.used())
    for name, share in (("long", 0.0), ("short", 800.0 / (last_s - 100.0))):
        clocks = [s.clock for s in data_vector_of(made_here, name).seen if s.free]
        assert [float(clock.session[0]) for clock in clocks] == pytest.approx([share] * 3)
        assert all(clock.pulse[0] > 2.0 for clock in clocks if clock.voltage_V[0])  # not the first


def alone(m: Measurements, values_mN: Sequence[float], **condition: object) -> Measurements:
    """With readings of the load cell without contact."""
    readings = tuple(
        Reading(index=i, kind="no_contact", force_N=1e-3 * v, time_s=0.6 * i, session_s=0.6 * i)
        for i, v in enumerate(values_mN)
    )
    added = replace(
        Condition(configuration="long", position_m=None, voltage_V=0.0, readings=readings, run=5),
        **condition,
    )
    return replace(m, conditions=(*m.conditions, added))


@pytest.mark.slow
def test_without_contact_the_load_cell_shows_its_zero():
    m = session()
    found = alone(m, [0.01, 0.02, 0.03])
    plain, seen = (data_vector_of(one, "long").seen for one in (m, found))
    assert len(seen) == len(plain) + 1
    zero = seen[-1]
    assert zero.zero
    assert zero.free
    np.testing.assert_allclose(zero.force_N, [1e-5, 2e-5, 3e-5])
    problem = prepare(found, DiagnoseOptions()).problem
    block = problem.forward.row_block(0)
    configuration_model = problem.forward.configuration_models[0]
    k = len(seen) - 1
    assert k not in configuration_model.free  # it is no shape
    fit = fitted(found)
    row = block.trend_rows[(block.trend_of == k) & block.is_mean]
    assert fit.linear.residual[row] == pytest.approx(2e-5)  # no force is expected


@pytest.mark.parametrize(
    ("values_mN", "condition"), [
        ([0.0, 0.0, 0.0], {}), ([0.01], {}), ([], {}), ([0.01, 0.02], {"voltage_V": 2.0}),
    ],
)  # fmt: skip
def test_what_is_no_zero_of_the_load_cell_is_left_out(values_mN, condition):
    m = session()
    assert len(data_vector_of(alone(m, values_mN, **condition), "long").seen) == len(
        data_vector_of(m, "long").seen
    )


def test_a_zero_taken_at_a_position_belongs_to_the_run_there():
    m = session()
    c = m.conditions[0]
    more = tuple(Reading(index=40 + i, kind="no_contact", force_N=1e-5 * i) for i in range(3))
    with_zero = replace(m, conditions=(replace(c, readings=c.readings + more), *m.conditions[1:]))
    plain, seen = (data_vector_of(one, "long").seen for one in (m, with_zero))
    assert [s.zero for s in seen] == [False] * len(plain) + [True]
    assert seen[-1].run == seen[0].run
    np.testing.assert_array_equal(seen[0].force_N, plain[0].force_N)


def test_a_sheet_that_is_not_wetted_again_goes_on_drying():
    """What is under voltage counts from the last wetting, not from the run's first pulse."""
    m = session()
    second = next(c for c in m.conditions if c.configuration == "long" and c.position_m == 0.005)
    wet_s = min(r.session_s - r.wetted_s for c in m.conditions for r in c.readings)
    once = replace(m, conditions=tuple(
        replace(c, readings=tuple(replace(r, wetted_s=r.session_s - wet_s) for r in c.readings))
        for c in m.conditions
    ))  # fmt: skip
    usual, dry = (
        next(
            s
            for s in data_vector_of(one, "long").seen
            if s.run[1] == second.position_m and s.voltage_V > 0
        )
        for one in (m, once)
    )
    np.testing.assert_allclose(usual.clock.driven_s, 0.6 * usual.clock.pulse)
    np.testing.assert_allclose(dry.clock.driven_s, 22 * 0.6 + 0.6 * dry.clock.pulse)


def test_a_position_approached_from_above_is_a_run_of_its_own():
    m = session()
    again = [replace(c, approach="down") for c in m.conditions if c.position_m == 0.01]
    both = data_vector_of(replace(m, conditions=(*m.conditions, *again)), "long")
    assert {s.run[3] for s in both.seen if s.up < 0.0} == {1}
    assert {s.run[3] for s in both.seen if s.up > 0.0} == {0}


def test_four_runs_at_a_place_of_which_two_are_from_above_stay_four():
    m = session()
    (lowest, *_) = [c for c in m.conditions if c.position_m == 0.01 and c.voltage_V == 0.0]
    four = [
        replace(lowest, run=run, approach=approach)
        for run in (0, 1) for approach in ("up", "down")
    ]  # fmt: skip
    only = [c for c in m.conditions if c.position_m != 0.01]
    seen = data_vector_of(replace(m, conditions=(*only, *four)), "long").seen
    assert len({one.run for one in seen if one.position_m == 0.01}) == 4


# ------------------------------------------------------------------------------ series


def test_a_series_belongs_to_its_run_alone():
    m = session()
    second = [replace(c, run=1, approach="down") for c in m.conditions if c.position_m == 0.01]
    series = [replace(s, run=1) for s in m.series if s.position_m == 0.01]
    twice = replace(m, conditions=(*m.conditions, *second), series=(*m.series, *series))
    pulses = [p for p in data_vector_of(twice, "long").pulses if p.run[1] == 0.01]
    assert sorted(p.run[3] for p in pulses) == [0, 0, 1, 1]


BOTH_V = (2.0, -2.0)


def made(seconds: float = 7.0, rate: float = 100.0, lag_s: float = 0.03) -> TimeSeries:
    """Ten zero seconds' worth of pulses of alternating sign, the force following with a lag."""
    t = np.arange(0.0, seconds, 1.0 / rate) + 0.5 / rate
    k = np.floor(t / 0.6).astype(int)
    drive = np.where(k % 2 == 0, 2.0, -2.0)
    left = np.exp(-(t - 0.6 * k) / lag_s)
    force = 1e-3 * drive * (1.0 - 2.0 * left)
    return TimeSeries(
        configuration="long", position_m=0.005, time_s=t, drive_V=drive, force_N=force
    )


def test_parts_of_a_pulse_are_means_less_that_about_the_sample():
    parts = parts_of_pulses(made(rate=5000.0), BOTH_V)
    assert set(parts) == set(BOTH_V)
    a, b = BINS_S[:-1], BINS_S[1:]
    mean = 0.03 * (np.exp(-a / 0.03) - np.exp(-b / 0.03)) / (b - a)
    mean -= 0.03 * (np.exp(-0.4 / 0.03) - np.exp(-0.6 / 0.03)) / 0.2
    np.testing.assert_allclose(parts[2.0][0], -4e-3 * mean, atol=1.5e-7)
    np.testing.assert_allclose(parts[-2.0][0], 4e-3 * mean, atol=1.5e-7)


def test_the_first_two_pulses_and_the_one_cut_short_are_left_out():
    parts = parts_of_pulses(made(7.0), BOTH_V)  # eleven pulses and 0.4 s of the twelfth
    assert [len(parts[volts]) for volts in BOTH_V] == [5, 4]


def test_a_gap_in_a_series_costs_its_pulse_alone():
    series = made()
    force = series.force_N.copy()
    force[(series.time_s > 1.5) & (series.time_s < 1.55)] = np.nan
    parts = parts_of_pulses(replace(series, force_N=force), BOTH_V)
    assert [len(parts[volts]) for volts in BOTH_V] == [4, 4]


def test_pulses_of_another_voltage_are_not_averaged_with_them():
    series = made(14.0)
    k = np.floor(series.time_s / 0.6).astype(int)
    half = k % 4 > 1  # +2, -2, +1, -1 V and so on, read back 3 % too large
    less = np.where(half, 0.5, 1.0)
    several = replace(series, drive_V=1.03 * less * series.drive_V, force_N=less * series.force_N)
    asked_V = (2.0, -2.0, 1.0, -1.0)
    parts = parts_of_pulses(several, asked_V)
    found = {volts: len(each) for volts, each in parts.items()}
    assert found == {2.0: 5, -2.0: 5, 1.0: 6, -1.0: 5}
    np.testing.assert_allclose(parts[1.0].mean(axis=0), 0.5 * parts[2.0].mean(axis=0), rtol=1e-9)
    assert set(parts_of_pulses(several, BOTH_V)) == set(BOTH_V)
    assert len(parts_of_pulses(several, BOTH_V)[2.0]) == 5  # those of 1 V are of no condition


def test_pulses_with_rests_between_them_begin_from_rest():
    series = made(14.0)
    k = np.floor(series.time_s / 0.6).astype(int)
    rested = replace(series, drive_V=np.where(k % 2, 0.01, np.where(k % 4, -2.0, 2.0)))
    stairs = replace(series, drive_V=2.0 * np.round(np.sin(0.5 * k), 1))  # through 0 V, too
    alone = replace(series, drive_V=np.where(k == 3, 2.0, 0.0))
    none = made(0.0)  # without a sample
    found = [begin_from_rest(one) for one in (rested, series, stairs, alone, none)]
    assert found == [True, False, False, False, False]
    m = session()
    resting = [
        replace(rested, configuration=s.configuration, position_m=s.position_m) for s in m.series
    ]
    seen = data_vector_of(replace(m, series=tuple(resting)), "long").seen
    assert {x for one in seen if one.voltage_V for x in one.clock.opposite.tolist()} == {0.0}


@pytest.mark.parametrize("seconds", [0.1, 0.3, 0.5, 0.9])
def test_a_series_shorter_than_its_pulses_says_nothing(seconds: float):
    assert parts_of_pulses(made(seconds), BOTH_V) == {}


def test_a_series_without_force_says_nothing_and_one_without_clock_is_refused():
    series = made()
    assert parts_of_pulses(replace(series, force_N=None), BOTH_V) == {}
    broken = replace(series, time_s=np.where(series.time_s > 3.0, np.nan, series.time_s))
    with pytest.raises(ModelError, match="the series of long holds a number that is not finite"):
        parts_of_pulses(broken, BOTH_V)


# -------------------------------------------------------------------------------- rows


def test_every_row_stands_once_and_in_the_run_it_comes_from():
    one = forward()
    row_index = one.row_index
    every = np.concatenate(
        [
            np.concatenate([p.trend_rows, p.mode_rows[p.mode_rows >= 0], p.sway_rows, p.bin_rows])
            for p in row_index.blocks
        ]
    )
    np.testing.assert_array_equal(np.sort(every), np.arange(row_index.size))
    for block, seen in zip(row_index.blocks, one.data_vectors, strict=True):
        own = [row_index.runs[r] for r in row_index.run_of[block.trend_rows]]
        assert own == [seen.seen[k].run for k in block.trend_of]
    flat = np.random.default_rng(0).standard_normal((row_index.size, 2))
    padded = row_index.pad(flat)
    np.testing.assert_array_equal(padded[row_index.run_of, row_index.row_of], flat)
    assert np.count_nonzero(padded) == flat.size


@pytest.mark.slow
def test_means_alone_have_neither_sways_nor_pulses():
    block = prepare(means_of(session()), DiagnoseOptions()).problem.forward.row_block(0)
    timed = forward().row_block(0)
    assert (len(block.sway_rows), len(block.bin_rows)) == (0, 0)
    assert len(timed.sway_rows) > 0 < len(timed.bin_rows)
    assert block.is_mean.sum() == timed.is_mean.sum() == 21


def test_readings_are_ordered_by_when_they_were_taken():
    block = forward().row_block(0)
    session_, run_s = block.clock.session[block.in_time], block.clock.run_s[block.in_time]
    assert np.all(np.diff(np.round(session_, 9)) >= 0.0)
    at = [forward().data_vectors[0].seen[k].position_m for k in block.reading_of[block.in_time]]
    same = np.diff(at) == 0.0
    assert np.all(np.diff(run_s)[same] > 0.0)


def test_curves_of_readings_that_the_mean_does_not_match_are_not_compared():
    """They could not be told apart point by point."""
    m = session()
    c = m.conditions[1]
    coarse = replace(c.curve, **{k: getattr(c.curve, k)[::2] for k in ("s_m", "x_m", "y_m")},
                     sigma_m=None)  # fmt: skip
    odd = replace(m, conditions=(m.conditions[0], replace(c, curve=coarse), *m.conditions[2:]))
    assert data_vector_of(m, "long").seen[1].own_curves
    assert not data_vector_of(odd, "long").seen[1].own_curves
