"""Dataclasses as JSON and back: nothing lost, nothing guessed."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import pytest

from labrig.serialise import SerialiseError, finite, from_json, from_plain, to_json, to_plain


class Colour(StrEnum):
    RED = "red"
    BLUE = "blue"


@dataclass(frozen=True)
class Inner:
    """A part."""

    name: str
    value: float | None = None


@dataclass(frozen=True)
class Everything:
    """A field of each type that is known."""

    whole: int
    number: float
    yes: bool
    colour: Colour
    mode: Literal["a", "b"]
    inner: Inner
    maybe: Inner | None
    pair: tuple[int, str]
    many: tuple[Inner, ...]
    names: list[str]
    table: Mapping[str, float]
    by_index: dict[int, str]
    values: npt.NDArray[np.float64]
    either: int | str
    free: Any = None
    extra: Mapping[str, Any] = field(default_factory=dict)


def everything(**changes: Any) -> Everything:
    given: dict[str, Any] = {
        "whole": 3,
        "number": 0.1,
        "yes": True,
        "colour": Colour.BLUE,
        "mode": "a",
        "inner": Inner("x", 1.5),
        "maybe": None,
        "pair": (1, "one"),
        "many": (Inner("y"), Inner("z", -0.0)),
        "names": ["ä", ""],
        "table": {"N": math.inf},
        "by_index": {7: "seven"},
        "values": np.array([[1.0, np.nan], [np.inf, -np.inf]]),
        "either": "text",
        "free": {"list": [1, None]},
    }
    return Everything(**(given | changes))


def test_every_type_survives_json():
    one = everything()
    again = from_json(Everything, to_json(one))
    np.testing.assert_array_equal(again.values, one.values)
    assert {**vars(again), "values": 0} == {**vars(one), "values": 0}
    assert to_plain(again) == to_plain(one)


@pytest.mark.parametrize("number", [0.1, -0.0, 5e-324, 1e308, math.inf, -math.inf, math.nan])
def test_every_number_survives_json(number):
    again = from_json(Everything, to_json(everything(number=number))).number
    assert np.array(again).tobytes() == np.array(number).tobytes()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"whole": 1.0}, "Everything.whole: a int is wanted, not 1.0"),
        ({"whole": True}, "whole: a int is wanted, not True"),
        ({"number": "1"}, "number: a float is wanted, not '1'"),
        ({"number": True}, "number: a float is wanted, not True"),
        ({"yes": 1}, "yes: a bool is wanted, not 1"),
        ({"colour": "green"}, "colour: 'green' is none of red, blue"),
        ({"mode": "c"}, "mode: 'c' is none of a, b"),
        ({"inner": None}, "inner: a table is wanted, not None"),
        ({"inner": {"value": 1.0}}, "inner: the key 'name' is missing"),
        ({"many": {}}, "many: a list is wanted"),
        ({"many": [{"name": 3}]}, r"many\[0\].name: a str is wanted, not 3"),
        ({"pair": [1]}, "pair: 2 values are wanted, not 1"),
        ({"table": []}, "table: a table is wanted"),
        ({"by_index": {"x": "y"}}, "by_index: the key 'x' is no int"),
        ({"values": [1.0, "x"]}, "values: numbers are wanted"),
        ({"values": [[1.0], [1.0, 2.0]]}, "values: numbers are wanted"),
        ({"either": 1.5}, "either: a str is wanted, not 1.5"),
        ({"more": 1}, "the key 'more' is not known"),
    ],
)
def test_what_was_never_written_is_refused_by_the_name_of_its_key(change, says):
    plain = json.loads(to_json(everything())) | change
    with pytest.raises(SerialiseError, match=says):
        from_plain(Everything, plain)


def test_a_lenient_reader_leaves_out_what_a_later_version_has_added():
    plain = json.loads(to_json(everything())) | {"more": 1}
    assert from_plain(Everything, plain, lenient=True).whole == 3


def test_a_key_with_a_default_may_be_missing():
    plain = json.loads(to_json(everything()))
    del plain["extra"]
    assert from_plain(Everything, plain).extra == {}


def test_output_for_others_has_null_for_numbers_that_json_does_not_have():
    assert finite({1: (math.nan, math.inf), "a": np.array([1.0, np.nan])}) == {
        "1": [None, None],
        "a": [1.0, None],
    }
