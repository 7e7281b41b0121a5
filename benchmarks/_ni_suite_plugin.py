"""A pytest plugin: NI's tests reach the simulated server in place of NI's gRPC Device Server."""

from __future__ import annotations

import atexit
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Self

import grpc
import nidaqmx
import pytest
from nidaqmx.system import System

DEVICES = ("Dev1=PCIe-6363", "Dev2=USB-6211")


class SimulatedServer:
    """One server for the whole suite, with the interface of the suite's `GrpcServerProcess`."""

    def __init__(self) -> None:
        command = [sys.executable, "-m", "sim_hardware", "serve", "--end-with-input"]
        command += ["--wire", "ao3:ai31", "--test-signals"]
        for device in DEVICES:
            command += ["--device", device]
        root = Path(__file__).resolve().parents[1]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=root
        )
        atexit.register(self._process.terminate)
        line = self._process.stdout.readline() if self._process.stdout else ""
        self.server_port = int(line.rpartition(":")[2])

    def __enter__(self) -> Self:
        """See the suite's `GrpcServerProcess`."""
        return self

    def __exit__(self, *_: object) -> None:
        """It serves until the suite has ended."""


@pytest.hookimpl(tryfirst=True)
def pytest_load_initial_conftests() -> None:
    """Put the server where the suite starts NI's, before the suite's modules are imported."""
    server = SimulatedServer()
    vars(import_module("tests._grpc_utils"))["GrpcServerProcess"] = lambda: server
    # Three modules ask the local driver for its version while they are imported.
    channel = grpc.insecure_channel(f"127.0.0.1:{server.server_port}")
    remote = System.remote(grpc_options=nidaqmx.GrpcSessionOptions(channel, ""))
    setattr(System, "local", staticmethod(lambda: remote))  # noqa: B010 - for the type checker
