"""Every way out: 0 V written, read back, every device tried, every failure told, nothing raised."""

import itertools

import numpy as np
import pytest

from drivers.interfaces import DeviceError, LimitError, SampleClock, SignalBlock, VoltageWrite
from drivers.safe_shutdown import DEVICE_S, PATIENCE_S, Safety, SafetyReport, make_safe
from sim_hardware.clock import VirtualClock


class Sheet:
    """An output and a read-back on the same wire; the k-th call fails."""

    def __init__(self, fails=(), falls_in_s: float = 0.0, fault=DeviceError):
        self.volts = 2.0
        self.fails = set(fails)
        self.fault = fault
        self.calls: list[str] = []
        self.falls_in_s = falls_in_s  # the amplifier needs so long to come down
        self.since_zero_s = 0.0

    def call(self, name: str) -> None:
        self.calls.append(name)
        if len(self.calls) - 1 in self.fails:
            raise self.fault(f"{name} failed")


class Output:
    limit_V = 2.5

    def __init__(self, sheet: Sheet, is_open: bool = True):
        self.sheet, self.is_open = sheet, is_open

    def open(self) -> None:
        self.sheet.call("open output")
        self.is_open = True

    def write(self, sheet_V: float) -> VoltageWrite:
        self.sheet.call(f"write {sheet_V:g}")
        if not self.is_open:
            raise DeviceError("the output is not open")
        if abs(sheet_V) > self.limit_V:
            raise LimitError("limit")
        self.sheet.volts = sheet_V
        return VoltageWrite(sheet_V, sheet_V / 10, 0.0, 0.0)

    def close(self) -> None:
        self.sheet.call("close output")


class Signals:
    channels = ("force", "current", "drive")
    ranges_V = (0.05, 0.5, 5.0)

    def __init__(self, sheet: Sheet):
        self.sheet = sheet

    def open(self) -> None:
        self.sheet.call("open input")

    def start(self) -> SampleClock:
        raise AssertionError("not used")

    def read_available(self) -> SignalBlock:
        raise AssertionError("not used")

    def stop(self) -> None:
        self.sheet.call("stop input")

    def measure(self, duration_s: float) -> np.ndarray:
        self.sheet.call("measure")
        self.sheet.since_zero_s += duration_s
        left = 2.0 if self.sheet.since_zero_s <= self.sheet.falls_in_s else self.sheet.volts
        return np.vstack([np.zeros(20), np.zeros(20), np.full(20, left)])

    def close(self) -> None:
        self.sheet.call("close input")


def safe(sheet: Sheet, **kwargs):
    return make_safe(Output(sheet, **kwargs), Signals(sheet), VirtualClock(), "drive", 0.05)


def test_zero_is_written_first_and_read_back():
    sheet = Sheet()
    report = safe(sheet)
    assert report.state is Safety.SAFE
    assert report.read_back_V == 0.0
    assert report.failures == ()
    assert sheet.calls == ["write 0", "stop input", "open input", "measure"]
    assert report.text == "the output is safe: 0 V written and read back as 0.000 V"


def test_an_output_that_is_not_open_is_opened():
    sheet = Sheet()
    assert safe(sheet, is_open=False).state is Safety.SAFE
    assert sheet.calls[:3] == ["write 0", "open output", "write 0"]


def test_a_voltage_that_falls_slowly_is_waited_for():
    report = safe(Sheet(falls_in_s=0.1))
    assert report.state is Safety.SAFE


def test_a_voltage_that_stays_is_unknown_and_says_what_to_do():
    report = safe(Sheet(falls_in_s=1e9))
    assert report.state is Safety.UNKNOWN
    assert report.read_back_V == 2.0
    assert "reads 2.000 V" in report.text
    assert "switch the amplifier off by hand" in report.text


