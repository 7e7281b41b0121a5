"""rig.toml: what is wired, and what the rig must never exceed."""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self, TypeVar, cast

from pydantic import AfterValidator, Field, ValidationError, create_model, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from drivers.boards import BOARD_FAMILIES, DEFAULT, BoardFamily, BoardInput
from drivers.boards.contract import CURRENT, DRIVE, FORCE
from drivers.force_sensors import FORCE_SENSORS
from drivers.interfaces import FREE, HARDWARE
from drivers.watch.wire import PORT as WATCH_PORT
from labrig.config.base import ClosedModel, parse_toml, read_text, validate
from labrig.config.channels import Channels, require_distinct
from labrig.config.derived import SIMULATED, SettingsModel, raising_value_errors
from labrig.config.file_kinds import RIG, refuse_other_kind
from labrig.config.hooks import HooksConfig
from labrig.config.parts import (
    CAMERA,
    FORCE_SENSOR,
    POSITIONER,
    BoardsConfig,
    CameraConfig,
    PartConfig,
    board_models,
)
from labrig.config.publish import PublishConfig

Positive = Annotated[float, Field(gt=0)]


class AmplifierConfig(ClosedModel):
    """Between the board's output and the sheet."""

    gain: float = Field(10.0, ge=1.0, le=1000.0, description="sheet volts per board volt")
    product: str = Field("", description="maker and model, for the record")
    serial: str = Field("", description="serial number, for the record")
    calibrated: dt.date | None = Field(None, description="when the gain was measured")


class CurrentSense(ClosedModel):
    """The shunt in series with the sheet."""

    shunt_ohm: Positive = Field(1.0, description="current = voltage across it / resistance")


class Limits(ClosedModel):
    """What the rig must never exceed."""

    sheet_voltage_V: float = Field(2.5, gt=0, le=30.0, description="largest, either sign")
    time_under_voltage_s: Positive = Field(30.0, description="in one run")
    safe_below_V: float = Field(0.05, gt=0, le=0.5, description="a smaller read-back counts as 0 V")


class InterlockConfig(ClosedModel):
    """An external one-shot that drops the amplifier's supply when the working loop stops."""

    line: str = Field(description="digital output that is toggled while a run is under way")


def _check_watch(value: str) -> str:
    host, found, port = value.partition(":")
    good = not found or (port.isdecimal() and 0 < int(port) < 65536)
    if not host or not good:
        raise ValueError("must be host or host:port, such as 192.0.2.7:31764")
    return value


class WatchConfig(ClosedModel):
    """`labrig watch` on the computer that has the boards."""

    address: Annotated[str, AfterValidator(_check_watch)] = Field(
        description="host, or host:port, of `labrig watch`"
    )
    token: Path = Field(Path("watch.token"), description="copy of the file that it has made")

    @property
    def host_and_port(self) -> tuple[str, int]:
        """Return where it listens."""
        host, _, port = self.address.partition(":")
        return host, int(port or WATCH_PORT)


class LoadCellFile(ClosedModel):
    """Where the load cell's calibration is."""

    calibration: Path = Field(description="load_cell.toml, from the folder of this file")
    warn_after_days: int = Field(180, ge=1, description="age of a calibration that is worth a word")


class Simulated(ClosedModel):
    """The world to simulate, where an address says simulated.

    Only its place: what the world holds must never reach the session, which it would give away.
    """

    world: Path | None = Field(None, description="world.toml; the built-in one when absent")


class OutputConfig(ClosedModel):
    """What of rig.toml 0 V depends on, besides the boards' own table: all that `labrig safe` reads.

    A table that making safe needs is a field of this class and not of `RigConfig`.
    """

    families: ClassVar[tuple[str, ...]] = ()

    amplifier: AmplifierConfig = AmplifierConfig()
    limits: Limits = Limits()
    interlock: InterlockConfig | None = None

    @property
    def boards_kind(self) -> str:
        """The family of the boards: the name of their table."""
        return next(name for name in self.families if getattr(self, name) is not None)

    @property
    def family(self) -> BoardFamily:
        """The same as the driver has it."""
        return BOARD_FAMILIES.get(self.boards_kind)

    @property
    def boards(self) -> BoardsConfig:
        """The table of the boards."""
        return cast("BoardsConfig", getattr(self, self.boards_kind))

    @property
    def interlock_line(self) -> str | None:
        """The line of the interlock; None: the rig has none."""
        return None if self.interlock is None else self.interlock.line

    @property
    def own_watchdog(self) -> str:
        """What a watchdog in the boards does when labrig is silent; empty: there is none."""
        return self.family.own_watchdog(self.boards.settings(), self.interlock_line)

    @property
    def is_simulated(self) -> bool:
        """Whether the boards are the ones simulated in this process, on the virtual clock."""
        return self.boards.address == SIMULATED


