"""Record which parts of a session are from other distributions."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Mapping
from typing import Any

from drivers.boards import BOARD_FAMILIES
from drivers.cameras import CAMERAS
from drivers.force_sensors import FORCE_SENSORS
from drivers.plugins import PluginFolder
from drivers.positioners import POSITIONERS
from labrig.config import RigConfig
from labrig.config.protocol import EXTRAS, PROTOCOLS
from protocols import Schedule


def parts_in_use(rig: RigConfig, schedule: Schedule) -> dict[str, str]:
    """Return {"cameras.mycam": "mycam 1.0"}: part and distribution, of those not our own."""
    chosen: dict[PluginFolder[Any], set[str | None]] = {
        BOARD_FAMILIES: {rig.boards_kind},
        CAMERAS: {rig.camera.kind if rig.camera else None},
        POSITIONERS: {rig.stage.kind},
        FORCE_SENSORS: {rig.force_sensor.kind},
        PROTOCOLS: {schedule.protocol},
        EXTRAS: {run.extra for run in schedule.runs},
    }
    return {
        f"{folder.group.removeprefix('labrig.')}.{kind}": origin
        for folder, kinds in chosen.items()
        for kind, origin in folder.origins().items()
        if kind in kinds
    }


def missing_parts(versions: Mapping[str, str]) -> str:
    """Return in words which of a session's parts are of distributions that are not installed."""
    lost = [f"{part} of {origin}" for part, origin in versions.items() if _is_missing(part, origin)]
    return f"the session was recorded with {', '.join(lost)}; install that" if lost else ""


def _is_missing(part: str, origin: str) -> bool:
    name, has_version, _ = origin.partition(" ")
    if "." not in part or not has_version:  # the version of a package
        return False
    try:
        importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return True
    return False
