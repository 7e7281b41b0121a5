"""`labrig curves`: images, folders and videos in, curves with their uncertainty out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from labrig.errors import BadInputError
from labrig.vision.batch.known import strips_of
from labrig.vision.batch.options import BatchOptions
from labrig.vision.batch.resuming import KeptCurves, digest_of
from labrig.vision.batch.sources import (
    ADDED_BESIDE,
    ADDED_IN_RESULTS,
    files_of,
    keep_photographs,
    refuse_common_faults,
    refuse_long_names,
    refuse_twins,
    tell_of_drawings,
    tell_of_subfolders,
    tell_of_unused_corrections,
)
from labrig.vision.calibration.optics import Optics
from labrig.vision.checks.catalogue import origins
from labrig.vision.checks.objections import heeding
from labrig.vision.curve import FindCurve, NeutralCurve, StripGeometry
from labrig.vision.extraction.extract import neutral_curve
from labrig.vision.facts.catalogue import origin_of
from labrig.vision.image.colour_notes import ColourNotes
from labrig.vision.image.files import write_json
from labrig.vision.image.image import in_levels
from labrig.vision.image.names import (
    IMAGE_SUFFIXES,
    Picture,
    PictureLabel,
    is_video,
    picture_name,
    whole_file,
)
from labrig.vision.image.overlay import write_overlay
from labrig.vision.image.reading import Pixels, pictures_in
from labrig.vision.image.review import PictureDecision, load_review
from labrig.vision.image.tables import (
    LabelledCurve,
    refuse_other_tables,
    write_points,
    write_summary,
)
from labrig.vision.tracking.tracker import Tracker

Progress = Callable[[str, NeutralCurve], None]
PictureCurve = tuple[PictureLabel, Pixels | None, NeutralCurve]
Find = Callable[[Pixels], NeutralCurve]


@dataclass
class BatchResult:
    """What came of a batch: each picture's curve, in the order of the pictures."""

    found: list[LabelledCurve] = field(default_factory=list)
    kept: int = 0  # how many of them an earlier batch measured

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
    for each image (NAME_000012 for a video's frame, NAME_page0012 for a TIFF's page; of NAME.png
    and NAME.jpg in one folder NAME.png.json and NAME.jpg.json, and so on), curves.csv and
    summary.csv; these have what was measured, too, where the batch is stopped. The next batch into
    the same folder uses the curves again of which neither image nor optics, sheet, options or
    labrig have changed, where labrig's own extractor, checks and facts found them. An image that
    cannot be read, holds no sheet or has a faulty file of its own is a result (`ok` false), not an
    error.
    """
    options = options or BatchOptions()
    points, summary = output / "curves.csv", output / "summary.csv"
    refuse_other_tables(points, summary)
    kept = KeptCurves(output)
    found = curves_of(sources, options, kept)
    if options.overlays:
        keep_photographs(sources, output)
    output.mkdir(parents=True, exist_ok=True)
    result = BatchResult()
    written: set[str] = set()
    try:
        for label, image, curve in found:
            if label.file_stem in written:
                raise BadInputError(
                    f"{label.name} would be written over {label.file_stem}.json of another image; "
                    "rename the image or the strip."
                )
            written.add(label.file_stem)
            write_json(output / f"{label.file_stem}.json", label, curve)
            overlay = output / f"{label.file_stem}_curve.png"
            there = label.file_stem in kept.used and overlay.exists()
            if options.overlays and image is not None and not there:
                write_overlay(overlay, image, curve)
            result.found.append((label, curve))
            result.kept = len(kept.used)
            if progress is not None:
                progress(label.name, curve)
    finally:  # also where the batch is stopped: what was measured is kept
        write_points(points, result.found)
        write_summary(summary, result.found)
    return result


def curves_of(
    sources: Sequence[Path], options: BatchOptions, kept: KeptCurves | None = None
) -> Iterator[PictureCurve]:
    """Return label, image (None: unreadable) and curve of each picture, one after the other.

    What is `kept` is not measured again; each curve is kept once the next one is asked for.
    Raises BadInputError at once when there is none, or two of the same name, or where a file that
    serves several is at fault.
    """
    files = list(files_of(sources))
    tell_of_drawings(sources)
    if not files:
        raise BadInputError(
            "no image or video was found; give files or a folder with "
            f"{', '.join(IMAGE_SUFFIXES)} files in it."
        )
    refuse_long_names(files, ADDED_BESIDE if kept is None else ADDED_IN_RESULTS)
    refuse_twins(files)
    tell_of_subfolders(sources)
    tell_of_unused_corrections(sources, options)
    refuse_common_faults(files, options)
    decided = {folder: load_review(folder) for folder in {path.parent for path in files}}
    return (
        named for path in files for named in _curves_of(path, options, decided[path.parent], kept)
    )


def _curves_of(
    path: Path,
    options: BatchOptions,
    decided: Mapping[str, PictureDecision],
    kept: KeptCurves | None,
) -> Iterator[PictureCurve]:
    try:
        known = strips_of(path, options)
        finders = {
            name: _Finder(optics, strip, options.find, follow=is_video(path))
            for name, (optics, strip) in known.items()
        }
        refused = {name: one for name, one in decided.items() if one.decision == "refused"}
        digest = _digest(path, known, options, refused) if kept is not None else ""
        notes = ColourNotes()
        for picture in pictures_in(path, options.every):
            decision = refused.get(picture.label.name)
            for name, finder in finders.items():
                label = picture.label.of_strip(name)
                measured = "" if decision is not None or picture.image is None else digest
                before = kept.curve(label.file_stem, measured) if kept is not None else None
                if decision is not None:
                    curve = NeutralCurve(ok=False, why=decision.why_refused)
                elif before is not None:
                    curve = finder.taken(before)
                else:
                    curve = _found(picture, finder.curve)
                # of the images of one file it is told once
                told = curve if picture.label.frame is None else notes.once(curve)
                yield label, picture.image, told
                if kept is not None:
                    kept.keep(label.file_stem, curve, measured)
    except BadInputError as error:
        label = whole_file(path)
        if kept is not None:
            kept.curve(label.file_stem, "")
        yield label, None, NeutralCurve(ok=False, why=str(error))


def _digest(
    path: Path,
    known: Mapping[str, tuple[Optics, StripGeometry]],
    options: BatchOptions,
    refused: Mapping[str, PictureDecision],
) -> str:
    """Return what stands for all that makes the curves and overlays of a file; empty: unknown."""
    facts = {name for optics, _ in known.values() for name in optics.facts}
    own = options.is_built_in or options.find is neutral_curve
    if not own or origins() or any(map(origin_of, facts)):
        return ""  # what the code of other distributions does is not known
    # a frame that is refused by hand is not followed to the next one
    left_out = sorted(refused) if is_video(path) else []
    return digest_of(path, known, picture_name(path), options.every, options.overlays, left_out)


class _Finder:
    """Finds the curves of one strip; with `follow` each from that of the picture before."""

    def __init__(
        self, optics: Optics, strip: StripGeometry, find: FindCurve, *, follow: bool
    ) -> None:
        self._optics, self._strip = optics, strip
        self._find = heeding(find) if optics.constraints.objections else find
        self._tracker = Tracker(optics, strip, self._find) if follow else None

    def curve(self, image: Pixels) -> NeutralCurve:
        """Return the curve of the next picture."""
        image = in_levels(image, self._optics)
        if self._tracker is not None:
            return self._tracker.curve(image)
        return self._find(image, self._optics, self._strip)

    def taken(self, curve: NeutralCurve) -> NeutralCurve:
        """Return the curve of the next picture, which is known."""
        return curve if self._tracker is None else self._tracker.taken(curve)


def _found(picture: Picture, find: Find) -> NeutralCurve:
    if picture.image is None:
        return NeutralCurve(ok=False, why=picture.why)
    try:
        return find(picture.image)
    except BadInputError as error:
        return NeutralCurve(ok=False, why=str(error))
