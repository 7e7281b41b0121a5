"""Where commands are found: our own folder, and the entry points of other distributions."""

from __future__ import annotations

from drivers.plugins import PluginFolder
from labrig.cli.command import Command, faults

PACKAGE = "labrig.cli.commands"

COMMANDS: PluginFolder[Command] = PluginFolder(
    what="command",
    package=PACKAGE,
    constant="COMMAND",
    group="labrig.commands",
    faults=faults,
)
