"""The entry point: turns every failure into one sentence and an exit code."""

from __future__ import annotations

import os
import signal
import sys
import tempfile
import threading
import traceback
from contextlib import nullcontext
from pathlib import Path

import typer
from typer.exceptions import TyperException

from labrig.cli.app import app_for, prints_json
from labrig.cli.screen import json_alone, warn
from labrig.cli.sentences.compiling import compiling_is_told
from labrig.cli.sentences.option_names import with_options
from labrig.cli.sentences.streams import (
    leave_streams,
    open_closed_streams,
    output_takes_more,
    show_what_can_be_shown,
)
from labrig.cli.sentences.unclear_options import unclear_option
from labrig.cli.sentences.usage_errors import usage_sentence
from labrig.cli.sentences.user_warnings import shown_as_sentences
from labrig.errors import BadInputError, ExitCode, LabrigError
from labrig.files import family_of, not_written
from labrig.garbage import look_for_garbage_seldom
from labrig.own_packages import hidden


def main() -> None:
    """Run the program; end the process with a documented exit code."""
    open_closed_streams()
    try:
        code = _program()
    except KeyboardInterrupt:  # before or after the command, which tells of its own
        code = _stopped()
    leave_streams()
    sys.exit(code)


def _program() -> int:
    look_for_garbage_seldom()
    from labrig.experiment.signals import ignore_stop_signals

    show_what_can_be_shown()
    hiding = hidden()
    if hiding is not None:
        warn(f"labrig: {hiding}")
        return ExitCode.NOT_READY
    sys.unraisablehook = ignore_unraisable
    code = run(sys.argv[1:])
    ignore_stop_signals()
    if "labrig.session.recording.disk" in sys.modules:
        sys.modules["labrig.session.recording.disk"].end_before_the_library_does(code)
    return code


def _stopped() -> int:
    warn("labrig: stopped.")
    return ExitCode.STOPPED


def ignore_unraisable(unraisable: sys.UnraisableHookArgs) -> None:
    """Print nothing: the error that discards the object is reported itself.

    A Ctrl-C that came while an object was discarded, or a library's callback ran, would be lost: it
    is sent again. Not from here: what is raised in here is ignored as well.
    """
    if issubclass(unraisable.exc_type, KeyboardInterrupt):
        again = threading.Timer(0.05, signal.raise_signal, (signal.SIGINT,))
        again.daemon = True
        again.start()


def run(arguments: list[str]) -> int:
    """Run one command and return its exit code."""
    with shown_as_sentences(), compiling_is_told():
        return _run(arguments)


def _run(arguments: list[str]) -> int:
    try:
        app = app_for(arguments)
        if said := unclear_option(app, arguments):
            raise BadInputError(said)
        with json_alone() if prints_json(arguments) else nullcontext():
            result = app.main(arguments, prog_name="labrig", standalone_mode=False)
        sys.stdout.flush()
    except TyperException as error:
        if type(error).__name__ == "NoArgsIsHelpError":  # of a group: its help is its message
            error.show()  # type: ignore[attr-defined]  # all of those that typer raises have it
        else:
            warn(f"labrig: {usage_sentence(error, arguments)}")
        return ExitCode.BAD_INPUT
    except (KeyboardInterrupt, typer.Abort):
        return _stopped()
    except LabrigError as error:
        warn(f"labrig: {with_options(error)}")
        return error.code
    except BrokenPipeError:
        return ExitCode.DONE  # the reader of a pipe (head, less) has gone: nothing is wrong
    except OSError as error:
        return _report_system(error)
    except SystemExit as error:
        return _report_exit(error)
    except Exception as error:  # noqa: BLE001 - a user never sees a traceback
        return _report_fault(error)
    return int(result or 0)


def _is_foreign(error: BaseException) -> bool:
    """Whether a part of another distribution raised it: the program is not its own to end."""
    from labrig.foreign_code import foreign_place  # reads what is installed

    return foreign_place(error) is not None


def _report_exit(error: SystemExit) -> int:
    if isinstance(error.__context__, BrokenPipeError):  # typer's answer to it
        return ExitCode.DONE
    if not _is_foreign(error):
        raise error
    return _report_fault(error)


def _report_system(error: OSError) -> int:
    """Tell what the system has refused."""
    if error.filename is None and not output_takes_more():
        refused = not_written(Path("standard output"), error)
        warn(f"labrig: {refused}")
        return refused.code
    if error.filename is None and isinstance(error, FileNotFoundError):  # of `os.getcwd`
        warn("labrig: the folder you are in has been removed; change to another.")
        return ExitCode.BAD_INPUT
    warn(f"labrig: {error.filename or 'writing'}: {error.strerror or error}.")
    return family_of(error).code


def _report_fault(error: BaseException) -> int:
    from drivers.interfaces import DeviceError
    from labrig.foreign_code import foreign_place  # reads what is installed
    from model.measurements import ModelError

    if isinstance(error, ModelError):
        warn(f"labrig: {str(error).rstrip('.')}.")
        return ExitCode.BAD_INPUT
    if isinstance(error, DeviceError):
        warn(f"labrig: {error}")
        return ExitCode.NOT_READY
    handle, name = tempfile.mkstemp(prefix="labrig-fault-", suffix=".txt", text=True)
    with os.fdopen(handle, "w", encoding="utf-8") as file:
        traceback.print_exception(error, file=file)
    place = foreign_place(error)
    said = "this should not have happened" if place is None else f"{place} failed"
    whom = "" if place is None else " to its authors"
    warn(
        f"labrig: {said} ({type(error).__name__}: {error}); "
        f"please report it{whom} with {Path(name)}."
    )
    return ExitCode.FAILED
