"""Where each kind of part is found: every plug-in folder of labrig, by its entry-point group.

Each is imported when it is asked for: some take a second.
"""

from __future__ import annotations

from collections.abc import Iterator
from difflib import get_close_matches
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any

from drivers.plugins import PluginFolder

PREFIX = "labrig."
FOLDERS = {
    "effects": "model.effects.catalogue:FOLDER",
    "locations": "model.locations.catalogue:FOLDER",
    "reading_patterns": "model.identification.reading_patterns.catalogue:FOLDER",
    "dynamic_models": "model.dynamics.models.catalogue:FOLDER",
    "data_checks": "model.discrepancy.data_checks.catalogue:FOLDER",
    "verdict_checks": "model.discrepancy.criticism.catalogue:FOLDER",
    "boards": "drivers.boards.contract:BOARD_FAMILIES",
    "simulated_families": "sim_hardware.families.contract:FOLDER",
    "simulated_boards": "sim_hardware.ni.boards:FOLDER",
    "simulated_serial_devices": "sim_hardware.serial_devices:FOLDER",
    "cameras": "drivers.cameras.contract:CAMERAS",
    "positioners": "drivers.positioners.contract:POSITIONERS",
    "force_sensors": "drivers.force_sensors.contract:FORCE_SENSORS",
    "protocols": "labrig.config.protocol:PROTOCOLS",
    "extras": "labrig.config.protocol:EXTRAS",
    "extractors": "labrig.extractors.choice:EXTRACTORS",
    "strip_facts": "labrig.vision.facts.catalogue:FOLDER",
    "curve_checks": "labrig.vision.checks.catalogue:FOLDER",
    "exports": "labrig.exports.choice:FORMATS",
    "report_sections": "labrig.report.sections.interface:SECTIONS",
    "page_panels": "labrig.panel.pages.interface:PAGES",
    "batch_tasks": "labrig.batch.choice:BATCH_TASKS",
    "commands": "labrig.cli.command_folder:COMMANDS",
}


def folder_of(kind: str) -> PluginFolder[Any]:
    """Return the folder of a kind, the last word of its entry-point group. Raises KeyError."""
    module, _, name = FOLDERS[kind].partition(":")
    # `drivers`, `model` and `sim_hardware` have a class of this name each, all alike
    folder: PluginFolder[Any] = getattr(import_module(module), name)
    return folder


def nearest(kind: str) -> str:
    """Return the kind that is meant by what is none; empty where nothing is like it.

    A part of the name says more than letters that are alike: `sections` is no `locations`.
    """
    words = kind.strip("_")
    within = [known for known in FOLDERS if words and (words in known or known in words)]
    return next(iter([*get_close_matches(kind, within or FOLDERS, n=1), *within]), "")


def groups_of_no_kind() -> Iterator[str]:
    """Yield a sentence for each entry-point group of labrig's name that nothing looks into."""
    every = entry_points()
    for group in sorted(group for group in every.groups if group.startswith(PREFIX)):
        kind = group.removeprefix(PREFIX)
        if kind in FOLDERS:
            continue
        close = nearest(kind)
        hint = f"; did you mean {PREFIX}{close}" if close else ""
        owners = {point.dist.name for point in every.select(group=group) if point.dist}
        yield (
            f"the entry-point group {group} of {', '.join(sorted(owners))} is no kind of part"
            f"{hint}."
        )
