"""optics.json: the camera's parameters, and the map between the sheet's plane and pixels.

World coordinates (m): origin at the clamp, x along the clamped sheet, y up in the image. An
integer pixel coordinate is a pixel's centre. The lens is OpenCV's model; points are undistorted,
images never are, so that no interpolation touches the intensities.
"""

from __future__ import annotations

import json
import math
from enum import StrEnum
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, model_validator

from labrig.config.base import parse_json, read_text, validate
from labrig.config.file_kinds import OPTICS, refuse_other_kind
from labrig.errors import BadInputError
from labrig.files import AnyPath, path_of
from labrig.vision.calibration.lens import distort, undistort
from labrig.vision.facts.catalogue import strip_facts
from labrig.vision.facts.contract import FactOf
from labrig.vision.facts.stated import StatesFacts
from labrig.vision.facts.values import Point, Polygon
from labrig.vision.thresholds import DIRECTION_MIN_PX, SCALE_MAX_PX_PER_MM
from model.measurements.known_arguments import known_arguments

FloatArray = npt.NDArray[np.float64]
Row = tuple[float, float, float]
StripName = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,39}$")]


class StripPlace(StatesFacts):
    """Where one of several strips of a picture is clamped, and the facts of it."""

    facts_of: ClassVar[frozenset[FactOf]] = frozenset({FactOf.STRIP})

    clamp_px: Point = Field(description="where the strip leaves the clamp, a raw pixel")
    along_px: Point | None = Field(
        None, description="a raw pixel further along the clamped strip's line; states its direction"
    )

    @model_validator(mode="after")
    def _states_a_direction(self) -> Self:
        if self.along_px is not None and math.dist(self.along_px, self.clamp_px) < 1:
            raise ValueError("along_px must be another pixel than clamp_px")
        return self


class SheetAppearance(StrEnum):
    """What shows of the sheet beside its near edge."""

    AUTO = "auto"  # to be found out
    LIT_EDGE = "lit_edge"  # its face is darker (or less dark) than the edge
    SILHOUETTE = "silhouette"  # its face is as dark (or bright) as the edge


class ColourChannel(StrEnum):
    """Which values of a colour image are used."""

    AUTO = "auto"  # grey, or where edges are looked for the channel that shows them best
    GREY = "grey"
    RED = "red"
    GREEN = "green"
    BLUE = "blue"
    RED_GREEN = "red-green"  # differences: what differs in colour but not in brightness
    RED_BLUE = "red-blue"
    GREEN_BLUE = "green-blue"


