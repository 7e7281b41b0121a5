"""Choose a curve extractor by its name, and keep its failures to the image they belong to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy.typing as npt

from drivers.plugins import PluginFolder, UnknownPartError
from labrig.errors import BadArgumentError, type_in_words
from labrig.extractors.conformance import faults, faults_of_curve
from labrig.extractors.contract import CurveExtractor
from labrig.vision import NeutralCurve, Optics, StripGeometry

BUILT_IN: Final = "intensity_fit"
EXTRACTORS: Final[PluginFolder[CurveExtractor]] = PluginFolder(
    what="curve extractor",
    package="labrig.extractors",
    constant="EXTRACTOR",
    group="labrig.extractors",
    faults=faults,
)


@dataclass(frozen=True)
class ChosenExtractor:
    """An extractor, its name and its distribution with the version ("labrig" for our own)."""

    name: str
    origin: str
    extractor: CurveExtractor

    @property
    def is_built_in(self) -> bool:
        """Whether it is the one used when none is named."""
        return self.name == BUILT_IN

    def curve(
        self,
        image: npt.NDArray[Any],
        optics: Optics,
        strip: StripGeometry,
        *,
        start: NeutralCurve | None = None,
    ) -> NeutralCurve:
        """Return its curve; what it raises, or returns against the contract, is a reason."""
        try:
            found: object = self.extractor.curve(image, optics, strip, start=start)
        except (Exception, SystemExit) as error:  # noqa: BLE001 - other people's code may raise anything
            said = " ".join(str(error).split()).rstrip(".")  # OpenCV's has several lines
            return self._refusal(f"failed with {type(error).__name__}: {said}")
        if not isinstance(found, NeutralCurve):
            return self._refusal(f"returned {type(found).__name__}, not a NeutralCurve")
        wrong = faults_of_curve(found)
        return self._refusal("returned no valid curve: " + "; ".join(wrong)) if wrong else found

    def _refusal(self, what: str) -> NeutralCurve:
        return NeutralCurve(ok=False, why=f"the curve extractor '{self.name}' {what}.")


def chosen_extractor(name: str = BUILT_IN, *, option: str = "extractor") -> ChosenExtractor:
    """Return the extractor of this name. Raises BadInputError, which lists those there are."""
    if not isinstance(name, str):  # a caller may give anything
        raise BadArgumentError(f"{option}: a text is needed, not {type_in_words(name)}.", option)
    try:
        extractor = EXTRACTORS.get(name)
    except UnknownPartError as error:
        raise BadArgumentError(f"{option}: {error}.", option) from None
    part = EXTRACTORS.parts()[name]
    return ChosenExtractor(name, f"{part.distribution} {part.version}".strip(), extractor)
