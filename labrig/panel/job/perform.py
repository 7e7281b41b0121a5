"""A job, in its process: load what it will need, read the order, do it, publish how it ended."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from queue import SimpleQueue

from drivers.interfaces import DeviceError
from labrig.errors import ExitCode, LabrigError
from labrig.left_out import listen, told_of
from labrig.panel.job.host import Host
from labrig.panel.job.order import Order
from labrig.panel.job.process import print_into_log


def _work_of(order: Order) -> Callable[[Host], tuple[int, str]]:
    """Return the job's function, imported here: panels find the job before it is ready."""
    if order.kind == "run":
        from labrig.panel.job.running import run

        return run
    if order.kind == "preflight":
        from labrig.panel.job.preflight import check_rig

        return check_rig
    if order.kind == "weighing":
        from labrig.panel.job.weighing import weigh_all

        return weigh_all
    from labrig.panel.job.camera import show

    return show


def _done(host: Host) -> tuple[int, str]:
    try:
        return _work_of(host.order)(host)
    except LabrigError as error:
        return int(error.code), str(error)
    except DeviceError as error:
        return int(ExitCode.NOT_READY), str(error)
    except (Exception, SystemExit) as error:  # noqa: BLE001 - the panel must learn of it
        import traceback

        traceback.print_exc()  # into the panel's job.log
        return int(ExitCode.FAILED), (
            f"this should not have happened ({type(error).__name__}: {error}); please report it "
            "with .labrig/job.log of the data folder."
        )


def _ordered(lines: SimpleQueue[str]) -> Order:
    """Wait for the order, ready for the rig that the first line names."""
    rig = json.loads(lines.get() or "null")
    if rig is not None:
        from labrig.panel.job.warm_up import warm_up

        warm_up(Path(rig))
    return Order.from_json(lines.get())


def perform(lines: SimpleQueue[str]) -> int:
    """Read the order, do it; return the exit code."""
    listen()
    order = _ordered(lines)
    print_into_log(Path(order.data))
    host = Host(order)
    code, text = int(ExitCode.FAILED), "the job was ended."
    try:
        with told_of(host.warn):
            code, text = _done(host)
    finally:
        host.end(code, text)
    return code
