"""What is wrong with a kind of device, and with how its functions can be called."""

from __future__ import annotations

from dataclasses import replace

import pytest

from drivers.cameras import CAMERAS
from drivers.cameras.contract import CameraKind
from drivers.cameras.contract import faults as camera_faults
from drivers.kinds import call_fault


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
