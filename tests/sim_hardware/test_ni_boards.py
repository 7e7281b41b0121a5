"""Each simulated board, through nidaqmx and over gRPC: what it reports, takes and refuses."""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nidaqmx.constants import AcquisitionType, BusType, ProductCategory, TerminalConfiguration
from nidaqmx.errors import DaqError, RpcError

from sim_hardware.ni import LoopbackWires, board_models
from sim_hardware.ni.boards import FOLDER, board_model, faults, input_board, output_board
from sim_hardware.ni.boards.contract import (
    AnalogInputs,
    AnalogOutputs,
    BoardModel,
    DigitalPort,
    Terminals,
)
from sim_hardware.plugins import PluginWarning, UnknownPartError

BOARDS = board_models()
WITH_INPUTS = [name for name, board in BOARDS.items() if board.analog_in]
WITH_OUTPUTS = [name for name, board in BOARDS.items() if board.analog_out]


@pytest.fixture(params=[False, True], ids=["in process", "tcp"])
def board_server(request: pytest.FixtureRequest, make_ni: Any) -> Any:
    """Make a server with one board, `Dev1`, whose first output is wired to its first input."""

    def make(model: str) -> Any:
        wires = LoopbackWires([("ao0", "ai0")])
        return make_ni(tcp=request.param, bench=wires, devices={"Dev1": model}, seed=None)

    return make


def refused(code: int) -> Any:
    return pytest.raises(DaqError, match=f"Status Code: {code}")


# ------------------------------------------------------------------------------- the parts


@pytest.mark.parametrize("name", sorted(FOLDER.parts()))
def test_every_board_fulfils_the_contract(name: str) -> None:
    assert faults(FOLDER.get(name)) == []


def test_a_board_is_found_by_its_product_type_and_an_unknown_one_is_answered_with_all() -> None:
    assert board_model("USB-6211").analog_in.channels == 16
    with pytest.raises(UnknownPartError, match=r"no simulated board 'usb-6212'.*'USB-6211'"):
        board_model("usb-6212")


def test_a_board_is_found_by_what_it_can() -> None:
    assert output_board() == "PCI-6703"
    assert input_board([(0.05, 0.05), (5.0, 5.0)], outputs=False) == "PCI-6034E"
    assert input_board([(0.05, 0.2), (5.0, 5.0)], outputs=True) == "USB-6211"
    assert input_board([(0.05, 0.1), (5.0, 5.0)], outputs=True) == "PCIe-6363"
    assert input_board([(0.05, 0.123)], outputs=False) == "PCI-6034E"  # the next best


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (7, "type int, not a BoardModel"),
        ({"product_type": "a/b"}, "product_type"),
        ({"product_number": -1}, "product_number"),
        ({"category": 14643}, "ProductCategory"),
        ({"bus": "USB"}, "BusType"),
        ({"analog_in": None, "analog_out": None, "ports": ()}, "neither inputs"),
        ({"ports": (DigitalPort(0),)}, r"ports\[0\].lines = 0"),
        ({"ports": (DigitalPort(4, inputs=False, outputs=False),)}, "neither inputs nor outputs"),
        ({"in": {"channels": 0}}, "analog_in.channels = 0"),
        ({"in": {"ranges_V": (5.0, 1.0)}}, "smallest first"),
        ({"in": {"ranges_V": (-1.0, 5.0)}}, "above 0"),
        ({"in": {"noise_V": (1e-6,)}}, "one value, 0 or more, for each range"),
        ({"in": {"min_rate_hz": 1e9}}, "min_rate_hz < max_rate_hz"),
        ({"in": {"max_multi_rate_hz": 1e9}}, "max_multi_rate_hz"),
        ({"in": {"fifo_samples": 0}}, "fifo_samples"),
        ({"in": {"resolution_bits": 24}}, "resolution_bits = 24 must be 8 to 16"),
        ({"in": {"terminals": ()}}, "terminals"),
        ({"in": {"terminals": (Terminals.DIFFERENTIAL,)}}, "pair_offset"),
        ({"out": {"max_rate_hz": None}}, "max_rate_hz"),
        ({"out": {"ranges_V": ()}}, "analog_out.ranges_V"),
    ],
)
def test_what_is_wrong_with_a_board_is_said(wrong: Any, said: str) -> None:
    board: Any = wrong
    if isinstance(wrong, dict):
        good = BOARDS["USB-6211"]
        changes = {k: v for k, v in wrong.items() if k not in ("in", "out")}
        if "in" in wrong:
            changes["analog_in"] = replace(good.analog_in, **wrong["in"])
        if "out" in wrong:
            changes["analog_out"] = replace(good.analog_out, **wrong["out"])
        board = replace(good, **changes)
    assert any(re.search(said, sentence) for sentence in faults(board)), faults(board)


