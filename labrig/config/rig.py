"""rig.toml: what is wired, and what the rig must never exceed."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from labrig.config.base import ClosedModel, parse_toml, read_text, validate
from labrig.config.channels import Channels, require_distinct

_CHANNEL = re.compile(r"^[^/\s]+/(ai|ao|port\d+/line)\d+$")


def _is_channel(value: str) -> str:
    if not _CHANNEL.match(value):
        raise ValueError("must be a device and a channel, such as PCI6034E/ai0")
    return value


def _is_line(value: str) -> str:
    if not re.match(r"^[^/\s]+/port\d+/line\d+$", value):
        raise ValueError("must be a digital line, such as PCI6703/port0/line0")
    return value


def _is_address(value: str) -> str:
    if value in {"local", "simulated"} or re.match(r"^[^:\s]+:\d{1,5}$", value):
        return value
    raise ValueError('must be "local", "simulated" or host:port of an NI gRPC Device Server')


Channel = Annotated[str, AfterValidator(_is_channel)]
Positive = Annotated[float, Field(gt=0)]


class TaskNames(ClosedModel):
    """Names of the NI tasks, by which the guard and `labrig safe` find them."""

    output: str = "labrig-output"
    input: str = "labrig-input"
    interlock: str = "labrig-interlock"


class InputRanges(ClosedModel):
    """Largest voltage expected at each input; the board rounds it up to a range it has."""

    force: Positive = Field(0.05, le=10.0, description="V, either sign, of the load cell")
    current: Positive = Field(0.5, le=10.0, description="V, either sign, across the shunt")
    drive: Positive = Field(5.0, le=10.0, description="V, either sign, at the sheet")


class Ni(ClosedModel):
    """The National Instruments boards."""

    address: Annotated[str, AfterValidator(_is_address)] = Field(
        "local", description="local driver, host:port of an NI gRPC Device Server, or simulated"
    )
    drive: Channel = Field("PCI6703/ao0", description="output that drives the amplifier")
    force: Channel = Field("PCI6034E/ai0", description="input of the load cell, differential")
    current: Channel = Field("PCI6034E/ai1", description="input of the current shunt")
    drive_readback: Channel = Field("PCI6034E/ai2", description="input of the sheet voltage")
    sample_rate_hz: float = Field(1000.0, ge=100.0, le=66_000.0, description="of each channel")
    task_names: TaskNames = TaskNames()
    ranges_V: InputRanges = InputRanges()


class AmplifierConfig(ClosedModel):
    """Between the board's output and the sheet."""

    gain: float = Field(10.0, ge=1.0, le=1000.0, description="sheet volts per board volt")


class CurrentSense(ClosedModel):
    """The shunt in series with the sheet."""

    shunt_ohm: Positive = 1.0


class Limits(ClosedModel):
    """What the rig must never exceed."""

    sheet_voltage_V: float = Field(2.5, gt=0, le=30.0, description="largest, either sign")
    time_under_voltage_s: Positive = Field(30.0, description="in one run")
    safe_below_V: float = Field(0.05, gt=0, le=0.5, description="a smaller read-back counts as 0 V")


class InterlockConfig(ClosedModel):
    """An external one-shot that drops the amplifier's supply when the working loop stops."""

    line: Annotated[str, AfterValidator(_is_line)] = Field(
        description="digital output that is toggled while a run is under way"
    )


class LoadCellFile(ClosedModel):
    """Where the load cell's calibration is."""

    calibration: Path
    warn_after_days: int = Field(180, ge=1, description="age of a calibration that is worth a word")


class CameraConfig(ClosedModel):
    """The camera and its calibration."""

    source: int | str = Field(description="anything OpenCV opens, iidc:GUID, or simulated")
    optics: Path = Field(description="optics.json of this camera")
    warn_after_days: int = Field(180, ge=1)


class StageConfig(ClosedModel):
    """What moves the load cell along the arc."""

    kind: Literal["manual", "zaber"] = "manual"
    port: str | None = Field(None, description="serial port of a zaber stage, or simulated")
    address: int = Field(1, ge=1, le=99, description="device number on the Zaber chain")
    origin_deg: float = Field(0.0, description="stage angle at position 0 of the arc")
    home: bool = Field(
        default=False,
        description="sweep to the home sensor when the stage has lost its reference; nothing may "
        "stand in its way",
    )

    @property
    def origin_rad(self) -> float:
        """The same in rad."""
        return math.radians(self.origin_deg)


class Simulated(ClosedModel):
    """The world to simulate, where an address says simulated.

    Only its place: what the world holds must never reach the session, which it would give away.
    """

    world: Path | None = Field(None, description="world.toml; the built-in one when absent")


class RigConfig(ClosedModel):
    """The whole of rig.toml."""

    ni: Ni = Ni()
    amplifier: AmplifierConfig = AmplifierConfig()
    current_sense: CurrentSense = CurrentSense()
    limits: Limits = Limits()
    load_cell: LoadCellFile
    camera: CameraConfig | None = None
    stage: StageConfig = StageConfig()
    channels: Channels = Field({}, description="further inputs that are recorded, by name")
    interlock: InterlockConfig | None = None
    simulated: Simulated | None = None

    @model_validator(mode="after")
    def _have_inputs_of_their_own(self) -> RigConfig:
        ni = self.ni
        fixed = {"force": ni.force, "current": ni.current, "drive_readback": ni.drive_readback}
        require_distinct(fixed | {name: each.input for name, each in self.channels.items()})
        return self

    @property
    def is_simulated(self) -> bool:
        """Whether the boards are the ones simulated in this process, on the virtual clock."""
        return self.ni.address == "simulated"


class ReplayConfig(ClosedModel):
    """A rig that is a recorded session: all else comes from what was recorded."""

    replay: Path


def parse_rig(text: str, name: str) -> RigConfig | ReplayConfig:
    """rig.toml's text as a configuration; paths stay as they are written."""
    data = parse_toml(text, name)
    if "replay" in data:
        return validate(ReplayConfig, data, name)
    return validate(RigConfig, data, name)


def load_rig(path: Path) -> RigConfig | ReplayConfig:
    """Read rig.toml; paths in it are taken from the file's own folder."""
    rig = parse_rig(read_text(path), str(path))
    folder = path.parent
    if isinstance(rig, ReplayConfig):
        return rig.model_copy(update={"replay": folder / rig.replay})
    update: dict[str, object] = {
        "load_cell": rig.load_cell.model_copy(
            update={"calibration": folder / rig.load_cell.calibration}
        )
    }
    if rig.camera is not None:
        update["camera"] = rig.camera.model_copy(update={"optics": folder / rig.camera.optics})
    if rig.simulated is not None and rig.simulated.world is not None:
        update["simulated"] = rig.simulated.model_copy(
            update={"world": folder / rig.simulated.world}
        )
    return rig.model_copy(update=update)
