"""`python -m sim_hardware serve`: what it prints, what answers, how it ends."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import grpc
import nidaqmx
import numpy as np
import pytest
from nidaqmx.system import System

from sim_hardware.serve import main
from tests.cases import few
from tests.processes import last_words

POSIX = os.name == "posix"


class Served:
    """A running `serve`, and the addresses it printed."""

    def __init__(self, arguments: tuple[str, ...]) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "sim_hardware", "serve", *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert self.process.stdout is not None
        self.lines: list[str] = []
        for line in self.process.stdout:
            self.lines.append(line.strip())
            if self.lines[-1] == "ready":
                break
        self.addresses = dict(line.split("=", 1) for line in self.lines if "=" in line)

    def options(self, name: str = "") -> nidaqmx.GrpcSessionOptions:
        return nidaqmx.GrpcSessionOptions(grpc.insecure_channel(self.addresses["grpc"]), name)

    def end(self, number: int = signal.SIGTERM) -> tuple[int, str]:
        """Exit code and standard error."""
        self.process.send_signal(number)
        _, errors = self.process.communicate(timeout=10)
        return self.process.returncode, errors


@pytest.fixture
def serve() -> Iterator[Callable[..., Served]]:
    with ExitStack() as stack:

        def start(*arguments: str) -> Served:
            served = Served(arguments)
            stack.callback(_kill, served.process)
            return served

        yield start


def _kill(process: Any) -> None:
    if process.poll() is None:
        process.kill()
        last_words(process)


@pytest.mark.slow
@pytest.mark.skipif(not POSIX, reason="meter and stage need pseudo-terminals")
@pytest.mark.parametrize("number", few([signal.SIGTERM, signal.SIGINT]))
def test_a_whole_rig_is_served_until_it_is_told_to_end(
    serve: Any, tmp_path: Path, number: int
) -> None:
    record = tmp_path / "record.csv"
    served = serve("--record", str(record), "--configuration", "short", "--seed", "5")
    assert [line.split("=")[0] for line in served.lines] == [
        "grpc",
        "camera",
        "meter",
        "stage",
        "ready",
    ]
    assert served.addresses["camera"].startswith("http://127.0.0.1:")
    assert Path(served.addresses["meter"]).exists()
    assert Path(served.addresses["stage"]).exists()
    with nidaqmx.Task("out", grpc_options=served.options("out")) as task:
        task.ao_channels.add_ao_voltage_chan("PCI6703/ao0", min_val=-0.25, max_val=0.25)
        task.write(0.2)
    with nidaqmx.Task("in", grpc_options=served.options("in")) as task:
        task.ai_channels.add_ai_voltage_chan("PCI6034E/ai2", min_val=-5, max_val=5)
        assert task.read() == pytest.approx(2.0, abs=0.05)  # ten times as much at the sheet
    rows = record.read_text().splitlines()  # while it runs: each row is flushed
    assert rows[0] == "time_s,drive_V,force_mN,position_mm"
    assert any(abs(float(row.split(",")[1]) - 2.0) < 0.01 for row in rows[1:])
    assert served.end(number) == (0, "")


@pytest.mark.thorough
@pytest.mark.slow
def test_a_moving_world_is_served_and_its_current_decays_while_the_voltage_stays(
    serve: Any,
) -> None:
    served = serve("--world", "moving.toml", "--configuration", "long", "--serial", "zaber")
    with (
        nidaqmx.Task("out", grpc_options=served.options("out")) as output,
        nidaqmx.Task("in", grpc_options=served.options("in")) as current,
    ):
        output.ao_channels.add_ao_voltage_chan("PCI6703/ao0", min_val=-0.25, max_val=0.25)
        current.ai_channels.add_ai_voltage_chan("PCI6034E/ai1", min_val=-0.5, max_val=0.5)
        current.timing.cfg_samp_clk_timing(1000.0, samps_per_chan=1000)
        output.write(0.0)
        current.start()
        output.write(0.2)
        mA = np.array(current.read(1000, timeout=20.0)) * 1e3
    assert 20.0 < mA.max() < 46.0
    assert 8.0 < mA[-1] < 0.7 * mA.max()


@pytest.mark.slow
@pytest.mark.parametrize("model", few(["PCIe-6363", "USB-6211"]))
def test_a_rig_with_one_board_is_served(serve: Any, model: str) -> None:
    served = serve("--device", f"Dev1={model}", "--serial", "zaber", "--configuration", "short")
    assert [line.split("=")[0] for line in served.lines] == ["grpc", "camera", "stage", "ready"]
    (device,) = System.remote(served.options()).devices
    assert device.product_type == model
    with (
        nidaqmx.Task("out", grpc_options=served.options("out")) as output,
        nidaqmx.Task("in", grpc_options=served.options("in")) as signal_in,
    ):
        output.ao_channels.add_ao_voltage_chan("Dev1/ao0", min_val=-0.25, max_val=0.25)
        signal_in.ai_channels.add_ai_voltage_chan("Dev1/ai2", min_val=-5, max_val=5)
        output.write(0.2)
        assert signal_in.read() == pytest.approx(2.0, abs=0.05)  # the amplifier is wired to it
        output.write(0.0)
        assert signal_in.read() == pytest.approx(0.0, abs=0.05)


@pytest.mark.slow
def test_a_wire_needs_no_world(serve: Any) -> None:
    served = serve("--wire", "ao0:ai0", "--wire", "M/ao1:M/ai3", "--driver-version", "19.6",
                   "--device", "PCI6703=PCI-6703", "--device", "PCI6034E=PCI-6034E",
                   "--device", "M=USB-6211")  # fmt: skip
    assert [line.split("=")[0] for line in served.lines] == ["grpc", "ready"]
    system = System.remote(served.options())
    assert system.driver_version.major_version == 19
    assert [device.name for device in system.devices] == ["PCI6703", "PCI6034E", "M"]
    with nidaqmx.Task(grpc_options=served.options()) as task:
        task.ao_channels.add_ao_voltage_chan("PCI6703/ao0")
        task.write(1.5)
    with nidaqmx.Task(grpc_options=served.options()) as task:
        task.ai_channels.add_ai_voltage_chan("PCI6034E/ai0")
        assert task.read() == pytest.approx(1.5, abs=2e-3)
    if POSIX:
        assert served.end() == (0, "")


@pytest.mark.slow
@pytest.mark.skipif(not POSIX, reason="ends by a signal")
def test_it_ends_at_once_while_clients_listen_and_wait(serve: Any) -> None:
    served = serve("--wire", "ao0:ai0", "--strict-ownership")
    task = nidaqmx.Task("in", grpc_options=served.options("in"))
    task.ai_channels.add_ai_voltage_chan("PCI6034E/ai0")
    task.timing.cfg_samp_clk_timing(1000, sample_mode=nidaqmx.constants.AcquisitionType.CONTINUOUS)
    task.register_every_n_samples_acquired_into_buffer_event(100, lambda *_: 0)
    task.start()
    code, errors = served.end()
    assert code == 0
    assert "Traceback" not in errors
    with pytest.raises(nidaqmx.errors.RpcError):
        task.close()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "required"),
        (["measure"], "invalid choice"),
        (["serve", "--port", "99999"], "is not a port"),
        (["serve", "--wire", "ao0"], "OUTPUT:INPUT"),
        (["serve", "--device", "PCI6703"], "NAME=MODEL"),
        (["serve", "--wire", "ao0:ai0", "--device", "A=PCI-1"], "no simulated board 'PCI-1'"),
        (["serve", "--wire", "ao0:ai0", "--driver-version", "x"], "not a driver version"),
        (["serve", "--wire", "ao0:ai0", "--record", "r.csv"], "--record has no meaning"),
        (["serve", "--world", "nowhere.toml"], "nowhere.toml"),
        (["serve", "--wire", "ao0:ai0", "--serial", "zaber"], "--serial has no meaning"),
        (["serve", "--serial", "oven"], "no simulated serial device 'oven'"),
        (["serve", "--device", "Dev1=USB-6212"], "no simulated board 'USB-6212'"),
        (["serve", "--configuration", "medium"], "medium"),
        (["serve", "--record", "no/such/folder/r.csv"], "cannot be written"),
    ],
)
def test_bad_arguments_are_one_sentence_and_exit_2(
    arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert words in printed.err
    assert printed.err.count("\n") == 1
    assert "Traceback" not in printed.err


@pytest.mark.slow
@pytest.mark.parametrize("flag", ["--port", "--camera-port"])
def test_a_port_that_is_taken_exits_3(flag: str, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert main(["serve", flag, str(port)]) == 3
    assert str(port) in capsys.readouterr().err


def test_help_is_help(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["serve", "--help"])
    assert end.value.code == 0
    assert "--strict-ownership" in capsys.readouterr().out
