"""`labrig curves`: images, folders and videos in, curves with their uncertainty out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from labrig.errors import BadInputError, LabrigWarning, warn_caller
from labrig.vision.calibration.optics import (
    ColourChannel,
    Optics,
    SheetAppearance,
    StripPlace,
    listed,
    load_optics,
)
from labrig.vision.checks.catalogue import origins
from labrig.vision.checks.objections import heeding
from labrig.vision.curve import FindCurve, NeutralCurve, StripGeometry
from labrig.vision.extraction.extract import neutral_curve
from labrig.vision.facts.catalogue import origin_of, strip_facts
from labrig.vision.facts.contract import FactOf
from labrig.vision.facts.stated import joined
from labrig.vision.image.beside import OPTICS_FILE, SHEET_FILE, beside, missing, own_file
from labrig.vision.image.colour_notes import ColourNotes
from labrig.vision.image.files import load_strip, write_json
from labrig.vision.image.image import in_levels
from labrig.vision.image.names import (
    IMAGE_SUFFIXES,
    files_in,
    holds_several,
    is_video,
    picture_name,
    whole_stem,
)
from labrig.vision.image.overlay import write_overlay
from labrig.vision.image.reading import (
    Picture,
    PictureLabel,
    Pixels,
    pictures_in,
    whole_file,
)
from labrig.vision.image.review import PictureDecision, load_review
from labrig.vision.image.tables import LabelledCurve, write_points, write_summary
from labrig.vision.image.unused import unused_corrections
from labrig.vision.resuming import KeptCurves, digest_of
from labrig.vision.tracking.tracker import Tracker

Progress = Callable[[str, NeutralCurve], None]
PictureCurve = tuple[PictureLabel, Pixels | None, NeutralCurve]
Find = Callable[[Pixels], NeutralCurve]

UNSTATED_LENGTH_M = 0.05  # stands for a length that is measured


@dataclass(frozen=True, kw_only=True)
class BatchOptions:
    """What `extract_curves` uses where an image has no files of its own beside it."""

    optics: Path | None = None
    sheet: Path | None = None
    configuration: str | None = None  # which table of the sheet.toml
    overlays: bool = True
    look: SheetAppearance | None = None  # in place of that in optics.json
    find: FindCurve = neutral_curve
    is_built_in: bool = False  # whether `find` is labrig's own; `neutral_curve` is
    strips: Mapping[str, StripPlace] | None = None  # in place of those in optics.json
    facts: Mapping[str, Any] = field(default_factory=dict)  # by name, beside those in optics.json
    channel: ColourChannel | None = None  # of colour images, in place of that in optics.json
    every: int = 1  # of a video's frames and a TIFF's pages the first of each so many


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
    kept = KeptCurves(output)
    found = curves_of(sources, options, kept)
    if options.overlays:
        _keep_photographs(sources, output)
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
        write_points(output / "curves.csv", result.found)
        write_summary(output / "summary.csv", result.found)
    return result


def curves_of(
    sources: Sequence[Path], options: BatchOptions, kept: KeptCurves | None = None
) -> Iterator[PictureCurve]:
    """Return label, image (None: unreadable) and curve of each picture, one after the other.

    What is `kept` is not measured again; each curve is kept once the next one is asked for.
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
    _tell_of_subfolders(sources)
    _tell_of_unused_corrections(sources, options)
    _refuse_common_faults(files, options)
    decided = {folder: load_review(folder) for folder in {path.parent for path in files}}
    return (
        named for path in files for named in _curves_of(path, options, decided[path.parent], kept)
    )


def _files(sources: Sequence[Path]) -> Iterator[Path]:
    for source in sources:
        if source.is_dir():
            yield from files_in(source, videos=True)
        elif source.exists():
            yield source
        else:
            raise BadInputError(f"{source}: there is no such file or folder.")


def _tell_of_subfolders(sources: Sequence[Path]) -> None:
    """Warn of images in folders of a folder, which are left out."""
    for source in filter(Path.is_dir, sources):
        inner = [path.name for path in sorted(source.iterdir()) if path.is_dir()]
        held = [name for name in inner if _holds_images(source / name)]
        if held:
            warn_caller(
                LabrigWarning(
                    f"{source}: images in its folders ({listed(held)}) are left out; measure "
                    "each of these folders by itself."
                )
            )