# ----------------------------------------------------------------------------- what they report


@pytest.mark.parametrize("model", sorted(BOARDS))
def test_a_board_reports_its_data(board_server: Any, model: str) -> None:
    device, board = board_server(model).system.devices["Dev1"], BOARDS[model]
    assert device.product_type == model
    assert device.product_category is board.category
    assert device.bus_type is board.bus
    inputs, outputs = board.analog_in, board.analog_out
    assert len(device.ai_physical_chans) == (inputs.channels if inputs else 0)
    assert len(device.ao_physical_chans) == (outputs.channels if outputs else 0)
    assert len(device.di_lines) == sum(p.lines for p in board.ports if p.inputs)
    assert len(device.do_lines) == sum(p.lines for p in board.ports if p.outputs)
    if inputs:
        assert device.ai_voltage_rngs[1::2] == list(inputs.ranges_V)
        assert device.ai_max_single_chan_rate == inputs.max_rate_hz
        assert device.ai_max_multi_chan_rate == inputs.max_multi_rate_hz
    if outputs:
        assert device.ao_voltage_rngs[1::2] == list(outputs.ranges_V)
        assert device.ao_samp_clk_supported is outputs.clocked
    if outputs and outputs.clocked:
        assert device.ao_max_rate == outputs.max_rate_hz


