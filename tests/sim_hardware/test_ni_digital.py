"""Static digital lines, such as those that feed an interlock."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from nidaqmx.constants import LineGrouping
from nidaqmx.errors import DaqError
from nidaqmx.stream_writers import DigitalSingleChannelWriter

PER_LINE, ALL = LineGrouping.CHAN_PER_LINE, LineGrouping.CHAN_FOR_ALL_LINES


def lines(ni: Any, which: str, grouping: LineGrouping = PER_LINE) -> Any:
    task = ni.task()
    task.do_channels.add_do_chan(which, line_grouping=grouping)
    return task


def high(ni: Any, board: str = "PCI6703", port: int = 0) -> list[bool]:
    return [ni.server.lines.level(f"{board}/port{port}/line{k}") for k in range(8)]


def test_one_line_is_written(ni: Any) -> None:
    task = lines(ni, "PCI6703/port0/line3")
    task.write(True)
    assert high(ni) == [k == 3 for k in range(8)]
    task.write(False)
    assert not any(high(ni))


def test_lines_of_one_channel_are_bits(ni: Any) -> None:
    lines(ni, "PCI6703/port0", ALL).write(0b1010_0110)
    assert high(ni) == [False, True, True, False, False, True, False, True]


def test_lines_of_their_own_channels_are_booleans(ni: Any) -> None:
    lines(ni, "PCI6703/port0/line0:2").write([True, False, True])
    assert high(ni)[:3] == [True, False, True]


def test_words_of_each_width_are_written(ni: Any) -> None:
    writer = DigitalSingleChannelWriter(lines(ni, "X/port0", ALL).out_stream, auto_start=True)
    writer.write_one_sample_port_uint32(0xFFFF_0001)
    assert ni.server.lines.level("X/port0/line31")
    writer.write_one_sample_port_uint32(2)
    assert high(ni, "X") == [False, True] + [False] * 6
    small = DigitalSingleChannelWriter(lines(ni, "X/port1", ALL).out_stream, auto_start=True)
    small.write_one_sample_port_byte(4)
    assert high(ni, "X", 1)[2]
    small.write_many_sample_port_uint16(np.array([1, 2, 8], np.uint16))
    assert high(ni, "X", 1)[3]


def test_levels_are_read_back(ni: Any) -> None:
    lines(ni, "PCI6703/port0", ALL).write(0x81)
    single, port = ni.task(), ni.task()
    single.di_channels.add_di_chan("PCI6703/port0/line7", line_grouping=PER_LINE)
    assert single.read() is True
    single.close()
    port.di_channels.add_di_chan("PCI6703/port0", line_grouping=ALL)
    assert port.read() == 0x81
    assert port.read(3) == [0x81] * 3


def test_a_line_keeps_its_level_when_its_task_is_cleared_and_the_board_reset(ni: Any) -> None:
    task = lines(ni, "PCI6703/port0/line0")
    task.start()
    task.write(True)
    task.close()
    ni.system.devices["PCI6703"].reset_device()
    assert high(ni)[0]


def test_edges_are_kept_with_their_times(make_ni: Any) -> None:
    ni = make_ni(tcp=False)
    task = lines(ni, "PCI6703/port0/line0")
    task.start()
    for k in range(4):
        task.write(k % 2 == 0)
        task.write(k % 2 == 0)  # no edge
        ni.pass_time(0.05)
    edges = ni.server.lines.edges
    assert [edge.high for edge in edges] == [True, False, True, False]
    assert [edge.time_s for edge in edges] == pytest.approx([0.0, 0.05, 0.10, 0.15])
    assert ni.server.lines.last_edge_s("PCI6703/port0/line0") == pytest.approx(0.15)
    assert ni.server.lines.last_edge_s("PCI6703/port0/line1") is None


@pytest.mark.parametrize(
    ("provoke", "code"),
    [
        (lambda ni: lines(ni, "PCI6703/port0/line8"), -200170),
        (lambda ni: lines(ni, "PCI6703/port1"), -200170),
        (lambda ni: lines(ni, "PCI6703/port0"), -200528),
        (lambda ni: lines(ni, "Nowhere/port0"), -200220),
        (lambda ni: lines(ni, "PCI6703/port0/line0").write(True, auto_start=False), -200846),
        (
            lambda ni: DigitalSingleChannelWriter(
                ni.output().out_stream, auto_start=True
            ).write_one_sample_one_line(True),
            -200459,
        ),
    ],
)
def test_what_cannot_be_written_is_refused(ni: Any, provoke: Any, code: int) -> None:
    with pytest.raises(DaqError) as fault:
        provoke(ni)
    assert fault.value.error_code == code
