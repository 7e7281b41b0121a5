"""Channel lists as NI-DAQmx writes them: `Dev1/ai0:3, Dev1/ai7`."""

from __future__ import annotations

import re
from collections.abc import Sequence

from sim_hardware.ni.errors import Code, StatusError

_RANGE = re.compile(r"^(.*?)(\d+):(.*?)(\d+)$")
_MOST = 15000


def split_list(text: str) -> list[str]:
    """Return the single names in a list, ranges written out."""
    names: list[str] = []
    for part in (part.strip() for part in text.split(",")):
        if part:
            names.extend(_expand(part))
    return names


def split_some(text: str) -> list[str]:
    """Return the same for a list that must not be empty; -200170 when it is."""
    names = split_list(text)
    if not names:
        raise StatusError(Code.NO_SUCH_CHANNEL, "No channel is named.")
    return names


def join_list(names: Sequence[str]) -> str:
    """Return the list of these names, as the driver answers it."""
    return ", ".join(names)


def split_device(name: str) -> tuple[str, str]:
    """`/Dev1/ai0` or `Dev1/ai0` -> `Dev1`, `ai0`; `Dev1` -> `Dev1`, an empty string."""
    device, _, channel = name.lstrip("/").partition("/")
    return device, channel


def _expand(part: str) -> list[str]:
    if ":" not in part:
        return [part]
    match = _RANGE.match(part)
    if match is None or match[3] not in ("", match[1]):
        raise StatusError(Code.RANGE_SYNTAX, f"Name: {part}")
    first, last = int(match[2]), int(match[4])
    if abs(last - first) >= _MOST:
        raise StatusError(Code.RANGE_SYNTAX, f"Name: {part}")
    step = 1 if last >= first else -1
    return [f"{match[1]}{number}" for number in range(first, last + step, step)]
