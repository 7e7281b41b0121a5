"""protocol.toml: what is done, where, in which order, and what is kept."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from functools import lru_cache
from typing import Annotated, Any, Literal

from pydantic import Field, create_model, field_validator, model_validator

from drivers.plugins import PluginFolder
from labrig.config.base import ClosedModel, parse_toml, validate
from labrig.config.derived import SettingsModel, model_of
from labrig.config.file_kinds import PROTOCOL, refuse_other_kind
from labrig.errors import BadInputError
from protocols import Extra, Extras, Place, ProtocolKind, Schedule, ScheduleError, make_schedule
from protocols.extras.conformance import faults as extra_faults
from protocols.kinds.conformance import faults
from protocols.planning.limits import check_structure

# The kinds of protocol: files of `protocols/kinds`, and those of other distributions.
PROTOCOLS: PluginFolder[type[ProtocolKind]] = PluginFolder(
    what="protocol",
    package="protocols.kinds",
    constant="PROTOCOL",
    group="labrig.protocols",
    faults=faults,
)


# The extras with runs of their own: files of `protocols.extras`, and those of other distributions.
EXTRAS: PluginFolder[type[Extra]] = PluginFolder(
    what="extra",
    package="protocols.extras",
    constant="EXTRA",
    group="labrig.extras",
    faults=extra_faults,
)


class PlaceConfig(ClosedModel):
    """One configuration of the sheet and the positions at which it is measured."""

    configuration: str = Field(description="of the sheet, a table of sheet.toml")
    positions_mm: list[float] = Field(
        max_length=1000, description="empty: only extras without the load cell"
    )


class CameraUse(ClosedModel):
    """What is wanted of the camera."""

    frame_rate_hz: float = Field(25.0, gt=0, le=1000.0, description="frames per second, in Hz")
    keep_all_frames: bool = Field(default=False, description="not only the frame of each reading")


class ExtrasConfig(ClosedModel):
    """Minutes at the rig that decide what can be known afterwards; mode "paper" has none of them.

    In mode "default" those that cost under a minute each are on unless they are switched off.
    """

    # `protocol_model` adds the keys of `protocols.extras`, such as `free_shapes` and `release`.

    mode: Literal["default", "paper"] = Field(
        "default", description="paper: no extras; default: those under a minute"
    )
    random_order: bool | None = Field(None, description="of the positions; the order is recorded")
    random_order_seed: int = Field(1, ge=0, description="another number, another random order")
    no_touch_zero: bool | None = Field(None, description="the load cell's zero at each position")
    reversed_approach: bool | None = Field(None, description="one position from the other side")
    approach: Literal["up", "down"] = Field(
        "up",
        description="up: each position is approached from a lower one; down: from a higher one",
    )
    remounts: int = Field(0, ge=0, le=100, description="positions set anew and measured again")
    dead_weights_mN: tuple[Annotated[float, Field(gt=0)], ...] = Field(
        (), description="forces that are hung on the load cell to check it"
    )
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
            for key in ("random_order", "no_touch_zero", *EXTRAS.parts(), "reversed_approach")
            if getattr(self, key, None)
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
            added=tuple(self._added(default=default)),
            reversed_approach=on(self.reversed_approach),
            approach=self.approach,
            turned_over=self.tilt_deg == 180.0,
            dead_weights_N=tuple(load / 1000 for load in self.dead_weights_mN),
        )

    def _added(self, *, default: bool) -> Iterator[Extra]:
        for name, part in EXTRAS.parts().items():
            asked = getattr(self, name, None)
            if isinstance(asked, SettingsModel):
                yield asked.settings()
            elif asked or (asked is None and default and part.part.by_default):
                yield part.part()


class AnalysisConfig(ClosedModel):
    """What is to be made of the session afterwards; the plan says what that needs."""

    dynamic: bool = Field(
        default=False, description="the sheet is to be identified in time: mass, loss, electrodes"
    )


class RulesConfig(ClosedModel):
    """When a reading is invalid without anybody saying so."""

    late_edge_s: float = Field(
        0.005, gt=0, le=3600.0, description="an edge written later spoils its reading"
    )


class ProtocolConfig(ClosedModel):
    """The whole of protocol.toml: one kind of protocol, run at each position of each place."""

    # `protocol_model` adds the tables of the kinds, such as [pulse_train].

    places: list[PlaceConfig] = Field(
        min_length=1, max_length=1000, description="where it is done, in this order"
    )
    moisten: bool = Field(default=True, description="ask for it before each run")
    camera: CameraUse = CameraUse()
    extras: ExtrasConfig = ExtrasConfig()
    rules: RulesConfig = RulesConfig()
    analysis: AnalysisConfig = AnalysisConfig()

    @model_validator(mode="after")
    def _one_kind(self) -> ProtocolConfig:
        named = self._named()
        if len(named) != 1:
            found = " and ".join(f"[{kind}]" for kind in named) or "none"
            raise ValueError(
                f"exactly one of {', '.join(f'[{kind}]' for kind in PROTOCOLS.parts())} is needed; "
                f"there is {found}"
            )
        return self

    def protocol(self) -> ProtocolKind:
        """Return the protocol that the file's one table defines."""
        table = getattr(self, self._named()[0])
        made: ProtocolKind = table.settings()
        return made

    def schedule(self, name: str) -> Schedule:
        """Return the schedule of the whole session; `name` is the file's name for the error."""
        try:
            schedule = make_schedule(
                self.protocol(),
                [_place(place) for place in self.places],
                extras=self.extras.extras(),
                moisten=self.moisten,
                frame_rate_hz=self.camera.frame_rate_hz,
            )
            check_structure(schedule)  # the kind may be another distribution's
        except ScheduleError as error:
            raise BadInputError(f"{name}: {error}.") from None
        return schedule

    def _named(self) -> list[str]:
        return [kind for kind in PROTOCOLS.parts() if getattr(self, kind, None) is not None]


