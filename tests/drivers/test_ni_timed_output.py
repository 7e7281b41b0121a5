"""An output that its board puts out by the clock of its inputs, and what ends it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from drivers.amplifier import Amplifier, SheetDrive
from drivers.boards.conformance import timed_output_faults
from drivers.boards.ni.analog_input import InputChannel
from drivers.boards.ni.connection import NiConnection
from drivers.boards.ni.rescue import OutputPlace, shut_down
from drivers.interfaces import DeviceError, LimitError, TimedVoltage
from drivers.safe_shutdown import NOT_READ, Safety, make_safe
from sim_hardware.clock import VirtualClock
from sim_hardware.ni import LoopbackWires, NiDeviceServer
from tests.drivers.conftest import NiRig

RATE_HZ = 1000.0
START = "/M/ai/StartTrigger"
PULSES = (
    TimedVoltage(0, 0.0),
    TimedVoltage(200, 0.2),
    TimedVoltage(800, -0.2),
    TimedVoltage(1400, 0.0),
)
PLACE = OutputPlace(
    address="simulated",
    output_channel="M/ao0",
    drive_channel="M/ai2",
    limit_board_V=0.25,
    drive_range_V=1.0,
)


@pytest.fixture
def rig() -> Iterator[NiRig]:
    """A USB-6211 whose output is wired to the read-back."""
    clock = VirtualClock()
    wires = LoopbackWires({"ao0": "ai2"})
    server = NiDeviceServer(wires, clock, {"M": "USB-6211"}, clock_error_ppm=100.0)
    inputs = (InputChannel("force", "M/ai0", 0.2), InputChannel("drive", "M/ai2", 1.0))
    connection = NiConnection("simulated", server.in_process_channel())
    connection.open()
    rig = NiRig(connection, clock, server, "M/ao0", inputs)
    rig.wires = wires
    yield rig
    rig.end()


def volts(rig: NiRig) -> float:
    """What is on the wire now, apart from the boards."""
    import numpy as np

    return float(rig.wires.read("M", "ai2", np.array([rig.clock.now()]))[0])


def loaded(rig: NiRig):
    output, signals = rig.output(trigger=START), rig.signals(RATE_HZ)
    output.open()
    signals.open()
    output.load(PULSES, RATE_HZ)
    return output, signals


@pytest.mark.slow
def test_it_keeps_its_contract(rig: NiRig) -> None:
    output, signals = rig.output(trigger=START), rig.signals(RATE_HZ)
    output.open()
    signals.open()
    assert timed_output_faults(output, signals, 0.25, rig.clock) == []


def test_each_edge_is_the_sample_that_was_asked_for(rig: NiRig) -> None:
    output, signals = loaded(rig)
    rig.wait(0.5)
    assert volts(rig) == 0.0  # it waits for the inputs
    signals.start()
    rig.wait(1.6)
    drive = signals.read_available().volts[1]
    assert output.is_done()
    for edge, before in zip(PULSES[1:], PULSES, strict=False):
        assert drive[edge.index - 1] == pytest.approx(before.volts, abs=2e-3)
        assert drive[edge.index] == pytest.approx(edge.volts, abs=2e-3)


def test_it_ends_at_zero_without_anybody_and_is_not_put_out_again(rig: NiRig) -> None:
    """The inputs have failed, and nobody lives who would write 0 V."""
    _, signals = loaded(rig)
    signals.start()
    rig.wait(0.5)
    assert volts(rig) == pytest.approx(0.2, abs=1e-3)
    signals.stop()
    rig.wait(1.5)
    assert volts(rig) == pytest.approx(0.0, abs=1e-3)
    for _ in range(40):
        rig.wait(0.1)
        assert volts(rig) == pytest.approx(0.0, abs=1e-3)


def test_a_write_ends_it_at_once(rig: NiRig) -> None:
    output, signals = loaded(rig)
    signals.start()
    rig.wait(0.5)
    output.write(0.0)
    assert volts(rig) == pytest.approx(0.0, abs=1e-3)
    rig.wait(2.0)
    assert volts(rig) == pytest.approx(0.0, abs=1e-3)
    with pytest.raises(DeviceError, match="has been given no run"):
        output.is_done()


@pytest.mark.parametrize("method", ["ClearTask", "CreateTask", "StartTask", "CreateAOVoltageChan"])
def test_a_write_that_could_not_end_it_can_be_tried_again(rig: NiRig, method: str) -> None:
    output, signals = loaded(rig)
    signals.start()
    rig.wait(0.5)
    rig.server.faults.refuse[method] = -200324
    with pytest.raises(DeviceError):
        output.write(0.0)
    rig.server.faults.refuse.clear()
    output.open()
    output.write(0.0)
    assert volts(rig) == pytest.approx(0.0, abs=1e-3)


def test_the_guard_and_labrig_safe_end_it_from_another_connection(rig: NiRig) -> None:
    _, signals = loaded(rig)
    signals.start()
    rig.wait(0.5)
    other = NiConnection("simulated", rig.server.in_process_channel())
    report = shut_down(other, rig.clock, PLACE)
    assert report.state is Safety.SAFE
    assert volts(rig) == pytest.approx(0.0, abs=1e-3)
    rig.wait(2.0)
    assert volts(rig) == pytest.approx(0.0, abs=1e-3)


def test_a_read_back_starts_no_run_that_could_not_be_ended(rig: NiRig) -> None:
    """The run is loaded and not begun when the board stops to end tasks; it still measures."""
    output, signals = loaded(rig)
    rig.server.faults.hang.add("ClearTask")
    amplifier = Amplifier(10.0, 2.0)
    report = make_safe(SheetDrive(output, amplifier), signals, rig.clock, "drive", 0.05)
    other = NiConnection("simulated", rig.server.in_process_channel())
    further = shut_down(other, rig.clock, PLACE, patience_s=1.0)
    for each in (report, further):
        assert each.state is Safety.UNKNOWN
        assert NOT_READ in each.failures
    for _ in range(40):
        assert volts(rig) == pytest.approx(0.0, abs=1e-3)
        rig.wait(0.05)


def test_a_board_whose_buffer_runs_empty_is_noticed_and_zero_is_written(rig: NiRig) -> None:
    output, signals = loaded(rig)
    signals.start()
    rig.wait(0.5)
    rig.server.faults.underflow = True
    rig.wait(1.0)
    assert volts(rig) == pytest.approx(0.2, abs=1e-3)  # as a board does: it keeps its volts
    with pytest.raises(DeviceError, match=r"run of the output .*-200621"):
        output.is_done()
    output.write(0.0)
    assert volts(rig) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(
    ("waveform", "error", "said"),
    [
        ((TimedVoltage(0, 0.3), TimedVoltage(9, 0.0)), LimitError, "limited to"),
        ((TimedVoltage(0, float("nan")), TimedVoltage(9, 0.0)), LimitError, "limited to"),
        ((TimedVoltage(0, 0.2),), DeviceError, "must end at 0 V"),
        ((TimedVoltage(9, 0.2), TimedVoltage(9, 0.0)), DeviceError, "indices"),
        ((), DeviceError, "indices"),
        ((TimedVoltage(0, 0.2), TimedVoltage(10**9, 0.0)), DeviceError, "too long"),
    ],
)
def test_a_run_that_would_not_be_safe_is_refused_and_leaves_the_output_at_zero(
    rig: NiRig, waveform, error, said
) -> None:
    output = rig.output(trigger=START)
    output.open()
    with pytest.raises(error, match=said):
        output.load(waveform, RATE_HZ)
    output.write(0.1)
    assert volts(rig) == pytest.approx(0.1, abs=1e-3)
    output.write(0.0)


@pytest.mark.parametrize("method", ["CfgSampClkTiming", "CfgDigEdgeStartTrig", "WriteAnalogF64"])
def test_a_board_that_refuses_a_run_stays_ours_at_zero(rig: NiRig, method: str) -> None:
    output = rig.output(trigger=START)
    output.open()
    rig.server.faults.refuse[method] = -200324
    with pytest.raises(DeviceError):
        output.load(PULSES, RATE_HZ)
    rig.server.faults.refuse.clear()
    assert output.write(0.0) is not None


def test_an_output_without_a_clock_or_apart_from_the_inputs_is_not_timed(simulated_ni) -> None:
    static = simulated_ni.output(trigger="/PCI6034E/ai/StartTrigger")
    static.open()
    assert not static.is_timed
    with pytest.raises(DeviceError, match="no clock"):
        static.load(PULSES, RATE_HZ)
