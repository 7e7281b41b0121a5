"""Making safe and taking over on simulated boards, with every call failing in its turn."""

import pytest

from drivers import Amplifier, SheetDrive, make_safe
from drivers.boards.ni.connection import NiConnection
from drivers.boards.ni.rescue import OutputPlace, shut_down
from drivers.interfaces import DeviceNotFoundError
from drivers.safe_shutdown import Safety

GAIN = 10.0
PLACE = OutputPlace(
    address="simulated",
    output_channel="PCI6703/ao0",
    drive_channel="PCI6034E/ai2",
    limit_board_V=0.25,
)
METHODS = (
    "CreateTask",
    "CreateAOVoltageChan",
    "CreateAIVoltageChan",
    "CfgSampClkTiming",
    "TaskControl",
    "StartTask",
    "StopTask",
    "ClearTask",
    "WriteAnalogScalarF64",
    "ReadAnalogF64",
    "GetTaskAttributeUInt32",
)


def energised(rig):
    """A run under way: 2 V at the sheet, the inputs acquiring."""
    amplifier = Amplifier(GAIN, 2.5)
    drive = SheetDrive(rig.output(limit_V=amplifier.limit_board_V), amplifier)
    drive.open()
    signals = rig.signals()
    signals.open()
    signals.start()
    drive.write(2.0)
    return drive, signals


def board_volts(rig) -> float:
    """What is truly on the wire, asked of a task of its own when the faults are over."""
    rig.server.faults.refuse.clear()
    look = NiConnection("simulated", rig.server.in_process_channel())
    for name in ("labrig-output", "labrig-input"):
        task = look.attach_task(name)
        if task is not None:
            task.close()
    signals = rig.signals(task_name="look")
    signals.open()
    volts = float(signals.measure(0.01)[2].mean())
    signals.close()
    return volts


def test_a_run_under_way_is_made_safe(simulated_ni):
    drive, signals = energised(simulated_ni)
    report = make_safe(drive, signals, simulated_ni.clock, "drive", 0.05)
    assert report.state is Safety.SAFE
    assert report.failures == ()
    assert board_volts(simulated_ni) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.slow
def test_a_run_whose_tasks_were_cleared_from_outside_is_made_safe(simulated_ni):
    drive, signals = energised(simulated_ni)
    for name in ("labrig-output", "labrig-input"):
        simulated_ni.connection.attach_task(name).close()
    report = make_safe(drive, signals, simulated_ni.clock, "drive", 0.05)
    assert report.state is Safety.SAFE
    assert "no longer exists" in report.failures[0]
    assert board_volts(simulated_ni) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("method", METHODS)
def test_safe_is_said_only_of_zero_volts_whatever_call_fails(simulated_ni, method):
    drive, signals = energised(simulated_ni)
    simulated_ni.server.faults.refuse[method] = -200324
    report = make_safe(drive, signals, simulated_ni.clock, "drive", 0.05)
    volts = board_volts(simulated_ni)
    if method == "WriteAnalogScalarF64":
        assert report.state is Safety.UNKNOWN
        assert volts == pytest.approx(0.2, abs=1e-3)
    else:
        assert volts == pytest.approx(0.0, abs=1e-3)  # no other call stands before 0 V


def test_a_stuck_output_is_unknown(simulated_ni):
    drive, signals = energised(simulated_ni)
    simulated_ni.server.faults.stuck_outputs.add("PCI6703/ao0")
    report = make_safe(drive, signals, simulated_ni.clock, "drive", 0.05)
    assert report.state is Safety.UNKNOWN
    assert report.read_back_V == pytest.approx(0.2, abs=1e-3)


def test_a_read_back_that_is_no_number_is_unknown(simulated_ni):
    drive, signals = energised(simulated_ni)
    simulated_ni.server.faults.nan.add("PCI6034E/ai2")
    assert make_safe(drive, signals, simulated_ni.clock, "drive", 0.05).state is Safety.UNKNOWN


# -------------------------------------------------------------------------------------- take over


def test_another_client_takes_a_run_over_and_leaves_nothing_behind(simulated_ni):
    energised(simulated_ni)
    other = NiConnection("simulated", simulated_ni.server.in_process_channel())
    report = shut_down(other, simulated_ni.clock, PLACE)
    assert report.state is Safety.SAFE
    assert report.failures == ()
    assert other.attach_task("labrig-output") is None
    assert other.attach_task("labrig-input") is None
    assert board_volts(simulated_ni) == pytest.approx(0.0, abs=1e-3)


def test_taking_over_an_idle_rig_writes_zero_and_reads_it_back(simulated_ni):
    report = shut_down(simulated_ni.connection, simulated_ni.clock, PLACE)
    assert report.state is Safety.SAFE
    assert report.failures == ()


@pytest.mark.parametrize("method", METHODS)
def test_taking_over_says_safe_only_of_zero_volts_whatever_call_fails(simulated_ni, method):
    energised(simulated_ni)
    other = NiConnection("simulated", simulated_ni.server.in_process_channel())
    simulated_ni.server.faults.refuse[method] = -200324
    report = shut_down(other, simulated_ni.clock, PLACE, patience_s=0.1)
    volts = board_volts(simulated_ni)
    if report.state is Safety.SAFE:
        assert volts == pytest.approx(0.0, abs=1e-3)
    else:
        assert any("-200324" in failure for failure in report.failures)


@pytest.mark.slow
def test_boards_that_somebody_else_holds_are_waited_for_and_then_reported(simulated_ni):
    """A task of another name: not ours to clear."""
    foreign = simulated_ni.output(task_name="somebody else")
    foreign.open()
    foreign.write(0.2)
    began = simulated_ni.clock.now()
    report = shut_down(simulated_ni.connection, simulated_ni.clock, PLACE, patience_s=1.0)
    assert report.state is Safety.UNKNOWN
    assert any("-50103" in failure for failure in report.failures)
    assert 1.0 <= simulated_ni.clock.now() - began < 1.5


def test_a_board_that_is_not_there_is_reported_with_those_that_are(simulated_ni):
    place = OutputPlace(
        address="simulated", output_channel="PCI9999/ao0", drive_channel="PCI6034E/ai2"
    )
    report = shut_down(simulated_ni.connection, simulated_ni.clock, place)
    assert report.state is Safety.UNKNOWN
    assert any("devices found: PCI6703, PCI6034E" in failure for failure in report.failures)


# ------------------------------------------------------------------------------------- connection


def test_devices_are_listed_with_their_types(ni_rig):
    devices = {device.name: device.product_type for device in ni_rig.connection.devices()}
    if ni_rig.server is not None:
        assert devices == {"PCI6703": "PCI-6703", "PCI6034E": "PCI-6034E"}
    assert ni_rig.drive.split("/")[0] in devices
    assert float(ni_rig.connection.driver_version()) > 7.0


def test_a_connection_can_be_closed_twice_and_opened_again(tcp_ni):
    tcp_ni.connection.close()
    tcp_ni.connection.close()
    tcp_ni.connection.open()
    assert len(tcp_ni.connection.devices()) == 2


def test_a_server_that_went_away_is_said_so(tcp_ni):
    tcp_ni.server.stop()
    with pytest.raises(DeviceNotFoundError, match="no connection to the NI gRPC Device Server"):
        tcp_ni.connection.devices()


def test_a_local_driver_has_no_tasks_of_other_processes():
    assert NiConnection("local").attach_task("labrig-output") is None
