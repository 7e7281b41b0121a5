"""The page of a folder of photographs: click once, look at every curve, accept or refuse."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response
from pydantic import ConfigDict, Field

from labrig.errors import BadInputError
from labrig.panel.core.panel import Panel
from labrig.panel.core.requests import Here, Name, RequestModel
from labrig.panel.errors import NotNowError
from labrig.panel.pages.interface import PanelPage, own_script
from labrig.panel.photographs.folder import Choice, PhotographFolder
from labrig.panel.photographs.known import Clicked, clicked_facts
from labrig.vision.calibration.optics import StripName, StripPlace
from labrig.vision.facts.contract import FactOf
from labrig.vision.facts.stated import Facts, checked
from labrig.vision.image.overlay import jpeg_bytes, picture_with

router = APIRouter(prefix="/api/photographs")
SHOWN_PX = 2400  # long side of the picture that is clicked on
Pixel = tuple[float, float]
Which = Annotated[str, Query(min_length=1, max_length=400)]
Millimetres = Annotated[float, Field(gt=0, le=10_000)]


class FactsBody(RequestModel):
    """What was clicked, and among it facts by their names."""

    model_config = ConfigDict(extra="allow", allow_inf_nan=False)

    def facts(self, of: FactOf) -> Facts:
        """Return the facts that were clicked. Raises BadInputError."""
        stated = self.model_extra or {}
        kinds = {fact.name: fact for fact in clicked_facts(of)}
        try:
            for name in stated.keys() - kinds.keys():
                raise ValueError(f"{name} is nothing that can be clicked")
            return {key: checked(kinds[key], value, key) for key, value in stated.items() if value}
        except ValueError as error:
            raise BadInputError(f"{error}.") from None


class PlaceBody(FactsBody):
    """A strip's clamp, a second place on the clamped strip, and facts such as its tip."""

    clamp_px: Pixel
    along_px: Pixel | None = None


class KnownBody(FactsBody):
    """What was clicked on a photograph; for it, or for all. Facts of the pictures, too."""

    name: Name
    for_all: bool = False
    clamp: PlaceBody | None = None  # of the only strip
    strips: dict[StripName, PlaceBody] = Field({}, max_length=40)  # of several ones
    ruler_px: tuple[Pixel, Pixel] | None = None
    ruler_mm: Millimetres | None = None
    free_length_mm: Millimetres | None = None
    elongation_mm: Annotated[float, Field(ge=0, le=10_000)] = 0.0
    thickness_mm: Millimetres | None = None

    def clicked(self) -> Clicked:
        """Return it as the folder takes it. Raises BadInputError."""
        places: dict[str, PlaceBody] = dict(self.strips)
        if not places and self.clamp is not None:
            places = {"": self.clamp}
        return Clicked(
            strips={name: _place(place) for name, place in places.items()},
            ruler_px=self.ruler_px,
            ruler_mm=self.ruler_mm,
            facts=self.facts(FactOf.PICTURE),
            lengths_mm=self._lengths_mm(),
        )

    def _lengths_mm(self) -> dict[str, float] | None:
        if self.free_length_mm is None:
            return None
        lengths = {"free_length_mm": self.free_length_mm}
        if self.elongation_mm:
            lengths["elongation_mm"] = self.elongation_mm
        if self.thickness_mm is not None:
            lengths["thickness_mm"] = self.thickness_mm
        return lengths


class DecideBody(RequestModel):
    """Accept or refuse."""

    names: list[Name] = Field(min_length=1, max_length=10_000)
    decision: Choice
    note: Annotated[str, Field(max_length=400)] = ""


class _Folders:
    """The folder that this panel shows, opened when a page first asks."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._open: PhotographFolder | None = None

    def of(self, folder: Path) -> PhotographFolder:
        with self._lock:
            if self._open is None:
                self._open = PhotographFolder(folder)
            return self._open

    def close(self) -> None:
        if self._open is not None:
            self._open.close()


def _folder(panel: Panel) -> PhotographFolder:
    if panel.settings.mode != "photographs":
        raise NotNowError("this panel has no photographs; start it as labrig curves --page FOLDER.")
    return panel.state(_Folders).of(panel.settings.data)


def _place(place: PlaceBody) -> StripPlace:
    facts = place.facts(FactOf.STRIP)
    try:
        there = StripPlace(clamp_px=place.clamp_px, along_px=place.along_px)
    except ValueError:
        raise BadInputError("the direction is the clamp itself; click another place.") from None
    return there.model_copy(update={"facts": facts})


@router.get("")
def listed(panel: Here, since: Annotated[int, Query(ge=0)] = 0) -> Any:
    """Return the photographs that have changed since a revision, and how many wait."""
    return _folder(panel).listing(since)


@router.get("/details")
def details(panel: Here, name: Which) -> Any:
    """Return a photograph's curves, and what is known of it."""
    return _folder(panel).details(name)


@router.get("/thumbnail")
def thumbnail(panel: Here, name: Which) -> Response:
    """Return the small picture, a JPEG with the curves on it."""
    return Response(_folder(panel).thumbnail(name), media_type="image/jpeg")


@router.get("/picture")
def picture(panel: Here, name: Which) -> Response:
    """Return the picture that is clicked on, a JPEG of at most 2400 pixels."""
    image = _folder(panel).image(name)
    drawn = picture_with(image, [], min(SHOWN_PX, max(image.shape[:2])))
    return Response(jpeg_bytes(drawn), media_type="image/jpeg")


@router.post("/known")
def known(request: Request, body: KnownBody, panel: Here) -> Any:
    """Write what was clicked, for one photograph or for all, and measure again."""
    who = panel.acting(request)
    done = _folder(panel).set_known(body.name, body.clicked(), for_all=body.for_all)
    panel.log(who, f"stated {', '.join(done['written'])} on {body.name}", note=False)
    return done


@router.post("/decide")
def decide(request: Request, body: DecideBody, panel: Here) -> Any:
    """Accept or refuse photographs."""
    who = panel.acting(request)
    _folder(panel).decide(body.names, body.decision, who, body.note)
    return {"ok": True}


@router.post("/tables")
def tables(request: Request, panel: Here) -> Any:
    """Write the tables of all photographs."""
    panel.acting(request)
    return {"written": _folder(panel).write_tables()}


PAGE = PanelPage(
    title="Photographs",
    order=5,
    modes=frozenset({"photographs"}),
    opens=frozenset({"photographs"}),
    router=router,
    script=own_script("photographs"),
)