def _tell_of_unused_corrections(sources: Sequence[Path], options: BatchOptions) -> None:
    for source in filter(Path.is_dir, sources):
        told = unused_corrections(source, options.optics, options.sheet)
        if told:
            warn_caller(LabrigWarning(told))


def _holds_images(folder: Path) -> bool:
    """Whether there are images in a folder; none is seen in one that cannot be read."""
    with suppress(OSError):
        return bool(files_in(folder, videos=True))
    return False


def _refuse_twins(files: list[Path]) -> None:
    seen: dict[str, Path] = {}
    for path in files:
        name = picture_name(path)
        if name in seen:
            raise BadInputError(
                f"{seen[name]} and {path} would both be written to {name}.json; "
                "rename one, or run them into different folders."
            )
        seen[name] = path
    for name, path in seen.items():
        many = seen.get(whole_stem(name))
        if many is not None and many != path and holds_several(many):
            raise BadInputError(
                f"{path} is named as a frame or page of {many} is, and both would be written to "
                f"{name}.json; rename one, or run them into different folders."
            )


def _keep_photographs(sources: Sequence[Path], output: Path) -> None:
    """Raise BadInputError where an overlay would be written over a photograph of the batch."""
    files = list(_files(sources))
    photographs = {path.resolve() for path in files}
    for path in files:
        overlay = output / f"{picture_name(path)}_curve.png"
        if overlay.resolve() in photographs:
            raise BadInputError(
                f"the overlay of {path} would be written over {overlay}; choose another folder "
                "with -o."
            )


def _refuse_common_faults(files: list[Path], options: BatchOptions) -> None:
    """Raise for a fault in a file of several images; one in an own file costs that image only."""
    kinds: tuple[tuple[str, Path | None, Callable[[Path], object]], ...] = (
        (OPTICS_FILE, options.optics, lambda path: _check_optics(path, files, options)),
        (SHEET_FILE, options.sheet, lambda path: _check_sheet(path, files, options)),
    )
    for kind, given, load in kinds:
        _refuse_missing(given)
        found = {path: beside(path, kind, given) for path in files}
        if not any(found.values()) and (kind == OPTICS_FILE or _needs_sheet(files[0], options)):
            raise BadInputError(missing(files[0], kind))
        if given is not None and given not in found.values():
            own = own_file(files[0], kind).name
            warn_caller(
                LabrigWarning(
                    f"{given} is not used: each image has its own file beside it, such as {own}."
                )
            )
        for common in {each for path, each in found.items() if each != own_file(path, kind)}:
            if common is not None:
                load(common)


def _refuse_missing(given: Path | None) -> None:
    if given is not None and not given.exists():
        raise BadInputError(f"{given}: there is no such file.")


def _needs_sheet(path: Path, options: BatchOptions) -> bool:
    try:
        return not _measures_length(optics_of(path, options))
    except BadInputError:
        return False  # a fault of that image's own file costs that image only


def _check_optics(optics: Path, files: list[Path], options: BatchOptions) -> None:
    """Read a common optics.json, with what is stated besides, as the first image with it does."""
    optics_of(next(p for p in files if beside(p, OPTICS_FILE, options.optics) == optics), options)


def _check_sheet(sheet: Path, files: list[Path], options: BatchOptions) -> None:
    """Read a common sheet.toml as the first image that uses it does."""
    first = next(path for path in files if beside(path, SHEET_FILE, options.sheet) == sheet)
    try:
        names = optics_of(first, options).by_strip()
    except BadInputError:
        names = {}  # a fault of that image's own file costs that image only
    for name in names:
        load_strip(sheet, options.configuration, name)


def _curves_of(
    path: Path,
    options: BatchOptions,
    decided: Mapping[str, PictureDecision],
    kept: KeptCurves | None,
) -> Iterator[PictureCurve]:
    try:
        known = _known(path, options)
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


def _known(path: Path, options: BatchOptions) -> dict[str, tuple[Optics, StripGeometry]]:
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


def _measures_length(optics: Optics) -> bool:
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
    if sheet is None and not _measures_length(optics):
        raise BadInputError(missing(path, SHEET_FILE))
    return sheet
