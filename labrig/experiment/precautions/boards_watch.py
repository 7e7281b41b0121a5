"""`labrig watch`: guard the output from the computer that has the boards."""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from drivers.guard import GuardSettings
from drivers.interfaces import DeviceError, RealClock
from drivers.watch import BoardsWatch, read_token
from labrig.config import OutputConfig, ReplayConfig, load_output
from labrig.errors import BadInputError, NotReadyError
from labrig.experiment.safety import output_place
from labrig.files import not_written

_GRACE_S = 1.0  # beyond the limit that the schedule was checked against


def made_token(path: Path) -> bool:
    """Make a secret where there is none; return whether it was made. Only its owner reads it."""
    if path.exists():
        return False
    try:
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(secrets.token_hex(32) + "\n")
    except OSError as error:
        with suppress(OSError):
            path.unlink(missing_ok=True)
        raise not_written(path, error) from None
    return True


def watched_rig(rig: Path) -> OutputConfig:
    """Return what rig.toml says of the output; BadInputError where there is nothing to watch."""
    config = load_output(rig)
    if isinstance(config, ReplayConfig) or config.is_simulated:
        raise BadInputError(f"{rig}: a simulated output ends with its program; nothing to watch.")
    if config.family.rescue is None:
        raise BadInputError(
            f"{rig}: boards of [{config.boards_kind}] cannot be made safe by another process."
        )
    return config


def boards_watch(config: OutputConfig, token: Path, tell: Callable[[str], None]) -> BoardsWatch:
    """Return the watch over the output of a rig, which does not listen yet."""
    make = config.family.rescue
    if make is None:
        raise BadInputError("these boards cannot be made safe by another process.")
    try:
        secret = read_token(token)
        place = output_place(config)
        rescue = make(place, RealClock())
    except DeviceError as fault:
        raise NotReadyError(str(fault)) from fault
    settings = GuardSettings(
        boards=config.boards_kind,
        place=place,
        time_under_voltage_s=config.limits.time_under_voltage_s + _GRACE_S,
    )
    return BoardsWatch(settings, rescue, secret, RealClock(), tell)
