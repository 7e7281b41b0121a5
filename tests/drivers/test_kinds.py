"""What is wrong with a kind of device, and with how its functions can be called."""

from __future__ import annotations

from dataclasses import field, make_dataclass, replace

import pytest

from drivers.cameras import CAMERAS
from drivers.cameras.contract import CameraKind, CameraSettings
from drivers.cameras.contract import faults as camera_faults
from drivers.interfaces import is_reserved
from drivers.kinds import call_fault
from labrig.config.parts import PartConfig


@pytest.mark.parametrize(
    "function", [lambda a, b: None, lambda *every: None, lambda a, b, c=1: None, print]
)
def test_a_function_that_takes_the_arguments_has_no_fault(function: object) -> None:
    assert call_fault("make", function, ("a", "b")) == ""


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (lambda a: None, "its make cannot be called as make(a, b): too many positional arguments"),
        (lambda a, b, c: None, "missing a required argument: 'c'"),
        ("make", "its make cannot be called"),
    ],
)
def test_a_function_that_cannot_take_them_has_one(function: object, said: str) -> None:
    assert said in call_fault("make", function, ("a", "b"))


def test_a_kind_of_camera_whose_make_takes_too_little_is_refused_when_it_is_loaded() -> None:
    kind = CameraKind(kind="narrow", help="a camera", make=lambda settings: None)  # type: ignore[arg-type,misc]
    assert camera_faults(kind) == [
        "its make cannot be called as make(settings, clock, rate_hz): too many positional arguments"
    ]


def test_a_kind_of_camera_whose_sets_are_no_set_is_told_so() -> None:
    kind = replace(CAMERAS.get("opencv"), sets="gain")  # type: ignore[arg-type]
    assert camera_faults(kind) == ["its sets are 'gain', not names such as frozenset({\"gain\"})"]


@pytest.mark.parametrize("name", ["settings", "kind", "acquisition", "model_dump"])
def test_a_setting_that_takes_the_place_of_what_every_table_has_is_named(name: str) -> None:
    own = (name, int, field(default=1, metadata={"description": "x"}))
    settings = make_dataclass("Own", [own], bases=(CameraSettings,), frozen=True, kw_only=True)
    kind = replace(CAMERAS.get("opencv"), settings=settings)
    assert camera_faults(kind) == [
        f"its setting {name} has a name that every table uses itself; choose another"
    ]


def test_no_field_may_have_a_name_that_the_model_of_a_table_has() -> None:
    own = set(PartConfig.model_fields)  # `kind`, which a driver's settings cannot have either
    assert [name for name in dir(PartConfig) if not is_reserved(name) and name not in own] == []
    assert not is_reserved("rate_hz")


@pytest.mark.parametrize(
    ("prefix", "said"),
    [
        ("gentl:", "its prefix gentl: is that of the camera gentl"),
        ("http:", "its prefix http: is that of addresses, which OpenCV opens"),
        ("http", "its prefix is 'http' where a word and a colon are needed, such as \"iidc:\""),
        ("c:", "its prefix is 'c:' where a word and a colon are needed, such as \"iidc:\""),
        (None, 'its prefix is None where a word and a colon are needed, such as "iidc:"'),
    ],
)
def test_a_prefix_that_is_not_a_cameras_own_is_refused(prefix: str, said: str) -> None:
    kind = replace(CAMERAS.get("opencv"), kind="mine", prefix=prefix)
    assert camera_faults(kind) == [said]


def test_our_own_cameras_have_their_prefixes() -> None:
    assert [camera_faults(part.part) for part in CAMERAS.own().values()] == [[]] * 4
