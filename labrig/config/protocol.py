"""protocol.toml: what is done, where, in which order, and what is kept."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from labrig.config.base import ClosedModel, parse_toml, read_text, validate
from labrig.errors import BadInputError
from protocols import (
    Extras,
    Hold,
    Place,
    PulseTrain,
    Schedule,
    ScheduleError,
    Staircase,
    StepResponse,
    make_schedule,
)

Seconds = Annotated[float, Field(gt=0, le=3600.0)]
Voltage = Annotated[float, Field(ge=-30.0, le=30.0)]


class PulseTrainConfig(ClosedModel):
    """Readings at 0 V, then pulses of alternating voltages, as in the paper."""

    voltages_V: list[Voltage] = Field([2.0, -2.0], min_length=1, max_length=1000)
    zero_readings: int = Field(10, ge=0, le=1000)
    pulses_discarded: int = Field(2, ge=0, le=1000, description="recorded and marked, not used")
    readings_per_voltage: int = Field(10, ge=1, le=1000)
    pulse_s: Seconds = 0.6
    sample_at_s: Seconds = Field(0.5, description="after the edge, as written")
    half_window_s: Seconds = Field(0.1, description="the filter's reach on either side")
    rest_s: float = Field(0.0, ge=0, le=3600.0, description="at 0 V between two pulses")

    def protocol(self) -> PulseTrain:
        """As `protocols` takes it."""
        return PulseTrain(**{**self.model_dump(), "voltages_V": tuple(self.voltages_V)})


class StepResponseConfig(ClosedModel):
    """One step of the voltage, held and watched."""

    voltage_V: Voltage = 2.0
    hold_s: Seconds = 10.0
    sample_every_s: Seconds = 0.5
    before_s: Seconds = 2.0
    after_s: Seconds = 5.0

    def protocol(self) -> StepResponse:
        """As `protocols` takes it."""
        return StepResponse(**self.model_dump())


class StaircaseConfig(ClosedModel):
    """A sweep over voltages, each held for the same time."""

    voltages_V: list[Voltage] = Field(
        [0.5, 1.0, 1.5, 2.0, 1.5, 1.0, 0.5], min_length=1, max_length=1000
    )
    dwell_s: Seconds = 1.0
    sample_at_s: Seconds = 0.8
    half_window_s: Seconds = 0.1

    def protocol(self) -> Staircase:
        """As `protocols` takes it."""
        return Staircase(**{**self.model_dump(), "voltages_V": tuple(self.voltages_V)})


class HoldConfig(ClosedModel):
    """Hold a voltage, let go, again and again: creep and relaxation."""

    voltage_V: Voltage = 2.0
    hold_s: Seconds = 5.0
    relax_s: Seconds = 5.0
    cycles: int = Field(3, ge=1, le=1000)
    sample_every_s: Seconds = 0.5

    def protocol(self) -> Hold:
        """As `protocols` takes it."""
        return Hold(**self.model_dump())


class PlaceConfig(ClosedModel):
    """One configuration of the sheet and the positions at which it is measured."""

    configuration: str
    positions_mm: list[float] = Field(
        max_length=1000, description="empty: only the free shapes of extras"
    )


class CameraUse(ClosedModel):
    """What is wanted of the camera."""

    frame_rate_hz: float = Field(25.0, gt=0, le=1000.0)
    keep_all_frames: bool = Field(default=False, description="not only the frame of each reading")


class ExtrasConfig(ClosedModel):
    """Minutes at the rig that decide what can be known afterwards; mode "paper" has none of them.

    In mode "default" those that cost under a minute each are on unless they are switched off.
    """

    mode: Literal["default", "paper"] = "default"
    random_order: bool | None = Field(None, description="of the positions; the order is recorded")
    random_order_seed: int = Field(1, ge=0)
    no_touch_zero: bool | None = Field(None, description="the load cell's zero at each position")
    free_shapes: bool | None = Field(None, description="the sheet's shapes without the load cell")
    reversed_approach: bool | None = Field(None, description="one position from the other side")
    approach: Literal["up", "down"] = Field(
        "up",
        description="the side from which all positions are approached: from lower ones, or not",
    )
    remounts: int = Field(0, ge=0, le=100, description="positions set anew and measured again")
    dead_weights_mN: tuple[Annotated[float, Field(gt=0)], ...] = ()
    tilt_deg: float = Field(
        0.0,
        description="180: the whole session with the rig turned over about the sheet's long axis",
    )

    @field_validator("tilt_deg")
    @classmethod
    def _upright_or_turned_over(cls, tilt_deg: float) -> float:
        if tilt_deg not in (0.0, 180.0):
            raise ValueError("the rig stands upright (0) or is turned over (180), nothing between")
        return tilt_deg

    @model_validator(mode="after")
    def _paper_mode_has_none(self) -> ExtrasConfig:
        asked = [
            key
            for key in ("random_order", "no_touch_zero", "free_shapes", "reversed_approach")
            if getattr(self, key)
        ]
        asked += [key for key in ("remounts", "dead_weights_mN") if getattr(self, key)]
        asked += ["approach"] * (self.approach != "up") + ["tilt_deg"] * (self.tilt_deg != 0.0)
        if self.mode == "paper" and asked:
            raise ValueError(f'mode "paper" has no extras; remove {asked[0]} or use mode "default"')
        return self

    def extras(self) -> Extras:
        """As `protocols` takes it."""
        default = self.mode == "default"

        def on(asked: bool | None) -> bool:
            return default if asked is None else asked

        return Extras(
            random_order_seed=self.random_order_seed if on(self.random_order) else None,
            remounts=self.remounts,
            no_touch_zero=on(self.no_touch_zero),
            free_shapes=on(self.free_shapes),
            reversed_approach=on(self.reversed_approach),
            approach=self.approach,
            turned_over=self.tilt_deg == 180.0,
            dead_weights_N=tuple(load / 1000 for load in self.dead_weights_mN),
        )


class RulesConfig(ClosedModel):
    """When a reading is invalid without anybody saying so."""

    late_edge_s: Seconds = Field(0.005, description="an edge written later spoils its reading")


class ProtocolConfig(ClosedModel):
    """The whole of protocol.toml: one kind of protocol, run at each position of each place."""

    pulse_train: PulseTrainConfig | None = None
    step_response: StepResponseConfig | None = None
    staircase: StaircaseConfig | None = None
    hold: HoldConfig | None = None
    places: list[PlaceConfig] = Field(min_length=1, max_length=1000)
    moisten: bool = Field(default=True, description="ask for it before each run")
    camera: CameraUse = CameraUse()
    extras: ExtrasConfig = ExtrasConfig()
    rules: RulesConfig = RulesConfig()

    @model_validator(mode="after")
    def _one_kind(self) -> ProtocolConfig:
        named = [kind for kind in KINDS if getattr(self, kind) is not None]
        if len(named) != 1:
            found = " and ".join(f"[{kind}]" for kind in named) or "none"
            raise ValueError(
                f"exactly one of {', '.join(f'[{kind}]' for kind in KINDS)} is needed; "
                f"there is {found}"
            )
        return self

    def schedule(self, name: str) -> Schedule:
        """The schedule of the whole session; `name` is the file's name for the error."""
        config = next(getattr(self, kind) for kind in KINDS if getattr(self, kind) is not None)
        try:
            return make_schedule(
                config.protocol(),
                [_place(place) for place in self.places],
                extras=self.extras.extras(),
                moisten=self.moisten,
                frame_rate_hz=self.camera.frame_rate_hz,
            )
        except ScheduleError as error:
            raise BadInputError(f"{name}: {error}.") from None


def _place(place: PlaceConfig) -> Place:
    return Place(place.configuration, tuple(p / 1000 for p in place.positions_mm))


KINDS = ("pulse_train", "step_response", "staircase", "hold")


def parse_protocol(text: str, name: str) -> ProtocolConfig:
    """protocol.toml's text as a configuration."""
    return validate(ProtocolConfig, parse_toml(text, name), name)


def load_protocol(path: Path) -> ProtocolConfig:
    """Read protocol.toml."""
    return parse_protocol(read_text(path), str(path))
