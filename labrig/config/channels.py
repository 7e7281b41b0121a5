"""[channels.NAME] of rig.toml: inputs beside force, current and the drive's read-back."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Annotated

from pydantic import AfterValidator, Field

from labrig.config.base import ClosedModel
from protocols.execution.channels import CURRENT, DRIVE, FORCE, Channel, column_of

_RESERVED = frozenset({FORCE, CURRENT, DRIVE, "time"})  # of the boards, and the samples' time


def _is_input(value: str) -> str:
    if not re.fullmatch(r"\S+", value):
        raise ValueError("must be an input in the words of the boards, such as PCI6034E/ai3")
    return value


def _is_unit(value: str) -> str:
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,23}", value):
        raise ValueError("must be of letters, digits and _, such as degC or m_per_s")
    return value


class ChannelConfig(ClosedModel):
    """One further input that is recorded: a thermocouple's amplifier, a second load cell."""

    input: Annotated[str, AfterValidator(_is_input)] = Field(
        description="an input of the boards, wired differentially, such as PCI6034E/ai3"
    )
    quantity: str = Field(min_length=1, max_length=60, description="what is measured: temperature")
    unit: Annotated[str, AfterValidator(_is_unit)] = Field(
        description="of the values, in letters, digits and _: degC, N, m_per_s"
    )
    gain: float = Field(1.0, description="unit per volt at the input")
    offset: float = Field(0.0, description="value at 0 V, in the unit")
    range_V: float = Field(5.0, gt=0, le=10.0, description="largest voltage expected, either sign")

    def channel(self, name: str, range_V: float) -> Channel:
        """Return the channel; `range_V` is that which the board really has."""
        return Channel(
            name=name,
            quantity=self.quantity,
            unit=self.unit,
            range_V=range_V,
            terminal=self.input,
            gain=self.gain,
            offset=self.offset,
        )


def _have_names(channels: dict[str, ChannelConfig]) -> dict[str, ChannelConfig]:
    for name, channel in channels.items():
        if not re.fullmatch(r"[a-z][a-z0-9_]{0,31}", name):
            raise ValueError(f"{name!r}: a channel's name has small letters, digits and _")
        if name in _RESERVED:
            raise ValueError(f"{name!r} is a channel that every rig has; choose another name")
        if channel.gain == 0:
            raise ValueError(f"{name}: gain = 0 would make every value the same")
    columns = [column_of(name, channel.unit) for name, channel in channels.items()]
    if len(set(columns)) < len(columns):
        raise ValueError("two channels would have the same column, which is NAME_UNIT")
    return channels


def require_distinct(inputs: Iterable[tuple[str, str]]) -> None:
    """Raise ValueError when two of the inputs (name, terminal) are the same terminal."""
    named: dict[str, str] = {}
    for name, terminal in inputs:
        if terminal in named:
            raise ValueError(f"{terminal} is the input of both {named[terminal]} and {name}")
        named[terminal] = name


Channels = Annotated[dict[str, ChannelConfig], AfterValidator(_have_names)]
