"""What every NI input must do, simulated or real, and what it does when things go wrong."""

import numpy as np
import pytest

from drivers.boards.ni import analog_input as ni_input
from drivers.boards.ni import deadlines as ni_deadlines
from drivers.boards.ni.analog_input import InputChannel, NiSignalInput
from drivers.boards.ni.errors import DeviceReservedError, TaskGoneError
from drivers.interfaces import (
    DeviceError,
    DeviceNotFoundError,
    DeviceTimeoutError,
    LostSamplesError,
    SignalInput,
)


def test_channels_and_actual_ranges_are_told(ni_rig):
    signals = ni_rig.signals()
    signals.open()
    assert isinstance(signals, SignalInput)
    assert list(signals.channels) == ["force", "current", "drive"]
    # 0.04, 0.3 and 4 V were asked for; the board has 0.05, 0.5, 5 and 10 V.
    assert list(signals.ranges_V) == pytest.approx([0.05, 0.5, 5.0])


@pytest.mark.slow
def test_blocks_join_without_gap_or_overlap(ni_rig):
    signals = ni_rig.signals(rate_hz=1000.0)
    signals.open()
    clock = signals.start()
    unsure_s = clock.start_uncertainty_s  # a busy computer takes its time to start them
    late = 2 if ni_rig.server else 60  # a real board hands its samples on in lumps
    following, lengths = 0, []
    for _ in range(10):
        ni_rig.wait(0.03)
        asked_s = ni_rig.clock.now()
        block = signals.read_available()
        assert block.first_index == following
        assert block.volts.shape[0] == 3
        assert block.volts.flags.owndata
        following += block.volts.shape[1]
        lengths.append(block.volts.shape[1])
        assert clock.index_at(asked_s - unsure_s) - late <= following
        assert following <= clock.index_at(block.read_s + unsure_s) + 2
    signals.stop()
    signals.stop()
    assert min(lengths) > 0


def test_nothing_new_is_an_empty_block(simulated_ni):
    signals = simulated_ni.signals()
    signals.open()
    signals.start()
    simulated_ni.wait(0.01)
    assert signals.read_available().volts.shape[1] > 0
    again = signals.read_available()
    assert again.volts.shape == (3, 0)


def test_an_edge_is_found_at_the_sample_that_the_clocks_predict(ni_rig):
    output = ni_rig.output()
    output.open()
    signals = ni_rig.signals(rate_hz=5000.0)
    signals.open()
    sample_clock = signals.start()
    ni_rig.wait(0.1)
    write = output.write(0.2)
    ni_rig.wait(0.1)
    drive = signals.read_available().volts[2] / ni_rig.volts_per_volt
    signals.stop()
    edge = int(np.argmax(drive > 0.1))
    early = sample_clock.index_at(write.before_s - sample_clock.start_uncertainty_s)
    late = sample_clock.index_at(write.after_s + sample_clock.start_uncertainty_s)
    slack = 2 if ni_rig.server else 25  # a real amplifier takes its time
    assert early - 2 <= edge <= late + slack


def test_measuring_gives_what_was_asked_for_and_stops(ni_rig):
    signals = ni_rig.signals(rate_hz=2000.0)
    signals.open()
    for _ in range(2):
        assert signals.measure(0.05).shape == (3, round(0.05 * signals.rate_hz))
    signals.start()
    with pytest.raises(DeviceError, match="acquiring already"):
        signals.measure(0.01)
    signals.stop()


def test_the_achieved_rate_is_used_not_the_one_asked_for(simulated_ni):
    """The board divides 20 MHz: 30 kHz is not among its rates."""
    signals = simulated_ni.signals(rate_hz=30_000.0)
    signals.open()
    sample_clock = signals.start()
    assert sample_clock.rate_hz == signals.rate_hz != 30_000.0
    assert 20e6 / signals.rate_hz == pytest.approx(round(20e6 / 30_000.0), abs=1.0)
    assert 20e6 / signals.rate_hz == pytest.approx(round(20e6 / signals.rate_hz), abs=1e-6)


def test_a_run_after_another_counts_from_zero_again(ni_rig):
    signals = ni_rig.signals()
    signals.open()
    for _ in range(2):
        signals.start()
        ni_rig.wait(0.03)
        assert signals.read_available().first_index == 0
        signals.stop()


