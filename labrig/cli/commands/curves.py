"""Pictures of a clamped strip to neutral curves, with a session or without: curves."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.curves.facts import (
    flags_of_facts,
    refuse_for_several_strips,
    stated_facts,
    with_facts,
)
from labrig.cli.curves.outputs import check_outputs
from labrig.cli.curves.page import serve_page
from labrig.cli.curves.session import session_curves
from labrig.cli.screen import print_json_line, say, warn
from labrig.errors import BadInputError
from labrig.files import SESSION_ENDINGS

if TYPE_CHECKING:
    import numpy.typing as npt

    from labrig.vision import BatchOptions, NeutralCurve
    from labrig.vision.image.tables import LabelledCurve

PORT = 8730  # of the page
ONE_IMAGE = "--overlay takes one image; use --batch FOLDER -o FOLDER for many."


def curves(
    sources: Annotated[
        list[Path] | None, typer.Argument(help="images, videos, folders, or one session.h5")
    ] = None,
    optics: Annotated[Path | None, typer.Option(help="optics.json")] = None,
    sheet: Annotated[Path | None, typer.Option(help="sheet.toml")] = None,
    configuration: Annotated[
        str | None, typer.Option(help="which table of sheet.toml, when it has several")
    ] = None,
    look: Annotated[
        Literal["auto", "lit_edge", "silhouette"] | None,
        typer.Option(help="what shows beside the sheet's near edge, in place of optics.json's"),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="curves.csv; with --batch a folder")
    ] = None,
    summary: Annotated[
        Path | None, typer.Option(help="summary.csv: a line for each image; --batch has it")
    ] = None,
    overlay: Annotated[
        Path | None, typer.Option(help="the image with its curves on it (png; one image)")
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="overwrite the tables of -o and --summary")
    ] = False,
    batch: Annotated[
        Path | None, typer.Option(help="every image of this folder; NAME.json for each")
    ] = None,
    every: Annotated[
        int, typer.Option(min=1, help="take each Nth frame of a video, or page of a TIFF")
    ] = 1,
    as_json: Annotated[
        bool, typer.Option("--json", help="print one JSON object for each image, a line each")
    ] = False,
    extractor: Annotated[
        str | None, typer.Option(help="name of a curve extractor; default: the built-in one")
    ] = None,
    method: Annotated[
        list[str] | None,
        typer.Option(
            help="compare this curve extractor with the built-in one, or each with the first; "
            "`--method list` lists all"
        ),
    ] = None,
    channel: Annotated[
        Literal["auto", "grey", "red", "green", "blue", "red-green", "red-blue", "green-blue"]
        | None,
        typer.Option(help="of a colour image: one channel, or the difference of two"),
    ] = None,
    strip: Annotated[
        list[str] | None,
        typer.Option(
            help="one of several strips: NAME=U,V (its clamp) or NAME=U,V:U,V (and a second pixel "
            "along the clamped strip); may be repeated"
        ),
    ] = None,
    page: Annotated[
        Path | None,
        typer.Option(help="serve a page for the photographs of this folder: click, look, decide"),
    ] = None,
    port: Annotated[
        int | None, typer.Option(min=0, max=65535, help="of the page; 0: any; default: 8730")
    ] = None,
    open_it: Annotated[bool, typer.Option("--open", help="open the page in the browser")] = False,
    **facts: object,
) -> None:
    """Find the neutral curve of a clamped strip in images.

    NAME.png takes NAME.optics.json and NAME.sheet.toml from beside it when they are there, else
    what --optics and --sheet name. An image without a curve is no error: its reason is printed,
    and it has a row in the tables. Photographs are turned as their EXIF states. Each page of a
    TIFF (FILE:PAGE) and each frame of a video (FILE_FRAME, with its time) is an image. With
    NAME.jpg in the same folder NAME.png goes by its whole name.

    A table that is there already is replaced with --force alone, and an overlay that labrig drew is
    replaced. What cannot be written is told before the first image is measured.

    A --batch that was stopped continues with the same command: an image with a result in -o is
    measured again only where its file, optics, sheet, options or labrig have changed. To measure
    all again, give another folder or remove `resume` in it.

    With --to-end the length is measured. A thickness that sheet.toml does not state, and a
    direction that optics.json does not state, are measured as well; a clamp within 20 pixels is
    enough. The curve's warnings name the measured quantities, and say where a second look at what
    stands out in the image led the curve on or cut it. Where a strip is lost on its way, --through
    states places on it, and --tip-px its end: its path is not searched for then.

    --mask excludes parts of the images. With several strips in an image (--strip, or `strips` in
    optics.json) each has its own curve; it takes the table of its name in sheet.toml.
    --method runs one curve extractor against another; -o FILE.csv keeps the comparison.
    --page serves a page for a folder: click clamp, direction, ruler and mask for one photograph or
    for all, and places on a strip that was lost; look at every curve, accept or refuse. The clicks
    are kept beside the photographs.
    """
    if page is not None:
        others = (sources, optics, sheet, batch, output, summary, overlay, method, strip)
        ways = (configuration, look, extractor, channel, as_json, every > 1, force)
        _refuse_beside_page((*others, *ways, *facts.values()))
        serve_page(page, PORT if port is None else port, open_it=open_it)
        return
    if port is not None or open_it:
        raise BadInputError("--port and --open are for --page FOLDER; give that, too.")
    from labrig.cli.curves.options import strips_of
    from labrig.extractors.choice import BUILT_IN, chosen_extractor
    from labrig.vision import BatchOptions, SheetAppearance
    from labrig.vision.calibration.optics import ColourChannel

    name = extractor or BUILT_IN
    chosen = chosen_extractor(name)
    options = BatchOptions(
        optics=optics,
        sheet=sheet,
        configuration=configuration,
        look=None if look is None else SheetAppearance(look),
        find=chosen.curve,
        is_built_in=chosen.is_built_in,
        strips=strips_of(strip),
        facts=stated_facts(facts),
        channel=None if channel is None else ColourChannel(channel),
        every=every,
    )
    if strip:
        refuse_for_several_strips(options.facts)
    if method:
        extra = (batch, summary, overlay, extractor, as_json)
        _compare(sources, method, options, output, extra, force=force)
        return
    if batch is not None:
        if as_json or overlay is not None:
            raise BadInputError(
                "--batch writes NAME.json and NAME_curve.png for each image into its folder; "
                "leave --json and --overlay out."
            )
        if force:
            raise BadInputError("--batch replaces tables of its own alone; leave --force out.")
        _batch(batch, sources, output, summary, options)
        return
    if not sources:
        raise BadInputError("no image was given; give files, a folder, or --batch FOLDER.")
    if len(sources) == 1 and sources[0].suffix.lower() in SESSION_ENDINGS:
        of_images = (optics, sheet, configuration, look, summary, overlay, strip, channel)
        _refuse_beside_session((*of_images, *facts.values(), every > 1))
        check_outputs(output, force=force)
        session_curves(sources[0], output, name, as_json=as_json)
        return
    check_outputs(output, summary, overlay, force=force)
    if overlay is not None and (len(sources) > 1 or sources[0].is_dir()):
        raise BadInputError(ONE_IMAGE)
    found, drawing = _of_images(sources, options, overlay, as_json=as_json)
    _write_tables(found, output, summary)
    if drawing is not None:
        drawing.write()


def _refuse_beside_page(others: tuple[object, ...]) -> None:
    if any(others):
        raise BadInputError(
            "--page FOLDER takes no images and no options but --port and --open: what is known "
            "of the photographs lies beside them, or is clicked on the page; the built-in "
            "extractor finds their curves."
        )


def _refuse_beside_session(of_images: tuple[object, ...]) -> None:
    if any(of_images):
        raise BadInputError(
            "a session holds its own optics and sheet: --optics, --sheet, --configuration, "
            f"--look, --summary, --overlay, --strip, {', '.join(flags_of_facts())}, --channel "
            "and --every are for images."
        )


def _compare(
    sources: list[Path] | None,
    methods: list[str],
    options: BatchOptions,
    output: Path | None,
    extra: tuple[object, ...],
    *,
    force: bool,
) -> None:
    from labrig.cli.curves.methods import compare_methods, list_methods

    if any(extra):
        raise BadInputError(
            "--method compares curve extractors: leave --batch, --summary, --overlay, "
            "--extractor and --json out."
        )
    if methods == ["list"]:
        list_methods()
    elif not sources:
        raise BadInputError("no image was given; give files or a folder to compare on.")
    else:
        check_outputs(output, force=force)
        compare_methods(sources, methods, options, output)


@dataclass
class _Overlay:
    """The picture to draw on, with the curves of all its strips."""

    path: Path
    image: npt.NDArray[Any] | None = None
    frames: set[object] = field(default_factory=set)  # or pages, of one file
    curves: list[NeutralCurve] = field(default_factory=list)

    def take(self, frame: object, image: npt.NDArray[Any], curve: NeutralCurve) -> None:
        """Take one curve with its picture."""
        self.frames.add(frame)
        self.image = image
        self.curves.append(curve)

    def write(self) -> None:
        """Write it, if there was a picture. Raises BadInputError where there were several."""
        from labrig.vision import write_overlay

        if len(self.frames) > 1:
            raise BadInputError(ONE_IMAGE)
        if self.image is not None:
            write_overlay(self.path, self.image, *self.curves)
            warn(f"wrote {self.path}")


def _of_images(
    sources: list[Path], options: BatchOptions, overlay: Path | None, *, as_json: bool
) -> tuple[list[LabelledCurve], _Overlay | None]:
    from labrig.vision.batch.curves import curves_of
    from labrig.vision.image.files import labelled_json

    found: list[LabelledCurve] = []
    drawing = None if overlay is None else _Overlay(overlay)
    for label, image, curve in curves_of(sources, options):
        found.append((label, curve))
        if as_json:
            print_json_line(labelled_json(label, curve))
        else:
            say(f"{label.name}: {_summary(curve)}")
        if drawing is not None and image is not None:
            drawing.take(label.frame, image, curve)
    return found, drawing


def _write_tables(found: list[LabelledCurve], output: Path | None, summary: Path | None) -> None:
    from labrig.vision.image.tables import write_points, write_summary

    if output is not None:
        write_points(output, found)
        warn(f"wrote {output}")
    if summary is not None:
        write_summary(summary, found)
        warn(f"wrote {summary}")


def _summary(curve: NeutralCurve) -> str:
    if not curve.ok:
        return f"no curve: {curve.why}"
    warnings = "; ".join(curve.warnings)
    return (
        f"{1e3 * curve.s_m[-1]:.1f} mm, tip at ({1e3 * curve.x_m[-1]:+.2f}, "
        f"{1e3 * curve.y_m[-1]:+.2f}) mm, covered {curve.covered:.0%}, "
        f"residual {curve.residual_px:.3f} px{'; ' + warnings if warnings else ''}"
    )


def _batch(
    folder: Path,
    sources: list[Path] | None,
    output: Path | None,
    summary: Path | None,
    options: BatchOptions,
) -> None:
    from labrig.vision import extract_curves

    if sources or output is None:
        raise BadInputError("--batch FOLDER takes -o FOLDER and no further images.")
    if summary is not None:
        raise BadInputError("--batch writes summary.csv into its folder; leave --summary out.")
    if not folder.is_dir():
        raise BadInputError(f"{folder}: there is no such folder.")
    count = 0

    def progress(name: str, curve: NeutralCurve) -> None:
        nonlocal count
        count += 1
        warn(f"{count}: {name}: {_summary(curve)}")

    result = extract_curves([folder], output, options, progress=progress)
    kept = f", {result.kept} as measured before" if result.kept else ""
    say(f"{len(result.curves)} images, {len(result.failed)} without a curve{kept}; wrote {output}")


COMMAND = Command(
    "curves",
    with_facts(curves, before="channel"),
    order=210,
    examples=(CommandExample(line="labrig curves strip.png -o strip.csv"),),
)