class RigConfig(OutputConfig):
    """The whole of rig.toml but its boards; `rig_model` adds a table for each family of them."""

    current_sense: CurrentSense = CurrentSense()
    load_cell: LoadCellFile
    force_sensor: Annotated[PartConfig, FORCE_SENSOR] = Field(
        default_factory=lambda: cast("PartConfig", FORCE_SENSOR.read({})),
        description="what reads the force on the load cell",
    )
    camera: Annotated[CameraConfig, CAMERA] | None = Field(
        None, description="what takes the images"
    )
    stage: Annotated[PartConfig, POSITIONER] = Field(
        default_factory=lambda: cast("PartConfig", POSITIONER.read({})),
        description="what moves the load cell along the arc",
    )
    channels: Channels = Field({}, description="further inputs that are recorded, by name")
    watch: WatchConfig | None = Field(
        None, description="who writes 0 V at the boards when this computer is gone"
    )
    simulated: Simulated | None = None
    hooks: HooksConfig | None = Field(
        None, description="who is told when a session waits, has stopped or is done"
    )
    publish: PublishConfig | None = Field(
        None, description="where documents of a session go while it runs"
    )

    @model_validator(mode="before")
    @classmethod
    def _with_boards(cls, data: Any) -> Any:
        """Add the default table of boards to a file that has none."""
        if not isinstance(data, dict) or any(data.get(name) is not None for name in cls.families):
            return data
        return {**data, DEFAULT: {}}

    @model_validator(mode="after")
    def _has_one_family(self) -> Self:
        there = [name for name in self.families if getattr(self, name) is not None]
        if len(there) > 1:
            tables = " and ".join(f"[{name}]" for name in there)
            raise ValueError(f"there are the boards {tables}; a rig has one table of boards")
        lines = []
        if self.interlock is not None:
            lines.append(self._line(self.interlock.line, "interlock", "line"))
        if self.trigger_line is not None:
            lines.append(self._line(self.trigger_line, "camera", "trigger_line"))
        if len(lines) == 2 and lines[0] == lines[1]:  # its pulses would keep the relay closed
            raise ValueError(
                f"[camera] trigger_line and [interlock] line are both {self.trigger_line}; "
                "each needs a line of its own"
            )
        wired = self._wired()
        further = [(name, each.input) for name, each in self.channels.items()]
        require_distinct([*((each.name, each.terminal) for each in wired), *further])
        return self

    def _wired(self) -> Sequence[BoardInput]:
        with raising_value_errors():
            wired = tuple(self.family.inputs(self.boards.settings()))
        names = {each.name for each in wired}
        missing = [name for name in (FORCE, CURRENT, DRIVE) if name not in names]
        if missing:
            raise ValueError(
                f"the boards of [{self.boards_kind}] have no input {', '.join(missing)}"
            )
        return wired

    def _line(self, line: str, table: str, key: str) -> object:
        try:
            with raising_value_errors():
                return self.family.check_line(line)
        except ValueError as fault:
            error = PydanticCustomError("line", "{why}", {"why": str(fault)})
            details = InitErrorDetails(type=error, loc=(table, key), input=line)
            raise ValidationError.from_exception_data("line", [details]) from None

    @property
    def trigger_line(self) -> str | None:
        """The line of the boards that triggers the camera; None: it is not triggered by them."""
        camera = self.camera
        hardware = camera is not None and getattr(camera, "trigger", FREE) == HARDWARE
        return camera.trigger_line if camera is not None and hardware else None

    @property
    def raw_force_unit(self) -> str:
        """Unit in which the force arrives: V of the load cell, or N where a meter reads it."""
        return "V" if FORCE_SENSORS.get(self.force_sensor.kind).make is None else "N"

    def changed(self, **tables: Mapping[str, Any] | None) -> RigConfig:
        """Return the configuration with other values of some keys, by table and key.

        None removes a table.
        """
        data = self.model_dump()
        for name, keys in tables.items():
            data[name] = None if keys is None else {**(data.get(name) or {}), **keys}
        return _model_for(data).model_validate(data)


