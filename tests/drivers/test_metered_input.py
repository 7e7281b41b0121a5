"""A board's inputs with a meter in the place of the force: which force each sample has."""

from __future__ import annotations

import numpy as np
import pytest

from drivers.force_sensors.metered_input import INTERVAL_S, SILENT_S, MeteredInput
from drivers.interfaces import (
    DeviceError,
    DeviceTimeoutError,
    OverloadError,
    SampleClock,
    SignalBlock,
)
from sim_hardware.clock import VirtualClock

RATE_HZ = 1000.0
EXCHANGE_S = 0.02


class Board:
    """Two channels whose volts are the sample's index and its negative."""

    channels = ("current", "drive")
    ranges_V = (0.5, 5.0)
    rate_hz = RATE_HZ

    def __init__(self, clock) -> None:
        self.clock, self.is_open, self.start_s, self.sent = clock, False, None, 0
        self.skip = 0  # samples that never come

    def open(self) -> None:
        self.is_open = True

    def start(self) -> SampleClock:
        self.start_s, self.sent = self.clock.now(), 0
        return SampleClock(self.start_s, 1e-4, RATE_HZ)

    def read_available(self) -> SignalBlock:
        end = round((self.clock.now() - self.start_s) * RATE_HZ)
        first, self.sent = self.sent + self.skip, end
        self.skip = 0
        index = np.arange(first, end, dtype=float)
        return SignalBlock(first, np.stack([index, -index]), self.clock.now())

    def measure(self, duration_s: float) -> np.ndarray:
        self.clock.sleep_until(self.clock.now() + duration_s)
        return np.zeros((2, round(duration_s * RATE_HZ)))

    def stop(self) -> None:
        self.start_s = None

    def close(self) -> None:
        self.is_open = False


class Meter:
    """Reads a force that rises by 1 mN a second; an exchange takes its time."""

    range_N = 0.98

    def __init__(self, clock) -> None:
        self.clock, self.is_open = clock, False
        self.fault: DeviceError | None = None
        self.spoilt = 0  # exchanges to come that fail
        self.hangs_s = 0.0  # how long an exchange lasts beside its time

    def open(self) -> None:
        if self.fault:
            raise self.fault
        self.is_open = True

    def read_force(self) -> float:
        self.clock.sleep_until(self.clock.now() + self.hangs_s)
        self.clock.sleep_until(self.clock.now() + EXCHANGE_S / 2)
        force_N = 1e-3 * self.clock.now()
        self.clock.sleep_until(self.clock.now() + EXCHANGE_S / 2)
        if self.spoilt:
            self.spoilt -= 1
            raise DeviceError("garbage came where a reading was expected")
        if self.fault:
            raise self.fault
        return force_N

    def tare(self) -> None: ...

    def close(self) -> None:
        self.is_open = False


class Bench:
    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.board, self.meter = Board(self.clock), Meter(self.clock)
        self.signals = MeteredInput(self.board, self.meter, self.clock, "scale")

    def wait(self, seconds: float) -> None:
        self.clock.sleep_until(self.clock.now() + seconds)


@pytest.fixture
def bench():
    made = Bench()
    made.signals.open()
    made.wait(0.3)
    yield made
    made.signals.close()


def test_the_force_comes_first_and_its_range_is_the_meters(bench):
    assert bench.signals.channels == ("force", "current", "drive")
    assert bench.signals.ranges_V == (0.98, 0.5, 5.0)


def test_each_sample_has_the_force_of_its_own_time(bench):
    sample_clock = bench.signals.start()
    indices, forces = [], []
    for _ in range(30):
        bench.wait(0.031)
        block = bench.signals.read_available()
        count = block.volts.shape[1]
        assert block.volts[1].tolist() == list(range(block.first_index, block.first_index + count))
        indices += block.volts[1].tolist()
        forces += block.volts[0].tolist()
    assert indices == list(range(len(indices)))  # all of them, once each
    times = sample_clock.start_s + np.array(indices) / RATE_HZ
    assert forces == pytest.approx((1e-3 * times).tolist(), abs=1e-12)
    assert len(indices) > RATE_HZ * (30 * 0.031 - 2 * INTERVAL_S)


def test_samples_that_never_came_are_nan_and_the_others_keep_their_force(bench):
    sample_clock = bench.signals.start()
    bench.wait(0.1)
    first = bench.signals.read_available().volts
    bench.board.skip = 50
    bench.wait(0.5)
    volts = np.concatenate([first, bench.signals.read_available().volts], axis=1)
    lost = np.isnan(volts[1])
    assert lost.sum() == 50
    times = sample_clock.start_s + np.arange(volts.shape[1]) / RATE_HZ
    assert volts[0] == pytest.approx(1e-3 * times, abs=1e-12)
    assert volts[1][~lost] == pytest.approx(np.arange(volts.shape[1])[~lost])


def test_one_spoilt_reading_is_bridged(bench):
    bench.signals.start()
    bench.meter.spoilt = 2
    bench.wait(0.5)
    assert np.isfinite(bench.signals.read_available().volts).all()


def test_a_meter_that_falls_silent_ends_the_acquisition_with_its_reason(bench):
    bench.signals.start()
    bench.meter.spoilt = 1000
    bench.wait(SILENT_S + 0.2)
    said = r"the force meter 'scale' has given no reading for 1\.\d s: garbage came"
    with pytest.raises(DeviceTimeoutError, match=said):
        bench.signals.read_available()


