"""Puts the commands together, and turns every failure into one sentence and an exit code."""

from __future__ import annotations

import io
import os
import sys
import tempfile
import traceback
from pathlib import Path

import typer
from typer.exceptions import TyperException

from labrig.cli.commands import (
    calibrate,
    curves,
    demo,
    design,
    diagnose,
    evaluate,
    exchange,
    panel,
    prepare,
    record,
    sessions,
)
from labrig.cli.screen import warn
from labrig.errors import ExitCode, LabrigError
from labrig.files import family_of

app = typer.Typer(
    name="labrig",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    help="Run, record and understand force and shape experiments on ionic-polymer actuator sheets.",
)
for room in (
    demo,
    prepare,
    record,
    panel,
    sessions,
    evaluate,
    diagnose,
    design,
    curves,
    calibrate,
    exchange,
):
    room.add_to(app)


def main() -> None:
    """The program's entry point; ends the process with a documented exit code."""
    show_what_can_be_shown()
    sys.unraisablehook = _nothing_to_tell
    code = run(sys.argv[1:])
    if "labrig.session.disk" in sys.modules:
        sys.modules["labrig.session.disk"].end_before_the_library_does(code)
    sys.exit(code)


def show_what_can_be_shown() -> None:
    """Windows gives a pipe or a file its old code page, which lacks letters that names may have."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")


def _nothing_to_tell(_unraisable: object) -> None:
    """Of what is thrown away while an error is on its way; that one is told."""


def run(arguments: list[str]) -> int:
    """Run one command and return its exit code."""
    command = typer.main.get_command(app)
    try:
        result = command.main(arguments, prog_name="labrig", standalone_mode=False)
    except TyperException as error:
        error.show()  # type: ignore[attr-defined]  # all of those that typer raises have it
        return ExitCode.BAD_INPUT
    except (KeyboardInterrupt, typer.Abort):
        warn("labrig: stopped.")
        return ExitCode.STOPPED
    except LabrigError as error:
        warn(f"labrig: {error}")
        return error.code
    except BrokenPipeError:
        # The reader of a pipe (head, less) has gone: nothing is wrong.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return ExitCode.DONE
    except OSError as error:
        warn(f"labrig: {error.filename or 'writing'}: {error.strerror or error}.")
        return family_of(error).code
    except Exception as error:  # noqa: BLE001 - a person never sees a traceback
        return _report_fault(error)
    return int(result or 0)


def _report_fault(error: Exception) -> int:
    from drivers.interfaces import DeviceError
    from model.measurements import ModelError

    if isinstance(error, ModelError):
        warn(f"labrig: {error}")
        return ExitCode.BAD_INPUT
    if isinstance(error, DeviceError):
        warn(f"labrig: {error}")
        return ExitCode.NOT_READY
    handle, name = tempfile.mkstemp(prefix="labrig-fault-", suffix=".txt", text=True)
    with os.fdopen(handle, "w", encoding="utf-8") as file:
        traceback.print_exception(error, file=file)
    warn(
        f"labrig: this should not have happened ({type(error).__name__}: {error}); "
        f"please report it with {Path(name)}."
    )
    return ExitCode.FAILED
