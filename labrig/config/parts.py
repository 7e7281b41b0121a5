"""Tables of rig.toml whose keys come from the parts that are installed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, Self

from pydantic import Field, model_validator

from drivers import cameras, force_sensors, positioners
from drivers.boards import BOARD_FAMILIES
from drivers.cameras import CameraSettings
from drivers.interfaces import FREE, HARDWARE
from drivers.plugins import OWN
from labrig.config.base import ClosedModel
from labrig.config.derived import SIMULATED, OneOf, SettingsModel, by_kind, model_with


class PartConfig(SettingsModel):
    """A table whose other keys are those of its kind."""

    kind: str


class CameraConfig(PartConfig):
    """The camera and its calibration."""

    source: int | str = Field(description="anything OpenCV opens, aravis:NAME, or simulated")
    optics: Path = Field(description="optics.json of this camera")
    warn_after_days: int = Field(180, ge=1, description="age of a calibration that is worth a word")
    trigger_line: str | None = Field(
        None, description="digital output of the boards that is wired to the camera's trigger"
    )

    @model_validator(mode="after")
    def _can_be_set(self) -> Self:
        """Refuse what this kind of camera cannot set; an exposure may always be stated."""
        settings = self.settings()
        if not isinstance(settings, CameraSettings) or self.source == SIMULATED:
            return self  # what a simulated camera has is known where it is made
        sets = cameras.CAMERAS.get(self.kind).sets | {"exposure_s"}
        for name, value in asdict(settings.acquisition()).items():
            if value not in (None, FREE) and name not in sets:
                raise ValueError(
                    f"a camera of kind {self.kind} has no setting {name}; remove the key, or use "
                    "a kind that has it, such as aravis"
                )
        return self

    @model_validator(mode="after")
    def _trigger_is_wired(self) -> Self:
        trigger = getattr(self, "trigger", FREE)
        if trigger == HARDWARE and self.trigger_line is None:
            raise ValueError(
                'trigger = "hardware" needs trigger_line, the output of the boards that is wired '
                "to the camera"
            )
        return self


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


def board_models(names: Iterable[str] | None = None) -> Mapping[str, type[BoardsConfig]]:
    """Return the model of each table of boards that rig.toml may have, by its name.

    `names`: of tables; only families of these names are loaded.
    """
    if names is None:
        families = dict(BOARD_FAMILIES.parts())
    else:
        found = {name: part for name in names if (part := BOARD_FAMILIES.find(name))}
        # in the order of `parts`: ours come first
        order = sorted(found, key=lambda name: (found[name].distribution != OWN, name))
        families = {name: found[name] for name in order}
    return {name: model_with(BoardsConfig, part.part.settings) for name, part in families.items()}


POSITIONER = by_kind("positioner", _positioner_models, positioners.DEFAULT)
FORCE_SENSOR = by_kind("force sensor", _force_sensor_models, force_sensors.DEFAULT)
_CAMERA_BY_KIND = by_kind("camera", _camera_models)


def _camera_kind(table: Mapping[str, Any]) -> str:
    """Return the kind that the table names, or the one that opens its source."""
    if "kind" in table:
        return _CAMERA_BY_KIND.choose(table)
    return cameras.kind_of_source(table.get("source"))


CAMERA = OneOf(_camera_models, _camera_kind)
