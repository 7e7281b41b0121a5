"""Reservations: of the input side of a board, an output, a line."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Generic, TypeVar

from sim_hardware.ni.errors import Code, StatusError

Holder = TypeVar("Holder")


class Reservations(Generic[Holder]):
    """Each resource has at most one holder."""

    def __init__(self) -> None:
        self._holders: dict[str, Holder] = {}

    def reserve(self, resources: Iterable[str], holder: Holder) -> None:
        """Reserve all of them, or none: -50103 names the first that another task holds."""
        wanted = list(resources)
        for resource in wanted:
            if self._holders.get(resource, holder) is not holder:
                raise StatusError(Code.RESERVED, f"Resource: {resource}")
        self._holders.update(dict.fromkeys(wanted, holder))

    def release(self, holder: Holder) -> None:
        """Let go of all that `holder` has."""
        for resource in [r for r, held_by in self._holders.items() if held_by is holder]:
            del self._holders[resource]