def test_the_6363_and_the_6211_have_the_values_of_their_specifications() -> None:
    x, m = BOARDS["PCIe-6363"], BOARDS["USB-6211"]
    assert (x.category, x.bus) == (ProductCategory.X_SERIES_DAQ, BusType.PCIE)
    assert (x.analog_in.channels, x.analog_out.channels) == (32, 4)
    assert (x.analog_in.max_rate_hz, x.analog_in.max_multi_rate_hz) == (2e6, 1e6)
    assert x.analog_in.ranges_V == (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
    assert x.analog_out.ranges_V == (5.0, 10.0)
    assert x.analog_out.max_rate_hz == pytest.approx(2.86e6, rel=1e-2)
    assert [p.buffered for p in x.ports] == [True, False, False]
    assert sum(p.lines for p in x.ports) == 48
    assert (m.category, m.bus) == (ProductCategory.M_SERIES_DAQ, BusType.USB)
    assert (m.analog_in.channels, m.analog_out.channels) == (16, 2)
    assert (m.analog_in.max_rate_hz, m.analog_in.max_multi_rate_hz) == (250e3, 250e3)
    assert m.analog_in.ranges_V == (0.2, 1.0, 5.0, 10.0)
    assert m.analog_out.ranges_V == (10.0,)
    assert [(p.lines, p.inputs, p.outputs) for p in m.ports] == [(4, True, False), (4, False, True)]


# ------------------------------------------------------------------------- what they take, refuse


@pytest.mark.parametrize("model", WITH_INPUTS)
def test_every_range_of_the_inputs_is_taken_and_a_wider_one_refused(
    board_server: Any, model: str
) -> None:
    ni, ranges_V = board_server(model), BOARDS[model].analog_in.ranges_V
    for range_V in ranges_V:
        assert ni.input("Dev1/ai0", limit=0.99 * range_V).ai_channels[0].ai_max == range_V
    with refused(-200077):
        ni.input("Dev1/ai0", limit=1.01 * ranges_V[-1]).ai_channels[0].ai_max  # noqa: B018


@pytest.mark.parametrize("model", WITH_OUTPUTS)
def test_a_voltage_beyond_the_outputs_range_or_limits_is_refused_and_not_written(
    board_server: Any, model: str
) -> None:
    ni, widest_V = board_server(model), BOARDS[model].analog_out.ranges_V[-1]
    with refused(-200077):
        ni.output("Dev1/ao0", limit=1.01 * widest_V).start()
    output = ni.output("Dev1/ao0", limit=1.0)
    output.write(0.5)
    with refused(-200561):
        output.write(1.5)
    if BOARDS[model].analog_in:
        assert ni.input("Dev1/ai0").read() == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize("model", WITH_OUTPUTS)
def test_an_output_has_the_steps_of_the_smallest_range_that_holds_its_limits(
    make_ni: Any, model: str
) -> None:
    written: list[float] = []

    class Listener:
        def write(self, device: str, channel: str, volts: float, when: float) -> None:
            written.append(volts)

        def read(self, device: str, channel: str, times: np.ndarray) -> np.ndarray:
            return np.zeros(len(times))

    ni = make_ni(tcp=False, bench=Listener(), devices={"Dev1": model})
    side = BOARDS[model].analog_out
    for range_V in side.ranges_V:
        task = ni.output("Dev1/ao0", limit=0.9 * range_V)
        assert task.ao_channels[0].ao_dac_rng_high == range_V
        task.write(0.8 * 2 * range_V / 2**side.resolution_bits)
        task.close()
    assert written == pytest.approx([2 * r / 2**side.resolution_bits for r in side.ranges_V])


@pytest.mark.parametrize("model", WITH_INPUTS)
def test_samples_are_read_at_the_rates_of_the_board_and_faster_ones_refused(
    board_server: Any, model: str
) -> None:
    ni, side = board_server(model), BOARDS[model].analog_in
    one, two = ni.input("Dev1/ai0"), ni.input("Dev1/ai0:1")
    one.timing.cfg_samp_clk_timing(side.max_rate_hz, samps_per_chan=20)
    assert one.timing.samp_clk_rate == pytest.approx(side.max_rate_hz)
    assert len(one.read(20)) == 20
    both_hz = side.max_multi_rate_hz / (1 if side.simultaneous else 2)
    two.timing.cfg_samp_clk_timing(both_hz, samps_per_chan=20)
    assert np.shape(two.read(20)) == (2, 20)
    for task, rate_hz in ((one, 1.01 * side.max_rate_hz), (two, 1.02 * both_hz)):
        task.timing.cfg_samp_clk_timing(rate_hz)
        with refused(-200077):
            task.start()


@pytest.mark.parametrize("model", [m for m in WITH_INPUTS if BOARDS[m].analog_in.pair_offset])
def test_the_second_terminal_of_a_pair_is_not_differential(board_server: Any, model: str) -> None:
    ni = board_server(model)
    pair = TerminalConfiguration.DIFF
    assert ni.input("Dev1/ai0", terminal_config=pair).read() == pytest.approx(0.0, abs=1e-3)
    with refused(-200077):
        ni.input("Dev1/ai8", terminal_config=pair).read()


@pytest.mark.parametrize("model", sorted(BOARDS))
def test_channels_that_a_board_has_not_are_refused(board_server: Any, model: str) -> None:
    ni, board = board_server(model), BOARDS[model]
    inputs = board.analog_in.channels if board.analog_in else 0
    outputs = board.analog_out.channels if board.analog_out else 0
    with refused(-200170):
        ni.input(f"Dev1/ai{inputs}")
    with refused(-200170):
        ni.output(f"Dev1/ao{outputs}")


@pytest.mark.parametrize("model", [m for m in WITH_INPUTS if m in WITH_OUTPUTS])
def test_one_board_puts_out_and_reads_back(board_server: Any, model: str) -> None:
    ni = board_server(model)
    output, signal = ni.output("Dev1/ao0", limit=0.25), ni.input("Dev1/ai0", limit=0.2)
    signal.timing.cfg_samp_clk_timing(1000, sample_mode=AcquisitionType.CONTINUOUS)
    output.start()
    signal.start()  # output and inputs of one board do not exclude each other
    output.write(0.125)
    ni.pass_time(0.01)
    assert signal.read(-1)[-1] == pytest.approx(0.125, abs=2e-4)
    with refused(-50103):
        ni.input("Dev1/ai1").start()


@pytest.mark.parametrize(
    ("model", "left_V"), [("PCI-6703", 2.0), ("PCIe-6363", 0.0), ("USB-6211", 0.0)]
)
def test_a_reset_leaves_the_voltage_only_where_the_board_does(
    make_ni: Any, model: str, left_V: float
) -> None:
    devices = {"Dev1": model, "In": "PCI-6034E"}
    ni = make_ni(tcp=False, bench=LoopbackWires([("Dev1/ao0", "In/ai0")]), devices=devices)
    ni.output("Dev1/ao0").write(2.0)
    ni.system.devices["Dev1"].reset_device()
    assert ni.input("In/ai0").read() == pytest.approx(left_V, abs=2e-3)


@pytest.mark.parametrize(
    ("model", "line", "code"),
    [("PCIe-6363", "port0/line0", None), ("PCIe-6363", "port1/line0", -200077)],
)
def test_timing_of_digital_lines_is_refused_where_the_port_is_static(
    make_ni: Any, model: str, line: str, code: int | None
) -> None:
    task = make_ni(tcp=False, devices={"Dev1": model}).task()
    task.do_channels.add_do_chan(f"Dev1/{line}")
    task.timing.cfg_samp_clk_timing(1000)
    if code is None:  # the board can, the simulator does not
        with pytest.raises(RpcError, match="UNIMPLEMENTED"):
            task.start()
    else:
        with refused(code):
            task.start()


# --------------------------------------------------------------------------- another's board

SIMULTANEOUS = """
from nidaqmx.constants import BusType, ProductCategory
from sim_hardware.ni.boards.contract import AnalogInputs, BoardModel, Terminals

BOARD = BoardModel(
    product_type="USB-1234",
    product_number=None,
    category=ProductCategory.S_SERIES_DAQ,
    bus=BusType.USB,
    analog_in=AnalogInputs(
        channels=4,
        ranges_V=(1.0, 10.0),
        noise_V=(0.0, 0.0),
        max_rate_hz=1e6,
        max_multi_rate_hz=1e6,
        min_rate_hz=1.0,
        timebase_hz=100e6,
        fifo_samples=100,
        resolution_bits=12,
        terminals=(Terminals.DIFFERENTIAL,),
        pair_offset=0,
        simultaneous=True,
    ),
)
WRONG = BoardModel(
    product_type="USB-0",
    product_number=None,
    category=ProductCategory.S_SERIES_DAQ,
    bus=BusType.USB,
)
"""


def install(where: Path, point: str) -> None:
    (where / "boards_of_others.py").write_text(SIMULTANEOUS)
    info = where / "boards_of_others-1.2.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: boards-of-others\nVersion: 1.2\n")
    (info / "entry_points.txt").write_text(f"[labrig.simulated_boards]\n{point}\n")