def rig_model() -> type[RigConfig]:
    """Return the model of rig.toml with a table for each family of boards that is installed."""
    return _rig_model(tuple(board_models().items()))


@lru_cache(maxsize=16)
def _rig_model(families: tuple[tuple[str, type[BoardsConfig]], ...]) -> type[RigConfig]:
    fields: dict[str, Any] = {name: (model | None, None) for name, model in families}
    model = create_model(
        "RigConfig", __base__=RigConfig, __doc__="The whole of rig.toml.", **fields
    )
    model.families = tuple(name for name, _ in families)
    return model


class ReplayConfig(ClosedModel):
    """A rig that is a recorded session: all else comes from what was recorded."""

    replay: Path = Field(description="session whose recorded signals stand for the rig")


def parse_rig(text: str, name: str) -> RigConfig | ReplayConfig:
    """rig.toml's text as a configuration; paths stay as they are written."""
    refuse_other_kind(text, name, RIG)
    data = parse_toml(text, name)
    if "replay" in data:
        return validate(ReplayConfig, data, name)
    return validate(_model_for(data), data, name)


MOST_TABLES = 100  # that a rig.toml may have; more are a mistake, which is told as one


def _model_for(data: Mapping[str, Any]) -> type[RigConfig]:
    """Return the model of rig.toml with the tables of boards that it has.

    What a plug-in for other boards does when it is loaded must not keep anybody from these.
    """
    tables = [name for name, table in data.items() if isinstance(table, Mapping)]
    families = board_models(tables) if len(tables) <= MOST_TABLES else {}
    known = RigConfig.model_fields.keys() | families.keys()
    all_known = bool(families) and data.keys() <= known
    # what is wrong is said with all the tables that there may be
    return _rig_model(tuple(families.items())) if all_known else rig_model()


# Tables that 0 V does not depend on. One that is not known at all may be that of the boards, and is
# an error.
NOT_THE_OUTPUT = RigConfig.model_fields.keys() - OutputConfig.model_fields.keys()


def load_output(path: Path) -> OutputConfig | ReplayConfig:
    """Read what rig.toml says of the boards and their output, whatever is wrong with the rest.

    A camera whose plug-in is gone must not keep anybody from making the output safe.
    """
    text = read_text(path, RIG)
    refuse_other_kind(text, str(path), RIG)
    data = parse_toml(text, str(path))
    if "replay" in data:
        return validate(ReplayConfig, data, str(path))
    kept = {name: table for name, table in data.items() if name not in NOT_THE_OUTPUT}
    kept["load_cell"] = {"calibration": "load_cell.toml"}  # required, and not read
    return _with_device_paths(validate(_model_for(kept), kept, str(path)), path.parent)


def load_rig(path: Path) -> RigConfig | ReplayConfig:
    """Read rig.toml; paths in it are taken from the file's own folder."""
    rig = parse_rig(read_text(path, RIG), str(path))
    if isinstance(rig, ReplayConfig):
        return rig.model_copy(update={"replay": path.parent / rig.replay})
    return with_paths_from(rig, path.parent)


def with_paths_from(rig: RigConfig, folder: Path) -> RigConfig:
    """Return the configuration with its paths taken from a folder."""
    rig = _with_device_paths(rig, folder)
    update: dict[str, object] = {
        "load_cell": rig.load_cell.model_copy(
            update={"calibration": folder / rig.load_cell.calibration}
        )
    }
    if rig.camera is not None:
        update["camera"] = rig.camera.model_copy(update={"optics": folder / rig.camera.optics})
    if rig.watch is not None:
        update["watch"] = rig.watch.model_copy(update={"token": folder / rig.watch.token})
    if rig.publish is not None:
        update["publish"] = rig.publish.model_copy(update={"bluesky": folder / rig.publish.bluesky})
    if rig.simulated is not None and rig.simulated.world is not None:
        update["simulated"] = rig.simulated.model_copy(
            update={"world": folder / rig.simulated.world}
        )
    return rig.model_copy(update=update)


AnyRig = TypeVar("AnyRig", bound=OutputConfig)


def _with_device_paths(rig: AnyRig, folder: Path) -> AnyRig:
    """Return the configuration with the paths that its devices' settings name taken from there."""
    tables = {name: getattr(rig, name) for name in type(rig).model_fields}
    devices = {name: table for name, table in tables.items() if isinstance(table, SettingsModel)}
    return rig.model_copy(
        update={name: table.with_paths_from(folder) for name, table in devices.items()}
    )
