"""Run one of NI's examples as it is, its tasks on a simulated server: FILE ADDRESS."""

from __future__ import annotations

import builtins
import runpy
import sys
import threading
import time
from _thread import interrupt_main
from typing import Any

import grpc
import nidaqmx

# An example that waits for Enter gets it, one that runs until Ctrl-C gets that.
ENTER_AFTER_S, CTRL_C_AFTER_S = 3.0, 8.0


def _press_enter(*_: object) -> str:
    time.sleep(ENTER_AFTER_S)  # noqa: TID251 - a person waits
    return ""


def main(file: str, address: str) -> None:
    """Give every task the address in place of the driver of this computer."""
    options = nidaqmx.GrpcSessionOptions(grpc.insecure_channel(address), "")
    begin = nidaqmx.Task.__init__

    def begin_there(self: nidaqmx.Task, name: str = "", **more: Any) -> None:
        begin(self, name, **{"grpc_options": options, **more})

    vars(builtins)["input"] = _press_enter
    setattr(nidaqmx.Task, "__init__", begin_there)  # noqa: B010 - for the type checker
    ctrl_c = threading.Timer(CTRL_C_AFTER_S, interrupt_main)
    ctrl_c.daemon = True
    ctrl_c.start()
    runpy.run_path(file, run_name="__main__")


if __name__ == "__main__":
    main(*sys.argv[1:])
