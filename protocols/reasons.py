"""Many reasons in few words: those that differ in their numbers alone are one, with their range."""

from __future__ import annotations

import re
from collections.abc import Iterable

_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?")


def alike(reasons: Iterable[str]) -> list[list[str]]:
    """Return the reasons in groups that differ in their numbers alone."""
    groups: dict[str, list[str]] = {}
    for reason in reasons:
        groups.setdefault(_NUMBER.sub("\0", reason), []).append(reason)
    return list(groups.values())


def in_short(reasons: Iterable[str]) -> str:
    """Return each reason once: "its edge came 5.1 to 15.5 ms late (limit 5 ms); no frame came".

    One that consists of several, with semicolons, is taken apart.
    """
    parts = (part for reason in reasons for part in reason.split("; "))
    return "; ".join(_as_one(group) for group in alike(parts))


def _as_one(group: list[str]) -> str:
    """Return reasons that differ in their numbers alone as one, with the range of each number."""
    words = _NUMBER.sub("\0", group[0])
    for values in zip(*map(_NUMBER.findall, group), strict=True):
        low, high = min(values, key=float), max(values, key=float)
        words = words.replace("\0", low if low == high else f"{low} to {high}", 1)
    return words
