"""What every NI output must do, simulated or real, and what it does when things go wrong."""

import math

import numpy as np
import pytest

from drivers import Amplifier, SheetDrive
from drivers.boards.ni import analog_output as ni_output
from drivers.boards.ni import deadlines as ni_deadlines
from drivers.boards.ni.analog_output import NiVoltageOutput
from drivers.boards.ni.errors import DeviceReservedError, TaskGoneError
from drivers.interfaces import (
    DeviceError,
    DeviceNotFoundError,
    DeviceTimeoutError,
    LimitError,
    VoltageOutput,
)

LSB_V = 20.0 / 65536  # of the 6703; the 6034E's at ±5 V is half of it


def read_back(rig, seconds: float = 0.02) -> float:
    """The drive voltage as the board's input sees it, in board volts."""
    signals = rig.signals(task_name="look")
    signals.open()
    volts = float(np.mean(signals.measure(seconds)[2])) / rig.volts_per_volt
    signals.close()
    return volts


def test_opening_writes_zero_and_writes_arrive_at_the_terminal(ni_rig):
    output = ni_rig.output()
    output.open()
    assert read_back(ni_rig) == pytest.approx(0.0, abs=2 * LSB_V)
    for board_V in (0.2, -0.2, 0.05):
        output.write(board_V)
        assert read_back(ni_rig) == pytest.approx(board_V, abs=2 * LSB_V)
    output.close()
    assert read_back(ni_rig) == pytest.approx(0.0, abs=2 * LSB_V)


def test_a_write_is_bracketed_by_two_clock_times(ni_rig):
    output = ni_rig.output()
    output.open()
    before = ni_rig.clock.now()
    done = output.write(0.1)
    assert before <= done.before_s <= done.after_s <= ni_rig.clock.now()


def test_closing_twice_and_opening_again_work(ni_rig):
    output = ni_rig.output()
    output.open()
    output.write(0.1)
    output.close()
    output.close()
    output.open()
    output.open()
    assert read_back(ni_rig) == pytest.approx(0.0, abs=2 * LSB_V)
    output.write(0.1)
    assert read_back(ni_rig) == pytest.approx(0.1, abs=2 * LSB_V)


@pytest.mark.parametrize("asked", [0.2501, -0.2501, 10.0, math.inf, -math.inf, math.nan])
def test_a_value_beyond_the_limit_is_refused_and_the_voltage_stays(ni_rig, asked):
    output = ni_rig.output(limit_V=0.25)
    output.open()
    output.write(0.1)
    with pytest.raises(LimitError, match="nothing was written"):
        output.write(asked)
    assert read_back(ni_rig) == pytest.approx(0.1, abs=2 * LSB_V)


def test_the_driver_refuses_beyond_the_limit_too(ni_rig):
    """Whoever gets hold of the task by its name meets the same limit."""
    output = ni_rig.output(limit_V=0.25)
    output.open()
    if ni_rig.connection.is_local:
        pytest.skip("a local task belongs to its process")
    task = ni_rig.connection.attach_task("labrig-output")
    with pytest.raises(LimitError, match="-200561"), ni_rig.connection.errors("writing"):
        task.write(0.26)
    assert read_back(ni_rig) == pytest.approx(0.0, abs=2 * LSB_V)


def test_the_full_sheet_limit_passes_both_limits(ni_rig):
    amplifier = Amplifier(gain=9.7, limit_sheet_V=2.5)
    drive = SheetDrive(ni_rig.output(limit_V=amplifier.limit_board_V), amplifier)
    drive.open()
    for sheet_V in (2.5, -2.5):
        assert drive.write(sheet_V).board_V == sheet_V / 9.7
        assert read_back(ni_rig) == pytest.approx(sheet_V / 9.7, abs=2 * LSB_V)
    assert isinstance(drive, VoltageOutput)
    drive.close()


def test_writing_before_opening_or_after_closing_is_refused(ni_rig):
    output = ni_rig.output()
    with pytest.raises(DeviceError, match="not open"):
        output.write(0.0)
    output.open()
    output.close()
    with pytest.raises(DeviceError, match="not open"):
        output.write(0.1)


def test_a_second_program_is_refused_the_output(ni_rig):
    output = ni_rig.output()
    output.open()
    output.write(0.1)
    with pytest.raises(DeviceReservedError, match="labrig safe"):
        ni_rig.output().open()
    with pytest.raises(DeviceReservedError, match="-50103"):
        ni_rig.output(task_name="another").open()
    assert read_back(ni_rig) == pytest.approx(0.1, abs=2 * LSB_V)


@pytest.mark.parametrize(
    ("channel", "says"),
    [("PCI9999/ao0", "devices found: .*PCI6703"), ("PCI6703/ao99", "no such channel")],
)
def test_a_channel_that_is_not_there_is_refused_with_what_is(simulated_ni, channel, says):
    output = NiVoltageOutput(simulated_ni.connection, simulated_ni.clock, channel, 0.25)
    with pytest.raises(DeviceNotFoundError, match=says):
        output.open()
    right = simulated_ni.output()
    right.open()  # the failure has left no task behind


def test_a_limit_that_the_board_cannot_reach_is_refused(simulated_ni):
    with pytest.raises(DeviceError, match="-200077"):
        simulated_ni.output(limit_V=11.0).open()


# ----------------------------------------------------------------------------------------- faults

WRITES = "WriteAnalogScalarF64"


def test_a_refused_zero_keeps_the_task_so_that_closing_can_be_tried_again(simulated_ni):
    output = simulated_ni.output()
    output.open()
    output.write(0.2)
    simulated_ni.server.faults.refuse[WRITES] = -200324
    with pytest.raises(
        DeviceError, match=r"writing 0 V .* last one confirmed is 0\.2 V, before the amplifier"
    ):
        output.close()
    simulated_ni.server.faults.refuse.clear()
    assert read_back(simulated_ni) == pytest.approx(0.2, abs=2 * LSB_V)
    output.close()
    assert read_back(simulated_ni) == pytest.approx(0.0, abs=2 * LSB_V)


def test_an_output_that_cannot_write_zero_does_not_open(simulated_ni):
    simulated_ni.server.faults.refuse[WRITES] = -200324
    with pytest.raises(DeviceError):
        simulated_ni.output().open()
    simulated_ni.server.faults.refuse.clear()
    simulated_ni.output().open()


def test_a_task_that_was_cleared_from_outside_is_told_and_can_be_opened_anew(ni_rig):
    if ni_rig.connection.is_local:
        pytest.skip("a local task belongs to its process")
    output = ni_rig.output()
    output.open()
    output.write(0.2)
    ni_rig.connection.attach_task("labrig-output").close()
    with pytest.raises(TaskGoneError, match="no longer exists"):
        output.write(0.1)
    assert read_back(ni_rig) == pytest.approx(0.2, abs=2 * LSB_V)  # clearing leaves the voltage
    output.open()
    assert read_back(ni_rig) == pytest.approx(0.0, abs=2 * LSB_V)


@pytest.mark.slow
def test_a_server_that_hangs_does_not_hang_a_write(tcp_ni, monkeypatch):
    monkeypatch.setattr(ni_deadlines, "QUICK_S", 0.3)
    monkeypatch.setattr(ni_output, "WRITE_TIMEOUT_S", 0.2)
    output = tcp_ni.output()
    output.open()
    tcp_ni.server.faults.hang.add(WRITES)
    began = tcp_ni.clock.now()
    with pytest.raises(DeviceTimeoutError, match="did not answer"):
        output.write(0.1)
    assert tcp_ni.clock.now() - began < 1.5