@pytest.mark.parametrize("fault", [DeviceError, RuntimeError, OSError])
@pytest.mark.parametrize(
    "failing",
    [
        (),
        *itertools.combinations(range(7), 1),
        *itertools.combinations(range(7), 2),
        tuple(range(50)),
    ],
)
def test_whatever_fails_nothing_is_raised_and_safe_means_safe(fault, failing):
    sheet = Sheet(fails=failing, fault=fault)
    report = safe(sheet)
    if report.state is Safety.SAFE:
        assert sheet.volts == 0.0
    assert any(call.startswith("write 0") for call in sheet.calls)
    assert "stop input" in sheet.calls  # the input has its turn, whatever the output did
    happened = [sheet.calls[k] for k in failing if k < len(sheet.calls)]
    assert len(report.failures) >= len(set(happened))
    assert all(any(f"{name} failed" in told for told in report.failures) for name in happened)


def test_a_failure_that_was_overcome_leaves_the_output_safe():
    report = safe(Sheet(fails=[1]))  # stopping the input
    assert report.state is Safety.SAFE
    assert report.failures == ("stop input failed",)
    assert "(but stop input failed)" in report.text


def test_a_read_back_of_nothing_is_not_safe():
    sheet = Sheet()

    class NoNumber(Signals):
        def measure(self, duration_s: float) -> np.ndarray:
            return np.full((3, 20), np.nan)

    report = make_safe(Output(sheet), NoNumber(sheet), VirtualClock(), "drive", 0.05)
    assert report.state is Safety.UNKNOWN


def test_a_missing_drive_channel_is_unknown():
    sheet = Sheet()
    assert (
        make_safe(Output(sheet), Signals(sheet), VirtualClock(), "sheet", 0.05).state
        is Safety.UNKNOWN
    )


@pytest.mark.parametrize("device", ["output", "input"])
def test_a_device_that_does_not_answer_does_not_keep_the_other_from_its_turn(device):
    clock, sheet = VirtualClock(), Sheet()

    class HungOutput(Output):
        def write(self, sheet_V: float) -> VoltageWrite:
            clock.sleep_until(clock.now() + 1e6)
            raise AssertionError("nobody waits for so long")

    class HungSignals(Signals):
        def stop(self) -> None:
            clock.sleep_until(clock.now() + 1e6)

    output = HungOutput(sheet) if device == "output" else Output(sheet)
    signals = HungSignals(sheet) if device == "input" else Signals(sheet)
    report = make_safe(output, signals, clock, "drive", 0.05)
    assert report.state is Safety.UNKNOWN
    assert f"has not come to an end in {DEVICE_S:g} s" in report.text
    assert clock.now() == pytest.approx(DEVICE_S, abs=0.5)
    assert ("measure" in sheet.calls) is (device == "output")
    assert ("write 0" in sheet.calls) is (device == "input")


def test_a_device_that_fails_for_a_moment_is_tried_again():
    clock, sheet = VirtualClock(), Sheet()

    class Late(Output):
        def write(self, sheet_V: float) -> VoltageWrite:
            if clock.now() < 0.8 * PATIENCE_S:
                raise DeviceError("the network is gone")
            return super().write(sheet_V)

    report = make_safe(Late(sheet), Signals(sheet), clock, "drive", 0.05)
    assert report.is_safe
    assert report.failures == ("the network is gone",)  # told once, however often it was tried


def test_one_cause_of_many_failures_is_told_once_after_all_that_it_kept_from_being_done():
    failures = (
        "writing 0 V to PCI6703/ao0 failed: no connection to x:1",
        "it is closed",
        "stopping the inputs failed: no connection to x:1",
        "reading failed: it broke; the rest failed: too",
    )
    assert SafetyReport(Safety.UNKNOWN, None, failures).text == (
        "THE OUTPUT IS NOT KNOWN TO BE SAFE (not read back): switch the amplifier off by hand; "
        "writing 0 V to PCI6703/ao0, stopping the inputs failed: no connection to x:1; "
        "it is closed; reading failed: it broke; the rest failed: too"
    )
