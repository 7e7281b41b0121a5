"""Conformance of a fact: `faults` returns what is wrong with it."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt

from drivers.plugins import first_faults
from labrig.errors import LabrigError
from labrig.vision.facts.contract import (
    FactOf,
    FactShape,
    SearchConstraints,
    StripFact,
)

FloatArray = npt.NDArray[np.float64]
_FLAG = re.compile(r"--[a-z][a-z0-9]*(-[a-z0-9]+)*")
# keys of optics.json that are no facts; a test holds them equal to those of its model
KEYS_OF_OPTICS = frozenset(
    {
        "bits",
        "camera_matrix",
        "channel",
        "clamp_angle_known",
        "clamp_angle_rad",
        "clamp_angle_sigma_rad",
        "clamp_px",
        "clamp_sigma_px",
        "date",
        "distortion",
        "facts",
        "homography",
        "image_size",
        "look",
        "method",
        "note",
        "origin_px",
        "origin_sigma_px",
        "polarity",
        "px_per_mm",
        "px_per_mm_sigma",
        "residual_px",
        "residual_um",
        "roll_rad",
        "roll_sigma_rad",
        "rolls_px",
        "strips",
        "views",
    }
)
_CLICKED = {FactShape.POINT, FactShape.POINTS, FactShape.POLYGONS}


def faults(fact: object) -> list[str]:
    """Return what is wrong with a fact, a sentence each without its full stop."""
    if not isinstance(fact, StripFact):
        return [f"it is of type {type(fact).__name__}, not a StripFact"]
    return first_faults([lambda: _faults(fact), lambda: _faults_of_value(fact)])


def _faults(fact: StripFact) -> Iterator[str]:
    if not (isinstance(fact.name, str) and fact.name.isidentifier()):
        yield f"its name {fact.name!r} must be one word of letters, digits and underscores"
    if fact.name in KEYS_OF_OPTICS:
        yield f"its name {fact.name!r} is a key of optics.json already"
    if not fact.meaning.strip():
        yield "its meaning is empty"
    if fact.shape not in set(FactShape):
        yield f"its shape must be one of {', '.join(FactShape)}"
    if fact.of not in set(FactOf):
        yield f"`of` must be one of {', '.join(FactOf)}"
    if not isinstance(fact.order, int):  # other people's may be anything
        yield "its order must be a whole number"  # type: ignore[unreachable]
    if not _FLAG.fullmatch(fact.option.flag):
        yield f"its option {fact.option.flag!r} must be lower-case words, as --such-an-option"
    if not fact.option.help.strip():
        yield "its option has no help"
    if fact.tool is not None and fact.shape not in _CLICKED:
        yield f"a value of the shape {fact.shape} cannot be clicked: leave its tool out"
    if fact.shape != FactShape.FLAG and not fact.example.strip():
        yield "it has no example of what its option takes"


def _faults_of_value(fact: StripFact) -> Iterator[str]:
    try:
        value = True if fact.shape == FactShape.FLAG else fact.read(fact.example)
    except (ValueError, LabrigError) as error:
        yield f"its example {fact.example!r} is not read: {str(error).rstrip('.')}"
        return
    kept = fact.checked(json.loads(json.dumps(value)))
    if kept != value:
        yield f"its example is {kept!r} when it comes from a file, and {value!r} as stated"
    if fact.moved(value, lambda place: place) != value:
        yield "its value changes where no pixel moves"
    constraints = fact.constraints(value)
    if not isinstance(constraints, SearchConstraints):  # other people's may be anything
        yield f"`constraints` returned {type(constraints).__name__}, not SearchConstraints"  # type: ignore[unreachable]
        return
    for objects in constraints.objections:
        yield from _faults_of_objection(objects)
    if (
        type(fact).constraints is StripFact.constraints
        and type(fact).directed is StripFact.directed
    ):
        yield "it has neither `constraints` nor `directed`: it says nothing"


def _faults_of_objection(objects: Callable[[FloatArray], str]) -> Iterator[str]:
    """Ask it about a drawn curve."""
    along = np.linspace(0.0, 1.0, 121)
    points_px = np.column_stack([24.0 + 120.0 * along, 75.0 - 30.0 * along**2])
    try:
        why: object = objects(points_px)
    except (Exception, SystemExit) as error:  # noqa: BLE001 - it may raise anything
        yield f"its objection failed with {type(error).__name__}: {error}"
    else:
        if not isinstance(why, str):
            yield f"its objection returned {why!r}, not a text"
