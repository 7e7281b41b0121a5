"""Record which parts of a rig are from other distributions."""

from __future__ import annotations

from typing import Any

from drivers.boards import BOARD_FAMILIES
from drivers.cameras import CAMERAS
from drivers.force_sensors import FORCE_SENSORS
from drivers.plugins import PluginFolder
from drivers.positioners import POSITIONERS
from labrig.config import RigConfig


def parts_in_use(rig: RigConfig) -> dict[str, str]:
    """Return {"cameras.mycam": "mycam 1.0"}: part and distribution, of those not our own."""
    chosen: dict[PluginFolder[Any], str | None] = {
        BOARD_FAMILIES: rig.boards_kind,
        CAMERAS: rig.camera.kind if rig.camera else None,
        POSITIONERS: rig.stage.kind,
        FORCE_SENSORS: rig.force_sensor.kind,
    }
    return {
        f"{folder.group.removeprefix('labrig.')}.{kind}": folder.origins()[kind]
        for folder, kind in chosen.items()
        if kind in folder.origins()
    }
