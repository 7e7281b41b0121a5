"""0 V at the boards, when the operator's computer is gone."""

from __future__ import annotations

import threading
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.options import RigFile
from labrig.cli.screen import say
from labrig.errors import BadInputError, NotReadyError

_LOOK_S = 0.2  # Windows wakes no thread for Ctrl-C


def watch(
    rig: RigFile,
    listen: Annotated[
        str, typer.Option("--listen", help="address:port to listen on; 0.0.0.0: every network")
    ] = "0.0.0.0:31764",
    token: Annotated[
        Path | None,
        typer.Option(
            "--token",
            help="the secret shared with the operator's computer; made where it is missing "
            "(default: watch.token beside rig.toml)",
        ),
    ] = None,
) -> None:
    """Write 0 V at the boards when the operator's computer dies.

    It runs on the computer that has the boards, until Ctrl-C.

    `labrig run` on the operator's computer sends a heartbeat here ([watch] in its rig.toml). When
    that stops while the sheet is energised - the computer is down, the cable is cut, every labrig
    there is killed - 0 V is written and read back, within 1 s. `rig` says how the boards are
    reached from here; wiring, amplifier and limits must be those of the operator's rig.toml.
    """
    from drivers.interfaces import DeviceError
    from labrig.experiment.precautions.boards_watch import boards_watch, made_token, watched_rig
    from labrig.experiment.signals import stop_signals

    host, found, port = listen.rpartition(":")
    if not found or not port.isdecimal() or int(port) > 65535:
        raise BadInputError(f"--listen {listen}: must be address:port, such as 0.0.0.0:31764.")
    secret = token or rig.parent / "watch.token"
    config = watched_rig(rig)
    if made_token(secret):
        say(f"made {secret}: copy it beside the operator's rig.toml, for nobody else to read.")
    guard = boards_watch(config, secret, _tell)
    try:
        at = guard.listen(host, int(port))
    except DeviceError as fault:
        guard.stop()
        raise NotReadyError(str(fault)) from fault
    end = threading.Event()
    with stop_signals(lambda _name, _count: end.set()):
        _tell(f"listening on {host}:{at}; Ctrl-C ends it.")
        while not end.wait(_LOOK_S):
            pass
    guard.stop()
    _tell("ended.")


def _tell(text: str) -> None:
    """Say it; it watches on when its reader is gone or the disk of its log is full."""
    with suppress(OSError):
        say(f"watch: {text}")


COMMAND = Command(
    "watch",
    watch,
    order=72,
    # The rig of the examples is a simulated one.
    examples=(CommandExample(line="labrig watch rig/rig.toml", exit_code=2),),
)
