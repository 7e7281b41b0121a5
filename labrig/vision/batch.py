"""`labrig curves`: images, folders and videos in, curves with their uncertainty out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from labrig.errors import BadInputError
from labrig.vision.calibration.drawing import is_drawing
from labrig.vision.calibration.optics import Optics, SheetAppearance, load_optics
from labrig.vision.curve import FindCurve, NeutralCurve, StripGeometry
from labrig.vision.extraction.extract import neutral_curve
from labrig.vision.image.files import load_strip, write_json, write_overlay
from labrig.vision.image.image import in_levels
from labrig.vision.image.reading import (
    IMAGE_SUFFIXES,
    VIDEO_SUFFIXES,
    Picture,
    PictureLabel,
    Pixels,
    holds_several,
    is_video,
    pictures_in,
    whole_file,
    whole_stem,
)
from labrig.vision.image.tables import LabelledCurve, write_points, write_summary
from labrig.vision.tracking.tracker import Tracker

Progress = Callable[[str, NeutralCurve], None]
PictureCurve = tuple[PictureLabel, Pixels | None, NeutralCurve]
Find = Callable[[Pixels], NeutralCurve]


@dataclass(frozen=True, kw_only=True)
class BatchOptions:
    """What `extract_curves` uses where an image has no files of its own beside it."""

    optics: Path | None = None
    sheet: Path | None = None
    configuration: str | None = None  # which table of the sheet.toml
    overlays: bool = True
    look: SheetAppearance | None = None  # in place of that in optics.json
    find: FindCurve = neutral_curve
    every: int = 1  # of a video's frames and a TIFF's pages the first of each so many


@dataclass
class BatchResult:
    """What came of a batch: each picture's curve, in the order of the pictures."""

    found: list[LabelledCurve] = field(default_factory=list)

    @property
    def curves(self) -> dict[str, NeutralCurve]:
        """The curves by the pictures' names."""
        return {label.name: curve for label, curve in self.found}

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
    for each image (NAME_000012 for a video's frame, NAME_page0012 for a TIFF's page), curves.csv
    and summary.csv. An image that cannot be read, holds no sheet or has a faulty file of its own
    is a result (`ok` false), not an error.
    """
    options = options or BatchOptions()
    found = curves_of(sources, options)
    if options.overlays:
        _keep_photographs(sources, output)
    output.mkdir(parents=True, exist_ok=True)
    result = BatchResult()
    for label, image, curve in found:
        result.found.append((label, curve))
        write_json(output / f"{label.file_stem}.json", label, curve)
        if options.overlays and image is not None:
            write_overlay(output / f"{label.file_stem}_curve.png", image, curve)
        if progress is not None:
            progress(label.name, curve)
    write_points(output / "curves.csv", result.found)
    write_summary(output / "summary.csv", result.found)
    return result


def curves_of(sources: Sequence[Path], options: BatchOptions) -> Iterator[PictureCurve]:
    """Return label, image (None: unreadable) and curve of each picture, one after the other.

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
            yield from (p for p in inside if not is_drawing(p))
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
    for path in files:
        many = seen.get(whole_stem(path.stem))
        if many is not None and many != path and holds_several(many):
            raise BadInputError(
                f"{path} is named as a frame or page of {many} is, and both would be written to "
                f"{path.stem}.json; rename one, or run them into different folders."
            )


def _keep_photographs(sources: Sequence[Path], output: Path) -> None:
    """Raise BadInputError where an overlay would be written over a photograph of the batch."""
    files = list(_files(sources))
    photographs = {path.resolve() for path in files}
    for path in files:
        overlay = output / f"{path.stem}_curve.png"
        if overlay.resolve() in photographs:
            raise BadInputError(
                f"the overlay of {path} would be written over {overlay}; choose another folder "
                "with -o."
            )


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


def _curves_of(path: Path, options: BatchOptions) -> Iterator[PictureCurve]:
    try:
        optics, strip = _known(path, options)
        find = _finder(optics, strip, options.find, follow=is_video(path))
        for picture in pictures_in(path, options.every):
            yield picture.label, picture.image, _found(picture, find)
    except BadInputError as error:
        yield whole_file(path), None, NeutralCurve(ok=False, why=str(error))


def _finder(optics: Optics, strip: StripGeometry, find: FindCurve, *, follow: bool) -> Find:
    """Return what finds the curve of one picture; with `follow` from that of the one before."""
    if follow:
        tracker = Tracker(optics, strip, find)
        return lambda image: tracker.curve(in_levels(image, optics))
    return lambda image: find(in_levels(image, optics), optics, strip)


def _found(picture: Picture, find: Find) -> NeutralCurve:
    if picture.image is None:
        return NeutralCurve(ok=False, why=picture.why)
    try:
        return find(picture.image)
    except BadInputError as error:
        return NeutralCurve(ok=False, why=str(error))


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
