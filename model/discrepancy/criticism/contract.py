"""The contract of a verdict check: it compares what a name implies with the data.

A check is asked once, after the effects are named and before anything is reported, and only where
something is named. It yields one `Failure` for each thing that is wrong, and nothing where the
names are in order. It must not block, keeps no state, and changes none of its arguments. It fits
nothing: `NamedModel` has what was computed.
"""

# ruff: noqa: ARG002 - the method that a check overrides does nothing with what it is given

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from model.discrepancy.criticism.check_result import Failure

if TYPE_CHECKING:
    from model.discrepancy.criticism.named_model import NamedModel


@dataclass(frozen=True, kw_only=True)
class VerdictCheck:
    """One kind of contradiction."""

    name: str  # also of its file
    meaning: str  # what is compared with what, a noun phrase
    order: int  # of presentation

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """Return what contradicts the names."""
        yield from ()
