"""The contract of a fact: what somebody knows of a strip, and what that tells the search.

A fact is one file. It has a name (its key in optics.json), an option of `labrig curves`, and often
a tool of the page, with which it is clicked. Its value is read from any of these, follows the
picture where that is reduced, and tells the search something in raw pixels (`SearchConstraints`).

The shape of its value says how it is read, checked and clicked; a value of the shape OTHER needs
methods of its own. The module is imported whenever `labrig curves` starts: import what is slow
inside a method.
"""

# ruff: noqa: ARG002 - the methods that a fact overrides do nothing with what they are given

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any, Protocol, Self

from labrig.vision.facts import values

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

Point = values.Point
Polygon = values.Polygon


class FactOf(StrEnum):
    """What a fact is known of."""

    STRIP = "strip"  # one strip in one picture, such as a place on it
    PICTURE = "picture"  # whatever is in the pictures, such as what is hidden in each


class FactShape(StrEnum):
    """What the value of a fact is made of, in raw pixels."""

    POINT = "point"  # (column, row)
    POINTS = "points"  # of these one or more, in their order
    POLYGONS = "polygons"  # of at least three points each
    FLAG = "flag"  # True
    OTHER = "other"  # whatever JSON can hold


@dataclass(frozen=True, kw_only=True)
class FactOption:
    """The option of the command line that states a fact."""

    flag: str  # "--tip-px"
    help: str
    repeated: bool = False  # whether it may be given several times; `joined` puts these together


@dataclass(frozen=True, kw_only=True)
class FactTool:
    """The tool of the page with which a fact is clicked: a point, points or polygons."""

    label: str  # of its button
    hint: str  # what is clicked, a sentence
    noun: str  # of one click, for "the NOUN lies outside of the picture"


@dataclass(frozen=True, eq=False, kw_only=True)
class SearchConstraints:
    """What facts tell the search of one strip, in raw pixels."""

    through_px: tuple[Point, ...] = ()  # on the strip's middle, from the clamp on
    tip_px: Point | None = None  # where it ends
    hidden_px: tuple[Polygon, ...] = ()  # what is inside is not used
    length_measured: bool = False  # its length is found, whatever is stated
    # asked with the points (n, 2) of a found curve, each returns why that cannot be it, a sentence;
    # empty: it can. What it raises refuses the curve, too.
    objections: tuple[Callable[[FloatArray], str], ...] = ()

    def __post_init__(self) -> None:
        """Raise TypeError where the objections are not a tuple of functions."""
        if not isinstance(self.objections, tuple):  # other people's may be anything
            kind = type(self.objections).__name__  # type: ignore[unreachable]
            raise TypeError(f"its objections are a {kind}, not a tuple of functions")
        if not all(map(callable, self.objections)):
            raise TypeError("its objections are not functions")

    @classmethod
    def together(cls, every: Iterable[SearchConstraints]) -> SearchConstraints:
        """Return what several facts tell; of two tips the first."""
        constraints = list(every)
        tips = [each.tip_px for each in constraints if each.tip_px is not None]
        return cls(
            through_px=tuple(point for each in constraints for point in each.through_px),
            tip_px=tips[0] if tips else None,
            hidden_px=tuple(polygon for each in constraints for polygon in each.hidden_px),
            length_measured=any(
                each.length_measured or each.tip_px is not None for each in constraints
            ),
            objections=tuple(one for each in constraints for one in each.objections),
        )


def objection(objects: Callable[[FloatArray], str], points_px: FloatArray) -> str:
    """Return why a curve cannot be it; empty: it can. Raises TypeError for what is no text."""
    why = objects(points_px.copy())  # what it writes into its points moves no curve
    if not isinstance(why, str):  # other people's may be anything
        raise TypeError(f"its objection returned {why!r}, not a text")
    return why


class Directed(Protocol):
    """What a fact changes that is no more than a direction: the optics."""

    def leading_to(self, along_px: Point, sigma_rad: float | None = None) -> Self:
        """Return the same for a strip that leaves the clamp towards a raw pixel."""


@dataclass(frozen=True, kw_only=True)
class StripFact:
    """One kind of fact."""

    name: str  # its key in optics.json; also of its file
    meaning: str  # of that key
    shape: FactShape
    of: FactOf = FactOf.STRIP
    option: FactOption
    example: str = ""  # as the option takes it; of a flag nothing
    tool: FactTool | None = None
    order: int  # among the options and tools

    def read(self, stated: str) -> Any:
        """Return the value of its option's text.

        Raises ValueError with what to give ("give a pixel's column and row, U,V"), or a LabrigError
        with a whole sentence.
        """
        if self.shape == FactShape.POINT:
            return values.point_of(stated)
        if self.shape == FactShape.POINTS:
            return values.points_of(stated, self.option.flag)
        if self.shape == FactShape.POLYGONS:
            noun = "polygon" if self.tool is None else self.tool.noun
            return values.polygons_of(stated, self.option.flag, self.name, noun)
        raise NotImplementedError

    def checked(self, value: object) -> Any:
        """Return the value of a file or of clicks. Raises ValueError, as `read` does."""
        if self.shape == FactShape.POINT:
            return values.checked_point(value)
        if self.shape == FactShape.POINTS:
            return values.checked_points(value)
        if self.shape == FactShape.POLYGONS:
            return values.checked_polygons(value)
        if self.shape == FactShape.FLAG:
            return values.checked_flag(value)
        raise NotImplementedError

    def moved(self, value: Any, to: Callable[[Point], Point]) -> Any:
        """Return the value in another picture of the same: `to` says where each pixel is there."""
        if self.shape == FactShape.POINT:
            return to(value)
        if self.shape == FactShape.POINTS:
            return tuple(map(to, value))
        if self.shape == FactShape.POLYGONS:
            return tuple(tuple(map(to, polygon)) for polygon in value)
        return value

    def joined(self, before: Any, stated: Any) -> Any:
        """Return the value where one is known (from a file) and another is stated."""
        return stated

    def directed(self, optics: Directed, value: Any) -> Directed | None:
        """Return the optics with the direction at the clamp that this states; None: it states none.

        Such a fact is not kept: the optics are.
        """
        return None

    def constraints(self, value: Any) -> SearchConstraints:
        """Return what this tells the search."""
        return SearchConstraints()

    @property
    def is_direction(self) -> bool:
        """Whether this is a direction at the clamp, which optics.json keeps as `roll_rad`."""
        return type(self).directed is not StripFact.directed
