"""The lines of boards that trigger a camera: one rising edge for each exposure."""

from __future__ import annotations

import pytest

from drivers.boards.contract import BoardConnection
from drivers.boards.ni.trigger import NiTrigger
from drivers.interfaces import DeviceError, DeviceNotFoundError, TriggersFrames
from sim_hardware.clock import VirtualClock
from tests.drivers.labjack_rig import LabJackRig

LINE = "PCI6703/port0/line1"


def rising(rig) -> list[float]:
    return [edge.time_s for edge in rig.server.lines.edges if edge.line == LINE and edge.high]


def test_each_exposure_is_one_edge_at_the_time_that_is_told(simulated_ni):
    line = NiTrigger(simulated_ni.connection, simulated_ni.clock, LINE)
    with pytest.raises(DeviceError, match="is not open"):
        line.fire()
    line.open()
    assert rising(simulated_ni) == []
    pulses = []
    for _ in range(3):
        simulated_ni.wait(0.02)
        pulses.append(line.fire())
    line.close()
    line.close()
    edges_s = rising(simulated_ni)
    assert len(edges_s) == 3
    for pulse, edge_s in zip(pulses, edges_s, strict=True):
        assert pulse.before_s <= edge_s <= pulse.after_s
    assert not simulated_ni.server.lines.level(LINE)


def test_a_line_that_another_program_left_is_taken(simulated_ni):
    left = NiTrigger(simulated_ni.connection, simulated_ni.clock, LINE)
    left.open()
    left.fire()
    line = NiTrigger(simulated_ni.connection, simulated_ni.clock, LINE)
    line.open()
    line.fire()
    line.close()
    assert len(rising(simulated_ni)) == 2


def test_a_line_that_is_not_there_is_refused(simulated_ni):
    line = NiTrigger(simulated_ni.connection, simulated_ni.clock, "PCI6703/port0/line99")
    with pytest.raises(DeviceNotFoundError, match="no such channel"):
        line.open()


def test_a_failed_edge_names_the_line(simulated_ni):
    line = NiTrigger(simulated_ni.connection, simulated_ni.clock, LINE)
    line.open()
    for method in ("WriteDigitalLines", "WriteDigitalScalarU32", "WriteDigitalU32"):
        simulated_ni.server.faults.refuse[method] = -200324
    with pytest.raises(DeviceError, match=f"triggering the camera by {LINE}"):
        line.fire()
    simulated_ni.server.faults.refuse.clear()
    line.close()


def test_a_labjack_has_such_a_line_too():
    clock = VirtualClock()
    rig = LabJackRig(clock)
    seen: list[tuple[str, bool]] = []
    rig.device.wired = lambda line, high, _when: seen.append((line, high))
    boards: BoardConnection = rig.boards()
    boards.open()
    assert isinstance(boards, TriggersFrames)
    line = boards.frame_trigger("EIO1")
    with pytest.raises(DeviceError, match="is not open"):
        line.fire()
    line.open()
    pulse = line.fire()
    assert pulse.before_s <= clock.now()
    assert seen == [("EIO1", True), ("EIO1", False)]
    line.close()
    boards.close()