def protocol_model() -> type[ProtocolConfig]:
    """Return the model of protocol.toml with the kinds of protocol and extras there are now."""
    return _model_of(
        tuple((name, part.part) for name, part in PROTOCOLS.parts().items()),
        tuple((name, part.part) for name, part in EXTRAS.parts().items()),
    )


Named = tuple[tuple[str, type], ...]


@lru_cache(maxsize=8)
def _model_of(kinds: Named, extras: Named) -> type[ProtocolConfig]:
    tables: dict[str, Any] = {name: (model_of(kind) | None, None) for name, kind in kinds}
    keys: dict[str, Any] = {
        name: (bool | model_of(extra) | None, _key_of(extra)) for name, extra in extras
    }
    added = create_model(
        "ExtrasConfig", __base__=ExtrasConfig, __doc__=ExtrasConfig.__doc__, **keys
    )
    tables["extras"] = (added, added())
    one_kind = {"oneOf": [{"required": [name]} for name, _ in kinds]}
    made: type[ProtocolConfig] = create_model(
        "ProtocolConfig",
        __base__=ProtocolConfig,
        __doc__=ProtocolConfig.__doc__,
        __cls_kwargs__={"json_schema_extra": one_kind},
        **tables,
    )
    return made


def _key_of(extra: type[Extra]) -> Any:
    """Return the key of an extra in [extras], described by the first line of its docstring."""
    return Field(None, description=inspect.cleandoc(extra.__doc__ or "").split("\n")[0])


def _place(place: PlaceConfig) -> Place:
    return Place(place.configuration, tuple(p / 1000 for p in place.positions_mm))


def parse_protocol(text: str, name: str) -> ProtocolConfig:
    """protocol.toml's text as a configuration."""
    refuse_other_kind(text, name, PROTOCOL)
    return validate(protocol_model(), parse_toml(text, name), name)