def test_closing_twice_and_opening_again_work(ni_rig):
    signals = ni_rig.signals()
    signals.open()
    signals.start()
    signals.close()
    signals.close()
    signals.open()
    signals.open()
    assert signals.measure(0.01).shape[0] == 3


def test_what_is_not_open_or_not_running_says_so(simulated_ni):
    signals = simulated_ni.signals()
    with pytest.raises(DeviceError, match="not open"):
        signals.start()
    signals.stop()
    signals.open()
    with pytest.raises(DeviceError, match="start them first"):
        signals.read_available()


def test_a_second_program_is_refused_the_board(ni_rig):
    signals = ni_rig.signals()
    signals.open()
    with pytest.raises(DeviceReservedError, match="labrig safe"):
        ni_rig.signals().open()
    with pytest.raises(DeviceReservedError, match="-50103"):
        ni_rig.signals(task_name="another").open()


@pytest.mark.parametrize(
    ("physical", "says"),
    [("PCI9999/ai0", "devices found: .*PCI6034E"), ("PCI6034E/ai99", "no such channel")],
)
def test_a_channel_that_is_not_there_is_refused_with_what_is(simulated_ni, physical, says):
    wrong = NiSignalInput(
        simulated_ni.connection, simulated_ni.clock, [InputChannel("x", physical, 1.0)], 1000.0
    )
    with pytest.raises(DeviceNotFoundError, match=says):
        wrong.open()
    simulated_ni.signals().open()  # the failure has left no task behind


def test_a_rate_beyond_the_board_is_refused_at_opening(simulated_ni):
    """200 kS/s are shared by the channels."""
    with pytest.raises(DeviceError, match="opening the inputs"):
        simulated_ni.signals(rate_hz=70_000.0).open()


# ----------------------------------------------------------------------------------------- faults


def test_samples_that_were_overwritten_are_counted(simulated_ni):
    signals = simulated_ni.signals(rate_hz=1000.0)
    signals.open()
    signals.start()
    simulated_ni.wait(1.0)
    first = signals.read_available().volts.shape[1]
    simulated_ni.wait(25.0)  # the buffer holds ten seconds
    with pytest.raises(LostSamplesError, match=rf"lost after sample {first}\b") as caught:
        signals.read_available()
    assert "PCI6034E/ai0 (force)" in str(caught.value)


def test_a_board_that_loses_samples_is_told_at_once(simulated_ni):
    signals = simulated_ni.signals()
    signals.open()
    signals.start()
    simulated_ni.server.faults.lose_after_reads = 1
    simulated_ni.wait(0.05)
    signals.read_available()
    simulated_ni.wait(0.05)
    with pytest.raises(LostSamplesError, match="samples of each channel are lost"):
        signals.read_available()


def test_a_task_that_was_cleared_from_outside_can_be_opened_anew(simulated_ni):
    signals = simulated_ni.signals()
    signals.open()
    signals.start()
    simulated_ni.connection.attach_task("labrig-input").close()
    with pytest.raises(TaskGoneError):
        signals.read_available()
    signals.stop()
    signals.open()
    assert signals.measure(0.01).shape == (3, 10)


@pytest.mark.parametrize("method", ["StartTask", "ReadAnalogF64", "StopTask"])
def test_a_refusal_names_the_channels_and_leaves_the_input_usable(simulated_ni, method):
    signals = simulated_ni.signals()
    signals.open()
    simulated_ni.server.faults.refuse[method] = -200324
    with pytest.raises(DeviceError, match="PCI6034E/ai0"):
        signals.measure(0.01)
    simulated_ni.server.faults.refuse.clear()
    signals.close()
    signals.open()
    assert signals.measure(0.01).shape == (3, 10)


@pytest.mark.slow
def test_a_server_that_hangs_does_not_hang_a_read(tcp_ni, monkeypatch):
    monkeypatch.setattr(ni_deadlines, "QUICK_S", 0.3)
    monkeypatch.setattr(ni_input, "MARGIN_S", 0.2)
    signals = tcp_ni.signals()
    signals.open()
    tcp_ni.server.faults.hang.add("ReadAnalogF64")
    began = tcp_ni.clock.now()
    with pytest.raises(DeviceTimeoutError, match="did not answer"):
        signals.measure(0.01)
    assert tcp_ni.clock.now() - began < 1.5