def test_a_meter_whose_call_does_not_end_is_named(bench):
    bench.signals.start()
    bench.meter.hangs_s = 3.0
    bench.wait(SILENT_S + 0.2)
    said = r"^the force meter 'scale' has given no reading for 1\.\d s: it does not answer$"
    with pytest.raises(DeviceTimeoutError, match=said):
        bench.signals.read_available()


@pytest.mark.parametrize("fault", [RuntimeError("no line"), SystemExit("no line")])
def test_a_meter_that_breaks_its_contract_is_the_cause_of_the_silence(bench, fault):
    bench.signals.start()
    bench.meter.fault = fault
    bench.wait(SILENT_S + 0.2)
    kind = type(fault).__name__
    with pytest.raises(DeviceTimeoutError, match=f"unexpected {kind}: no line") as told:
        bench.signals.read_available()
    assert told.value.__cause__.__cause__ is fault


@pytest.mark.parametrize("returned", [None, "1.25", np.array([1e-3]), True])
def test_a_meter_that_returns_no_number_has_given_no_reading(bench, returned):
    bench.signals.start()
    bench.meter.read_force = lambda: returned
    bench.wait(SILENT_S + 0.2)
    with pytest.raises(DeviceTimeoutError, match=r"its read_force returned .*, not a force in N"):
        bench.signals.read_available()


@pytest.mark.parametrize("returned", [np.float32(0.25), np.array(0.25)])
def test_a_reading_may_be_any_real_number(bench, returned):
    bench.signals.start()
    bench.meter.read_force = lambda: returned
    bench.wait(0.3)
    assert bench.signals.read_available().volts[0][-1] == 0.25


@pytest.mark.parametrize("range_N", [None, float("nan"), 0.0, "2"])
def test_a_meter_without_a_range_is_named_and_everything_is_let_go(range_N):
    bench = Bench()
    bench.meter.range_N = range_N
    with pytest.raises(DeviceError, match="the force meter 'scale' states the range"):
        bench.signals.open()
    assert not bench.board.is_open
    assert not bench.meter.is_open


def test_an_overload_is_raised_at_the_next_read(bench):
    bench.signals.start()
    bench.meter.fault = OverloadError("unload the cell")
    bench.wait(0.1)
    with pytest.raises(OverloadError, match="unload the cell"):
        bench.signals.read_available()


def test_a_measurement_waits_for_the_reading_after_it(bench):
    began_s = bench.clock.now()
    volts = bench.signals.measure(0.2)
    times = began_s + np.arange(200) / RATE_HZ
    assert volts.shape == (3, 200)
    assert volts[0] == pytest.approx(1e-3 * times, abs=1e-12)


def test_it_says_how_often_the_meter_reads(bench):
    assert bench.signals.interval_s() == pytest.approx(INTERVAL_S)


def test_it_says_when_the_values_came_that_make_the_force_of_some_samples(bench):
    bench.signals.start()
    began_s = bench.clock.now()
    bench.meter.spoilt = 4
    bench.wait(0.5)
    times = bench.signals.force_times_s(began_s + 0.05, began_s + 0.25)
    assert times[0] <= began_s + 0.05 < times[1]
    assert times[-2] < began_s + 0.25 <= times[-1]
    assert np.diff(times).max() == pytest.approx(5 * INTERVAL_S)


def test_how_often_a_silent_meter_reads_is_told_as_its_silence():
    bench = Bench()
    bench.meter.spoilt = 1000
    bench.signals.open()
    with pytest.raises(DeviceTimeoutError, match="has given no reading for 1"):
        bench.signals.interval_s()
    bench.signals.close()


def test_the_board_can_be_read_whatever_becomes_of_the_meter(bench):
    bench.meter.spoilt = 10**6
    bench.wait(2.0)
    assert bench.signals.board.measure(0.02).shape == (2, 20)
    with pytest.raises(DeviceError):
        bench.signals.measure(0.02)


def test_a_meter_that_cannot_be_opened_leaves_the_board_closed():
    bench = Bench()
    bench.meter.fault = DeviceTimeoutError("the meter did not answer")
    with pytest.raises(DeviceTimeoutError, match="did not answer"):
        bench.signals.open()
    assert not bench.board.is_open


def test_everything_is_let_go_at_the_end_and_can_be_opened_again(bench):
    bench.signals.close()
    assert (bench.board.is_open, bench.meter.is_open) == (False, False)
    bench.signals.close()
    bench.signals.open()
    bench.wait(0.2)
    bench.signals.start()
    bench.wait(0.2)
    assert bench.signals.read_available().volts.shape[1] > 0


def test_an_overload_from_before_it_was_closed_is_not_raised_again(bench):
    bench.meter.fault = OverloadError("unload the cell")
    bench.wait(0.1)
    bench.signals.close()
    bench.meter.fault = None
    bench.signals.open()
    bench.signals.start()
    bench.signals.read_available()


def test_a_read_looks_at_no_more_readings_than_its_samples_need(bench):
    bench.signals.start()
    bench.wait(10.0)
    bench.signals.read_available()
    bench.wait(0.1)
    looked = []

    class Counted(type(bench.signals._readings)):
        def __iter__(self):
            looked.extend(range(len(self)))
            return super().__iter__()

        def __reversed__(self):
            for each in super().__reversed__():
                looked.append(each)
                yield each

    bench.signals._readings = Counted(bench.signals._readings)
    looked.clear()
    assert np.isfinite(bench.signals.read_available().volts).all()
    assert 0 < len(looked) < 10
