"""The conformance function of each kind of part, under one name each."""

from __future__ import annotations

from labrig.cli.command import faults as command_faults

__all__ = ["command_faults"]
