"""What the server tells of itself and of its boards."""

from __future__ import annotations

from typing import Any

import grpc
import pytest
import session_pb2
import session_pb2_grpc
from nidaqmx.constants import (
    AcquisitionType,
    BusType,
    ProductCategory,
    TerminalConfiguration,
    UsageTypeAI,
)
from nidaqmx.stream_readers import AnalogSingleChannelReader

from sim_hardware.ni import NiDeviceServer, board_models


def test_the_boards_are_listed(ni: Any) -> None:
    found = {device.name: device.product_type for device in ni.system.devices}
    assert found == {
        "PCI6703": "PCI-6703",
        "PCI6034E": "PCI-6034E",
        "X": "PCIe-6363",
        "M": "USB-6211",
    }
    assert len({device.serial_num for device in ni.system.devices}) == 4
    assert all(device.is_simulated for device in ni.system.devices)


def test_the_6034e_tells_what_it_can(ni: Any) -> None:
    board = ni.system.devices["PCI6034E"]
    assert board.product_category is ProductCategory.E_SERIES_DAQ
    assert board.bus_type is BusType.PCI
    assert board.ai_max_single_chan_rate == board.ai_max_multi_chan_rate == 200e3
    assert not board.ai_simultaneous_sampling_supported
    assert board.ai_voltage_rngs == [-0.05, 0.05, -0.5, 0.5, -5.0, 5.0, -10.0, 10.0]
    assert [channel.name for channel in board.ai_physical_chans] == [
        f"PCI6034E/ai{k}" for k in range(16)
    ]
    assert list(board.ao_physical_chans) == []
    assert board.ai_physical_chans["ai0"].ai_meas_types == [UsageTypeAI.VOLTAGE]


def test_the_6703_tells_what_it_can(ni: Any) -> None:
    board = ni.system.devices["PCI6703"]
    assert board.product_category is ProductCategory.AO_SERIES
    assert len(board.ao_physical_chans) == 16
    assert list(board.ai_physical_chans) == []
    assert board.ao_voltage_rngs == [-10.0, 10.0]
    assert not board.ao_samp_clk_supported
    assert len(board.do_lines) == 8
    assert [port.name for port in board.do_ports] == ["PCI6703/port0"]


def test_lines_of_the_6211_have_a_direction(ni: Any) -> None:
    board = ni.system.devices["M"]
    assert [line.name for line in board.di_lines] == [f"M/port0/line{k}" for k in range(4)]
    assert [line.name for line in board.do_lines] == [f"M/port1/line{k}" for k in range(4)]


def test_half_the_inputs_can_be_differential(ni: Any) -> None:
    board = ni.system.devices["PCI6034E"]
    assert TerminalConfiguration.DIFF in board.ai_physical_chans["ai7"].ai_term_cfgs
    assert TerminalConfiguration.DIFF not in board.ai_physical_chans["ai8"].ai_term_cfgs
    pairs = [
        channel.name
        for channel in ni.system.devices["X"].ai_physical_chans
        if TerminalConfiguration.DIFF in channel.ai_term_cfgs
    ]
    assert pairs == [f"X/ai{k}" for k in (*range(8), *range(16, 24))]


@pytest.mark.parametrize("model", sorted(board_models()))
def test_every_board_of_the_table_self_tests_and_resets(make_ni: Any, model: str) -> None:
    rig = make_ni(tcp=False, devices={"Dev1": model})
    device = rig.system.devices["Dev1"]
    device.self_test_device()
    device.reset_device()
    assert device.product_type == model


def test_device_names_are_found_whatever_their_case(ni: Any) -> None:
    assert ni.input("pci6034e/AI0").ai_channels[0].physical_channel.name == "PCI6034E/ai0"


@pytest.mark.parametrize("tcp", [False, True])
@pytest.mark.parametrize("version", ["19.6", "24.5", "26.0.1"])
def test_all_available_is_read_whatever_the_drivers_version(
    make_ni: Any, tcp: bool, version: str
) -> None:
    rig = make_ni(tcp=tcp, driver_version=version)
    told = rig.system.driver_version
    parts = [*map(int, version.split(".")), 0][:3]
    assert [told.major_version, told.minor_version, told.update_version] == parts
    finite, continuous = rig.input(), rig.input()
    finite.timing.cfg_samp_clk_timing(10_000, samps_per_chan=40)
    assert len(finite.read(-1)) == 40
    continuous.timing.cfg_samp_clk_timing(1000, sample_mode=AcquisitionType.CONTINUOUS)
    continuous.start()
    rig.pass_time(0.05)
    assert 50 <= len(continuous.read(-1)) < 200
    continuous.stop()
    on_demand = rig.input()
    reader = AnalogSingleChannelReader(on_demand.in_stream)
    assert reader.read_one_sample() == pytest.approx(0.0, abs=2e-3)


@pytest.mark.parametrize("version", ["", "19.x", "1.2.3.4", "-1"])
def test_a_version_that_is_none_is_refused(version: str) -> None:
    with pytest.raises(ValueError, match="is not a driver version"):
        NiDeviceServer(None, None, driver_version=version)  # type: ignore[arg-type]


def test_a_board_that_is_not_simulated_is_refused() -> None:
    with pytest.raises(ValueError, match="PCI-6034E"):
        NiDeviceServer(None, None, {"Dev1": "PCI-9999"})  # type: ignore[arg-type]


@pytest.mark.slow
def test_the_servers_own_service_lists_and_resets(make_ni: Any) -> None:
    rig = make_ni(tcp=True)
    utilities = session_pb2_grpc.SessionUtilitiesStub(rig.channel)
    devices = utilities.EnumerateDevices(session_pb2.EnumerateDevicesRequest()).devices
    assert [(device.name, device.model) for device in devices][:2] == [
        ("PCI6703", "PCI-6703"),
        ("PCI6034E", "PCI-6034E"),
    ]
    assert {device.vendor for device in devices} == {"National Instruments"}
    task = rig.output()
    task.start()
    task.write(2.0)
    assert utilities.ResetServer(session_pb2.ResetServerRequest()).is_server_reset
    other = rig.output()
    other.start()  # it is free again
    assert rig.input().read() == pytest.approx(2.0, abs=2e-3)  # and the voltage stays
    with pytest.raises(grpc.RpcError) as fault:
        utilities.Reserve(session_pb2.ReserveRequest())
    assert fault.value.code() is grpc.StatusCode.UNIMPLEMENTED


def test_a_server_on_virtual_time_has_no_port(make_ni: Any) -> None:
    with pytest.raises(RuntimeError, match="in_process_channel"):
        make_ni(tcp=False).server.listen()
