"""The line that an external one-shot listens to: edges while the loop lives, none when it ends."""

import numpy as np
import pytest

from drivers.boards.ni.interlock import NiInterlock
from drivers.interfaces import DeviceError, DeviceNotFoundError

LINE = "PCI6703/port0/line0"
ONE_SHOT_S = 0.3


def edges(rig) -> list[float]:
    return [edge.time_s for edge in rig.server.lines.edges if edge.line == LINE]


@pytest.fixture
def interlock(simulated_ni):
    line = NiInterlock(simulated_ni.connection, simulated_ni.clock, LINE)
    line.open()
    yield line
    line.close()


@pytest.mark.parametrize("every_s", [0.001, 0.02, 0.05])
def test_a_loop_that_beats_keeps_the_one_shot_on(simulated_ni, interlock, every_s):
    for _ in range(round(2.0 / every_s)):
        interlock.beat()
        simulated_ni.wait(every_s)
    gaps = np.diff(edges(simulated_ni))
    assert gaps.max() < 0.5 * ONE_SHOT_S
    assert len(gaps) <= 100  # and no more edges than it needs


def test_opening_and_closing_make_no_edge_and_leave_none_to_come(simulated_ni):
    line = NiInterlock(simulated_ni.connection, simulated_ni.clock, LINE)
    line.open()
    line.open()
    simulated_ni.wait(1.0)
    assert edges(simulated_ni) == []
    line.beat()
    line.close()
    line.close()
    assert len(edges(simulated_ni)) == 1
    with pytest.raises(DeviceError, match="not open"):
        line.beat()


def test_a_line_that_is_not_there_is_refused(simulated_ni):
    line = NiInterlock(simulated_ni.connection, simulated_ni.clock, "PCI6703/port0/line99")
    with pytest.raises(DeviceNotFoundError, match="no such channel"):
        line.open()


def test_a_failed_edge_names_the_line(simulated_ni, interlock):
    for method in ("WriteDigitalLines", "WriteDigitalScalarU32", "WriteDigitalU32"):
        simulated_ni.server.faults.refuse[method] = -200324
    with pytest.raises(DeviceError, match=f"toggling the interlock line {LINE}"):
        interlock.beat()
    simulated_ni.server.faults.refuse.clear()
