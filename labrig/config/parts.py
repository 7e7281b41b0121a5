"""Tables of rig.toml whose keys come from the parts that are installed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import Field

from drivers import cameras, force_sensors, positioners
from drivers.boards import BOARD_FAMILIES
from labrig.config.base import ClosedModel
from labrig.config.derived import OneOf, SettingsModel, by_kind, model_with


class PartConfig(SettingsModel):
    """A table whose other keys are those of its kind."""

    kind: str


class CameraConfig(PartConfig):
    """The camera and its calibration."""

    source: int | str = Field(description="anything OpenCV opens, iidc:GUID, or simulated")
    optics: Path = Field(description="optics.json of this camera")
    warn_after_days: int = Field(180, ge=1)
    exposure_s: float | None = Field(
        None, gt=0, le=1.0,
        description="of a frame; the sheet in time is compared with the middle of it",
    )  # fmt: skip


class BoardsConfig(SettingsModel):
    """The table of a family of boards."""

    address: str
    sample_rate_hz: float


def _camera_models() -> Mapping[str, type[ClosedModel]]:
    return {
        name: model_with(CameraConfig, part.part.settings, name)
        for name, part in cameras.CAMERAS.parts().items()
    }


def _positioner_models() -> Mapping[str, type[ClosedModel]]:
    return {
        name: model_with(PartConfig, part.part.settings, name)
        for name, part in positioners.POSITIONERS.parts().items()
    }


def _force_sensor_models() -> Mapping[str, type[ClosedModel]]:
    return {
        name: model_with(PartConfig, part.part.settings, name)
        for name, part in force_sensors.FORCE_SENSORS.parts().items()
    }


def board_models() -> Mapping[str, type[BoardsConfig]]:
    """Return the model of each table of boards that rig.toml may have, by its name."""
    return {
        name: model_with(BoardsConfig, part.part.settings)
        for name, part in BOARD_FAMILIES.parts().items()
    }


POSITIONER = by_kind("positioner", _positioner_models, positioners.DEFAULT)
FORCE_SENSOR = by_kind("force sensor", _force_sensor_models, force_sensors.DEFAULT)
_CAMERA_BY_KIND = by_kind("camera", _camera_models)


def _camera_kind(table: Mapping[str, Any]) -> str:
    """Return the kind that the table names, or the one that opens its source."""
    if "kind" in table:
        return _CAMERA_BY_KIND.choose(table)
    return cameras.kind_of_source(table.get("source"))


CAMERA = OneOf(_camera_models, _camera_kind)