class Optics(StatesFacts):
    """optics.json. Only `px_per_mm` and `clamp_px` are required."""

    px_per_mm: float = Field(gt=0, le=SCALE_MAX_PX_PER_MM, description="scale in the sheet's plane")
    clamp_px: Point = Field(description="where the sheet leaves the clamp, a raw pixel")
    image_size: tuple[Annotated[int, Field(gt=0)], Annotated[int, Field(gt=0)]] | None = Field(
        None, description="columns and rows of the images this calibration belongs to"
    )
    date: str | None = Field(None, description="when it was calibrated, ISO 8601")
    px_per_mm_sigma: float = Field(0.0, ge=0, description="standard uncertainty of px_per_mm")
    roll_rad: float = Field(0.0, ge=-math.tau, le=math.tau, description="rotation of the camera")
    roll_sigma_rad: float = Field(0.0, ge=0, description="standard uncertainty of roll_rad")
    origin_px: Point | None = Field(None, description="the world's origin, undistorted pixel")
    origin_sigma_px: float = Field(0.0, ge=0, description="standard uncertainty of the origin")
    camera_matrix: tuple[Row, Row, Row] | None = None
    distortion: tuple[float, ...] | None = Field(
        None, min_length=4, max_length=8, description="k1, k2, p1, p2[, k3[, k4, k5, k6]]"
    )
    homography: tuple[Row, Row, Row] | None = Field(
        None,
        description="world (x, y) in mm -> undistorted pixels, where the camera is not quite "
        "square to the plane; it then stands instead of px_per_mm, roll_rad and origin_px",
    )
    clamp_angle_rad: float = Field(0.0, ge=-math.tau, le=math.tau)
    clamp_angle_known: bool = Field(
        default=True, description="false: the direction at the clamp is found in each image"
    )
    clamp_sigma_px: float = Field(1.0, gt=0, description="how well clamp_px is known")
    clamp_angle_sigma_rad: float = Field(0.015, gt=0)
    polarity: Literal["auto", "bright", "dark"] = Field(
        "auto", description="bright: the sheet is brighter than the background"
    )
    look: SheetAppearance = Field(
        SheetAppearance.AUTO,
        description="what shows of the sheet beside its near edge: a face that is darker "
        "(lit_edge), or one as dark (or bright) as the edge (silhouette)",
    )
    channel: ColourChannel = Field(
        ColourChannel.AUTO,
        description="which values of a colour image are used: grey, one colour, or "
        "the difference of two",
    )
    bits: int = Field(8, ge=8, le=16)
    rolls_px: tuple[Row, ...] | None = Field(None, description="u, v, radius of each roll")
    strips: dict[StripName, StripPlace] | None = Field(
        None, min_length=1, description="several strips in one picture, each with its clamp"
    )
    method: str | None = Field(None, description="how it was calibrated")
    residual_px: float | None = Field(None, ge=0, description="RMS of the calibration, pixels")
    residual_um: float | None = Field(None, ge=0, description="RMS of the calibration, um")
    views: int | None = Field(None, ge=1)
    note: str | None = None

    @model_validator(mode="after")
    def _lens_is_complete(self) -> Self:
        if self.has_lens and self.camera_matrix is None:
            raise ValueError("distortion needs camera_matrix beside it")
        if self.camera_matrix is not None:
            (fx, _, _), (_, fy, _), _ = self.camera_matrix
            if fx <= 0 or fy <= 0:
                raise ValueError("camera_matrix must have positive focal lengths on its diagonal")
        return self

    @model_validator(mode="after")
    def _places_belong_to_one_strip(self) -> Self:
        if self.strips and self.facts_that_are(FactOf.STRIP):
            names = [fact.name for fact in strip_facts().values() if fact.of == FactOf.STRIP]
            raise ValueError(f"with several strips, each states its own {listed(names)}")
        return self

    @model_validator(mode="after")
    def _clamps_are_in_the_image(self) -> Self:
        clamps = (place.clamp_px for place in (self.strips or {}).values())
        for clamp_px in (self.clamp_px, *clamps):
            found = outside(clamp_px, "clamp_px", self.image_size)
            if found:
                raise ValueError(found)
        return self

    @classmethod
    def from_json(cls, text: str, name: str = "optics.json") -> Self:
        """Return the text of an optics.json; `name` is the file's name for the errors."""
        refuse_other_kind(text, name, OPTICS)
        data = parse_json(text, name)
        if not isinstance(data, dict):
            raise BadInputError(f"{name}: must hold one JSON object with px_per_mm and clamp_px.")
        return validate(cls, data, name)

    def to_json(self) -> str:
        """Return the text for an optics.json, without the entries that are not known."""
        data: dict[str, Any] = self.model_dump(exclude_none=True)
        return json.dumps(data, indent=1) + "\n"

    def by_strip(self) -> dict[str, Self]:
        """Return what is known for each strip by its name; one without a name where there is one.

        Without a homography a strip's coordinates begin at its own clamp and run along it.
        """
        if not self.strips:
            return {"": self}
        return {name: self.at(place) for name, place in self.strips.items()}

    def at(self, place: StripPlace) -> Self:
        """Return what is known for a strip that is clamped at this place."""
        changed: dict[str, object] = {
            "clamp_px": place.clamp_px,
            "facts": self.facts_that_are(FactOf.PICTURE) | place.facts,
            "strips": None,
        }
        if self.homography is None:
            changed["origin_px"] = None
        there = self.model_copy(update=changed)
        return there if place.along_px is None else there.leading_to(place.along_px)

    def leading_to(self, along_px: Point, sigma_rad: float | None = None) -> Self:
        """Return the same for a sheet that leaves the clamp towards a raw pixel.

        `sigma_rad`: how well that states its direction; None: as before. Raises BadInputError
        where it is the clamp itself.
        """
        if math.dist(self.clamp_px, along_px) < DIRECTION_MIN_PX:
            raise BadInputError(
                f"along_px {along_px[0]:g},{along_px[1]:g} is the clamp itself: give a pixel "
                "further along the clamped strip, or leave it out to have the direction measured."
            )
        ends = (self.clamp_px, along_px)
        changed: dict[str, object] = {"clamp_angle_known": True}
        if self.homography is not None:
            first, second = self.pixel_to_world(ends)
            name = "clamp_angle_rad"
        else:
            first, second = self.undistorted(ends)
            name = "roll_rad"
            changed["clamp_angle_rad"] = 0.0
        changed[name] = math.atan2(second[1] - first[1], second[0] - first[0])
        if sigma_rad is not None:
            changed["clamp_angle_sigma_rad"] = sigma_rad
        return self.model_copy(update=changed)

    def without_places(self) -> Self:
        """Return the same without the facts of strips, which belong to one picture."""
        strips = {
            name: place.model_copy(update={"facts": {}})
            for name, place in (self.strips or {}).items()
        }
        kept = self.facts_that_are(FactOf.PICTURE)
        return self.model_copy(update={"facts": kept, "strips": strips or None})

    @property
    def through_px(self) -> tuple[Point, ...] | None:
        """Places on the strip's middle that are known, from the clamp on."""
        return self.constraints.through_px or None

    @property
    def tip_px(self) -> Point | None:
        """Where the strip is known to end."""
        return self.constraints.tip_px

    @property
    def mask_px(self) -> tuple[Polygon, ...] | None:
        """Polygons in which pixels are not used."""
        return self.constraints.hidden_px or None

    @property
    def stated_places_px(self) -> tuple[Point, ...]:
        """Places on the strip that are stated beside the clamp, from it on; often none."""
        return (*(self.through_px or ()), *(() if self.tip_px is None else (self.tip_px,)))

    @property
    def px_per_m(self) -> float:
        """Scale in the sheet's plane, pixels per metre."""
        return self.px_per_mm * 1000.0

    @property
    def has_lens(self) -> bool:
        """Whether the lens bends anything."""
        return self.distortion is not None and any(self.distortion)

    @property
    def is_similarity(self) -> bool:
        """Whether the image is the plane turned and scaled, and nothing else."""
        return self.homography is None and not self.has_lens

    @property
    def origin_undistorted_px(self) -> Point:
        """The world's origin; the clamp when the file names none."""
        if self.origin_px is not None:
            return self.origin_px
        u, v = self.undistorted(np.array([self.clamp_px]))[0]
        return float(u), float(v)

    def undistorted(self, pixels: npt.ArrayLike) -> FloatArray:
        """Return raw pixels (n, 2) -> where an ideal lens had shown them (n, 2)."""
        points = np.asarray(pixels, dtype=float).reshape(-1, 2)
        if not self.has_lens:
            return points
        return undistort(points, np.array(self.camera_matrix), np.array(self.distortion))

    def distorted(self, pixels: npt.ArrayLike) -> FloatArray:
        """Return ideal pixels (n, 2) -> raw pixels (n, 2)."""
        points = np.asarray(pixels, dtype=float).reshape(-1, 2)
        if not self.has_lens:
            return points
        return distort(points, np.array(self.camera_matrix), np.array(self.distortion))

    def world_to_pixel(self, points_m: npt.ArrayLike) -> FloatArray:
        """Return World points (n, 2) in m -> raw pixels (n, 2)."""
        points = np.asarray(points_m, dtype=float).reshape(-1, 2)
        if self.homography is not None:
            return self.distorted(project(np.array(self.homography), points * 1000))
        flipped = points * (self.px_per_m, -self.px_per_m)
        return self.distorted(flipped @ self._rotation().T + self.origin_undistorted_px)

    def pixel_to_world(self, pixels: npt.ArrayLike) -> FloatArray:
        """Return raw pixels (n, 2) -> world points (n, 2) in m."""
        return self.undistorted_to_world(self.undistorted(pixels))

    def clamp_m(self) -> FloatArray:
        """Return where the sheet leaves the clamp, world, shape (2,)."""
        where: FloatArray = self.pixel_to_world([self.clamp_px])[0]
        return where

    def vanishing_px(self, size: tuple[int, int]) -> FloatArray:
        """Return where lines square to the sheet's plane meet, an undistorted pixel, shape (2,).

        `size`: columns and rows of the image, whose middle it is where nothing else is known.
        """
        if self.camera_matrix is None:
            return np.array([(size[0] - 1) / 2, (size[1] - 1) / 2])
        camera = np.array(self.camera_matrix)
        if self.homography is None:
            return np.asarray(camera[:2, 2], dtype=np.float64)
        axes = np.linalg.solve(camera, np.array(self.homography))
        square = np.cross(axes[:, 0], axes[:, 1])
        there = camera @ square
        return np.asarray(there[:2] / there[2], dtype=np.float64)

    def undistorted_to_world(self, pixels: npt.ArrayLike) -> FloatArray:
        """Return pixels of an ideal lens (n, 2) -> world points (n, 2) in m."""
        ideal = np.asarray(pixels, dtype=float).reshape(-1, 2)
        if self.homography is not None:
            back = np.linalg.inv(np.array(self.homography))
            return project(back, ideal) / 1000
        turned = (ideal - self.origin_undistorted_px) @ self._rotation()
        return np.asarray(turned / (self.px_per_m, -self.px_per_m))

    def _rotation(self) -> FloatArray:
        c, s = math.cos(self.roll_rad), math.sin(self.roll_rad)
        return np.array([[c, -s], [s, c]])


def outside(place: Point, name: str, size: tuple[int, int] | None) -> str:
    """Return what is wrong with a pixel that lies outside of an image of this size; mostly ""."""
    if size is None or all(-0.5 <= at < end - 0.5 for at, end in zip(place, size, strict=True)):
        return ""
    return (
        f"{name} ({place[0]:g}, {place[1]:g}) is outside of the image of {size[0]} x {size[1]} "
        "pixels; give its column and row, counted from the upper left"
    )


def listed(names: list[str]) -> str:
    """Return names as a text: "a, b and c"."""
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def project(homography: FloatArray, points: FloatArray) -> FloatArray:
    """Return a homography on points (n, 2)."""
    lifted = points @ homography[:, :2].T + homography[:, 2]
    return np.asarray(lifted[:, :2] / lifted[:, 2:])


@known_arguments
def load_optics(path: AnyPath) -> Optics:
    """Return the optics that an optics.json states. Raises BadInputError."""
    path = path_of(path)
    return Optics.from_json(read_text(path, OPTICS), str(path))
