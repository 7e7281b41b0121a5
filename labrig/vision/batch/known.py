"""What is known of an image: its optics and sheet, from its own files or those of the batch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from labrig.errors import BadInputError
from labrig.vision.batch.options import BatchOptions
from labrig.vision.calibration.optics import Optics, listed, load_optics
from labrig.vision.curve import StripGeometry
from labrig.vision.facts.catalogue import strip_facts
from labrig.vision.facts.contract import FactOf
from labrig.vision.facts.stated import joined
from labrig.vision.image.beside import OPTICS_FILE, SHEET_FILE, beside, missing
from labrig.vision.image.files import load_strip

UNSTATED_LENGTH_M = 0.05  # stands for a length that is measured


def strips_of(path: Path, options: BatchOptions) -> dict[str, tuple[Optics, StripGeometry]]:
    """Return what is known of each strip of an image, by its name."""
    found = optics_of(path, options)
    sheet = sheet_of(path, options, found)
    return {
        name: (optics, _strip(sheet, options, name, optics))
        for name, optics in found.by_strip().items()
    }


def _strip(sheet: Path | None, options: BatchOptions, name: str, optics: Optics) -> StripGeometry:
    if sheet is None:  # nothing is stated: all is measured
        return StripGeometry(
            free_length_m=UNSTATED_LENGTH_M, thickness_known=False, length_known=False
        )
    strip = load_strip(sheet, options.configuration, name)
    measured = optics.constraints.length_measured
    return replace(strip, length_known=False, elongation_m=0.0) if measured else strip


def measures_length(optics: Optics) -> bool:
    """Return whether the length of each strip is measured, so that none need be stated."""
    return all(each.constraints.length_measured for each in optics.by_strip().values())


def optics_of(path: Path, options: BatchOptions) -> Optics:
    """Return what is known of an image's camera: from its own file, one for all, or `options`."""
    optics = beside(path, OPTICS_FILE, options.optics)
    if optics is None:
        raise BadInputError(missing(path, OPTICS_FILE))
    known = load_optics(optics)
    changed: dict[str, object] = {}
    if options.look is not None:
        changed["look"] = options.look
    if options.strips is not None:
        kept = known.facts_that_are(FactOf.PICTURE)
        changed |= {"strips": dict(options.strips), "facts": kept}
    if options.channel is not None:
        changed["channel"] = options.channel
    return _with_facts(known.model_copy(update=changed), options.facts)


def _with_facts(known: Optics, stated: Mapping[str, Any]) -> Optics:
    """Return what is known with the facts that are stated on the command line."""
    kinds = strip_facts()
    for name, value in stated.items():
        fact = kinds[name]
        if known.strips and fact.of == FactOf.STRIP:
            raise BadInputError(
                f"{fact.option.flag}: optics.json has several strips; state {name} in the entry "
                f"of one of them ({listed([*known.strips])})."
            )
        there = fact.directed(known, value)
        if isinstance(there, Optics):
            known = there
        else:
            both = joined(fact, known.facts.get(name), value)
            known = known.model_copy(update={name: both})
    return known


def sheet_of(path: Path, options: BatchOptions, optics: Optics) -> Path | None:
    """Return the sheet.toml that an image uses; None where it needs none."""
    sheet = beside(path, SHEET_FILE, options.sheet)
    if sheet is None and not measures_length(optics):
        raise BadInputError(missing(path, SHEET_FILE))
    return sheet
