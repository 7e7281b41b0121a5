"""Models of configuration files made from the dataclasses of parts."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Annotated

import pytest
from pydantic import Field

from labrig.config.base import ClosedModel, validate
from labrig.config.derived import SettingsModel, by_kind, model_of, model_with
from labrig.errors import BadInputError


def _is_channel(value: str) -> None:
    if "/" not in value:
        raise ValueError("must be a device and a channel")


@dataclass(frozen=True)
class Names:
    """Names of tasks."""

    output: str = "out"


@dataclass(frozen=True, kw_only=True)
class Motor:
    """A stage with a motor."""

    port: str = field(metadata={"description": "serial port"})
    address: int = field(default=1, metadata={"ge": 1, "le": 99, "formerly": "number"})
    names: Names = Names()
    stops_mm: tuple[float, ...] = field(default=(1.0,), metadata={"items": {"gt": 0}, "unit": "mm"})
    channel: str | None = field(default=None, metadata={"check": _is_channel})

    def __post_init__(self) -> None:
        if self.port == self.channel:
            raise ValueError("port and channel must differ")


@dataclass(frozen=True)
class Hand:
    """A stage moved by hand."""


def _models() -> dict[str, type[ClosedModel]]:
    return {"motor": model_of(Motor, "motor"), "hand": model_of(Hand, "hand")}


STAGE = by_kind("stage", _models, "hand")


class File(ClosedModel):
    stage: Annotated[ClosedModel, STAGE] = Field(default_factory=lambda: STAGE.read({}))


def read(**stage: object):
    return validate(File, {"stage": stage}, "rig.toml").stage


def test_a_table_becomes_the_dataclass_again():
    found = read(kind="motor", port="COM3", names={"output": "o"}, stops_mm=[2, 3], channel="a/b")
    expected = Motor(port="COM3", names=Names("o"), stops_mm=(2.0, 3.0), channel="a/b")
    assert found.settings() == expected


def test_defaults_are_those_of_the_dataclass():
    assert read(kind="motor", port="COM3").settings() == Motor(port="COM3")


def test_the_default_kind_needs_no_table():
    assert validate(File, {}, "rig.toml").stage.settings() == Hand()


def test_a_key_of_another_kind_is_left_unread():
    assert read(kind="hand", port="COM3").settings() == Hand()


@pytest.mark.parametrize(
    ("stage", "said"),
    [
        ({"kind": "motor"}, "[stage] port is missing; it is required"),
        ({"kind": "motor", "port": "x", "address": 0}, "[stage] address = 0: should be greater"),
        ({"kind": "motor", "port": "x", "names": {"output": 1}}, "[stage.names] output = 1"),
        ({"kind": "motor", "port": "x", "stops_mm": [0]}, "value 1 of [stage] stops_mm = 0"),
        ({"kind": "motor", "port": "x", "channel": "y"}, "must be a device and a channel"),
        ({"kind": "motor", "port": "a/b", "channel": "a/b"}, "port and channel must differ"),
        ({"kind": "motor", "port": "x", "addres": 1}, "not a known key; did you mean address"),
        ({"kind": "moto"}, "[stage] kind = 'moto': there is no stage of this kind; choose one of"),
    ],
)
def test_what_is_wrong_is_said_in_the_words_of_the_file(stage, said):
    with pytest.raises(BadInputError) as caught:
        read(**stage)
    assert said in str(caught.value)


def test_an_older_name_of_a_key_is_read_with_a_warning():
    with pytest.warns(DeprecationWarning, match="number is now called address"):
        assert read(kind="motor", port="x", number=3).settings().address == 3


def test_the_schema_shows_bounds_descriptions_and_units_of_every_kind():
    schema = File.model_json_schema()["properties"]["stage"]
    motor = next(kind["properties"] for kind in schema["anyOf"] if "port" in kind["properties"])
    assert motor["address"]["minimum"] == 1
    assert motor["port"]["description"] == "serial port"
    assert motor["stops_mm"]["unit"] == "mm"
    assert motor["kind"]["const"] == "motor"


def test_everything_chosen_is_written_out():
    dumped = validate(File, {"stage": {"kind": "motor", "port": "x"}}, "f").model_dump(mode="json")
    assert dumped["stage"] == {"kind": "motor"} | dataclasses.asdict(Motor(port="x")) | {
        "stops_mm": [1.0]
    }


class WithOptics(SettingsModel):
    optics: str


def test_further_keys_are_not_among_the_settings():
    model = model_with(WithOptics, Hand, "hand")
    assert model.model_validate({"optics": "o.json"}).settings() == Hand()