@pytest.fixture
def others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path
    sys.modules.pop("boards_of_others", None)


def test_a_board_of_another_distribution_is_simulated_without_a_line_changed(
    others: Path, make_ni: Any
) -> None:
    install(others, "usb_1234 = boards_of_others:BOARD")
    assert FOLDER.origins() == {"usb_1234": "boards-of-others 1.2"}
    times: list[np.ndarray] = []

    class Ramp:
        def write(self, device: str, channel: str, volts: float, when: float) -> None: ...

        def read(self, device: str, channel: str, at: np.ndarray) -> np.ndarray:
            times.append(at)
            return at

    ni = make_ni(tcp=False, bench=Ramp(), devices={"Dev1": "USB-1234"})
    device = ni.system.devices["Dev1"]
    assert device.ai_simultaneous_sampling_supported
    task = ni.input("Dev1/ai0:3")
    assert task.ai_channels["Dev1/ai3"].ai_term_cfg is TerminalConfiguration.DIFF
    assert task.ai_channels["Dev1/ai0"].ai_resolution == 12
    task.timing.cfg_samp_clk_timing(1e6, samps_per_chan=3)  # of four channels: one converter each
    samples = np.array(task.read(3))
    assert all(np.array_equal(times[0], at) for at in times)
    assert np.all(samples % (20.0 / 2**12) == 0)
    with refused(-200077):
        ni.input("Dev1/ai0", terminal_config=TerminalConfiguration.RSE).start()


def test_a_board_that_breaks_the_contract_is_left_out_with_a_sentence(others: Path) -> None:
    install(others, "usb_0 = boards_of_others:WRONG")
    with pytest.warns(PluginWarning, match="'usb_0'.*neither inputs, outputs nor ports"):
        assert set(board_models()) == set(BOARDS)


def test_the_contract_has_defaults_only_for_what_most_boards_share() -> None:
    inputs = AnalogInputs(
        channels=16,
        ranges_V=(10.0,),
        noise_V=(1e-3,),
        max_rate_hz=1e4,
        max_multi_rate_hz=1e4,
        min_rate_hz=1.0,
        timebase_hz=1e6,
        fifo_samples=10,
    )
    outputs = AnalogOutputs(channels=1, ranges_V=(10.0,), clocked=False)
    board = BoardModel(
        product_type="A-1",
        product_number=1,
        category=ProductCategory.UNKNOWN,
        bus=BusType.UNKNOWN,
        analog_in=inputs,
        analog_out=outputs,
    )
    assert faults(board) == []
