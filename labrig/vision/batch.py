"""`labrig curves`: images, folders and videos in, curves with their uncertainty out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy.typing as npt

from labrig.errors import BadInputError
from labrig.vision.calibration.optics import Optics, SheetAppearance, load_optics
from labrig.vision.curve import FindCurve, NeutralCurve, StripGeometry
from labrig.vision.extraction.extract import neutral_curve
from labrig.vision.image.files import (
    IMAGE_SUFFIXES,
    VIDEO_SUFFIXES,
    load_strip,
    read_image,
    read_video,
    write_json,
    write_overlay,
    write_table,
)
from labrig.vision.tracking.tracker import Tracker

Progress = Callable[[str, NeutralCurve], None]
NamedCurve = tuple[str, npt.NDArray[Any] | None, NeutralCurve]


@dataclass(frozen=True, kw_only=True)
class BatchOptions:
    """What `extract_curves` uses where an image has no files of its own beside it."""

    optics: Path | None = None
    sheet: Path | None = None
    configuration: str | None = None  # which table of the sheet.toml
    overlays: bool = True
    look: SheetAppearance | None = None  # in place of that in optics.json
    find: FindCurve = neutral_curve


@dataclass
class BatchResult:
    """What came of a batch: the curves by name, in the order of the images."""

    curves: dict[str, NeutralCurve] = field(default_factory=dict)

    @property
    def failed(self) -> dict[str, str]:
        """The names without a curve, and why."""
        return {name: c.why for name, c in self.curves.items() if not c.ok}


def extract_curves(
    sources: Sequence[Path],
    output: Path,
    options: BatchOptions | None = None,
    *,
    progress: Progress | None = None,
) -> BatchResult:
    """Return curves of all images and videos in `sources`, written into the folder `output`.

    An image NAME.png takes NAME.optics.json and NAME.sheet.toml from beside it, else those of
    `options`, else optics.json and sheet.toml from beside it. Writes NAME.json and NAME_curve.png
    for each image (NAME_000012 for a video's frame), and curves.csv. An image that cannot be
    read, holds no sheet or has a faulty file of its own is a result (`ok` false), not an error.
    """
    options = options or BatchOptions()
    found = curves_of(sources, options)
    output.mkdir(parents=True, exist_ok=True)
    result = BatchResult()
    for name, image, curve in found:
        result.curves[name] = curve
        write_json(output / f"{name}.json", curve)
        if options.overlays and image is not None:
            write_overlay(output / f"{name}_curve.png", image, curve)
        if progress is not None:
            progress(name, curve)
    write_table(output / "curves.csv", result.curves)
    return result


def curves_of(sources: Sequence[Path], options: BatchOptions) -> Iterator[NamedCurve]:
    """Return name, image (None: unreadable) and curve of each image and frame, one after the other.

    Raises BadInputError at once when there is none, or two of the same name, or where a file that
    serves several is at fault.
    """
    files = list(_files(sources))
    if not files:
        raise BadInputError(
            "no image or video was found; give files or a folder with "
            f"{', '.join(IMAGE_SUFFIXES)} files in it."
        )
    _refuse_twins(files)
    _refuse_common_faults(files, options)
    return (named for path in files for named in _curves_of(path, options))


def _files(sources: Sequence[Path]) -> Iterator[Path]:
    for source in sources:
        if source.is_dir():
            inside = sorted(
                p for p in source.iterdir() if p.suffix.lower() in IMAGE_SUFFIXES + VIDEO_SUFFIXES
            )
            yield from (p for p in inside if not p.stem.endswith("_curve"))
        elif source.exists():
            yield source
        else:
            raise BadInputError(f"{source}: there is no such file or folder.")


def _refuse_twins(files: list[Path]) -> None:
    seen: dict[str, Path] = {}
    for path in files:
        if path.stem in seen:
            raise BadInputError(
                f"{seen[path.stem]} and {path} would both be written to {path.stem}.json; "
                "rename one, or run them into different folders."
            )
        seen[path.stem] = path


def _refuse_common_faults(files: list[Path], options: BatchOptions) -> None:
    """Raise for a fault in a file of several images; one in an own file costs that image only."""
    kinds: tuple[tuple[str, Path | None, Callable[[Path], object]], ...] = (
        ("optics.json", options.optics, load_optics),
        ("sheet.toml", options.sheet, lambda path: load_strip(path, options.configuration)),
    )
    for kind, given, load in kinds:
        found = {path: _beside(path, kind, given) for path in files}
        if not any(found.values()):
            raise BadInputError(_missing(files[0], kind))
        for common in {each for path, each in found.items() if each != _own(path, kind)}:
            if common is not None:
                load(common)


def _curves_of(path: Path, options: BatchOptions) -> Iterator[NamedCurve]:
    image = None
    try:
        optics, strip = _known(path, options)
        if path.suffix.lower() in VIDEO_SUFFIXES:
            tracker = Tracker(optics, strip, options.find)
            for number, frame in enumerate(read_video(path)):
                yield f"{path.stem}_{number:06d}", frame, tracker.curve(frame)
            return
        image = read_image(path)
        curve = options.find(image, optics, strip)
    except BadInputError as error:
        curve = NeutralCurve(ok=False, why=str(error))
    yield path.stem, image, curve


def _known(path: Path, options: BatchOptions) -> tuple[Optics, StripGeometry]:
    """Return what is known of an image from the files beside it, or those for all."""
    optics = _beside(path, "optics.json", options.optics)
    sheet = _beside(path, "sheet.toml", options.sheet)
    if optics is None or sheet is None:
        raise BadInputError(_missing(path, "sheet.toml" if optics else "optics.json"))
    known = load_optics(optics)
    if options.look is not None:
        known = known.model_copy(update={"look": options.look})
    return known, load_strip(sheet, options.configuration)


def _beside(path: Path, kind: str, given: Path | None) -> Path | None:
    """Return the file of a kind that an image uses; None where there is none."""
    for candidate in (_own(path, kind), given, path.with_name(kind)):
        if candidate is not None and (candidate.exists() or candidate is given):
            return candidate
    return None


def _own(path: Path, kind: str) -> Path:
    return path.with_name(f"{path.stem}.{kind}")


def _missing(path: Path, kind: str) -> str:
    own = _own(path, kind).name
    return f"{path}: there is neither {own} nor {kind} beside it; name one for all images."
