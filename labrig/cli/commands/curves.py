"""Pictures of a clamped strip to neutral curves, with a session or without: curves."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.screen import print_json_line, say, warn
from labrig.errors import BadInputError

if TYPE_CHECKING:
    from labrig.vision import BatchOptions, FrameAverage, NeutralCurve
    from model import Curve
    from model.measurements import Condition, Contact


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
    overlay: Annotated[
        Path | None, typer.Option(help="the image with the curve on it (png; one image)")
    ] = None,
    batch: Annotated[
        Path | None, typer.Option(help="every image of this folder; NAME.json for each")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="print one JSON object for each image, a line each")
    ] = False,
    extractor: Annotated[
        str | None, typer.Option(help="name of a curve extractor; default: the built-in one")
    ] = None,
) -> None:
    """Find the neutral curve of a clamped strip in images.

    NAME.png takes NAME.optics.json and NAME.sheet.toml from beside it when they are there, else
    what --optics and --sheet name. An image without a curve is no error: its reason is printed.
    """
    from labrig.extractors.choice import BUILT_IN, chosen_extractor
    from labrig.vision import BatchOptions, SheetAppearance

    name = extractor or BUILT_IN
    options = BatchOptions(
        optics=optics,
        sheet=sheet,
        configuration=configuration,
        look=None if look is None else SheetAppearance(look),
        find=chosen_extractor(name).curve,
    )
    if batch is not None:
        if sources or output is None:
            raise BadInputError("--batch FOLDER takes -o FOLDER and no further images.")
        _batch(batch, output, options)
        return
    if not sources:
        raise BadInputError("no image was given; give files, a folder, or --batch FOLDER.")
    if [path.suffix.lower() for path in sources] == [".h5"]:
        if any((optics, sheet, configuration, look, overlay)):
            raise BadInputError(
                "a session holds its own optics and sheet: --optics, --sheet, --configuration, "
                "--look and --overlay are for images."
            )
        _session(sources[0], output, name, as_json=as_json)
        return
    _of_images(sources, options, output, overlay, as_json=as_json)


def _of_images(
    sources: list[Path],
    options: BatchOptions,
    output: Path | None,
    overlay: Path | None,
    *,
    as_json: bool,
) -> None:
    from labrig.vision import curve_json, write_overlay
    from labrig.vision.batch import curves_of
    from labrig.vision.image.files import write_table

    found: dict[str, NeutralCurve] = {}
    for name, image, curve in curves_of(sources, options):
        found[name] = curve
        if as_json:
            print_json_line(curve_json(curve))
        else:
            say(f"{name}: {_summary(curve)}")
        if overlay is not None and image is not None:
            if len(found) > 1:
                raise BadInputError("--overlay takes one image; use --batch for many.")
            write_overlay(overlay, image, curve)
    if output is not None:
        write_table(output, found)
        warn(f"wrote {output}")


def _summary(curve: NeutralCurve) -> str:
    if not curve.ok:
        return f"no curve: {curve.why}"
    warnings = "; ".join(curve.warnings)
    return (
        f"{1e3 * curve.s_m[-1]:.1f} mm, tip at ({1e3 * curve.x_m[-1]:+.2f}, "
        f"{1e3 * curve.y_m[-1]:+.2f}) mm, covered {curve.covered:.0%}, "
        f"residual {curve.residual_px:.3f} px{'; ' + warnings if warnings else ''}"
    )


def _batch(folder: Path, output: Path, options: BatchOptions) -> None:
    from labrig.vision import extract_curves

    if not folder.is_dir():
        raise BadInputError(f"{folder}: there is no such folder.")
    count = 0

    def progress(name: str, curve: NeutralCurve) -> None:
        nonlocal count
        count += 1
        warn(f"{count}: {name}: {_summary(curve)}")

    result = extract_curves([folder], output, options, progress=progress)
    say(f"{len(result.curves)} images, {len(result.failed)} without a curve; wrote {output}")


def _session(path: Path, output: Path | None, extractor: str, *, as_json: bool) -> None:
    from labrig.analysis import measure
    from labrig.cli.screen import progress
    from labrig.session import open_session
    from labrig.session.tables.write import write_curves

    with open_session(path) as session, progress("curves") as advance:
        measurements = measure(session, advance, extractor=extractor)
    for c in measurements.conditions:
        where = "free" if c.position_m is None else f"{1e3 * c.position_m:g} mm"
        name = f"{c.configuration}, {where}, {c.voltage_V:+g} V"
        if as_json:
            line = {"image": name, "ok": c.curve is not None, **_curve_json(c.curve)}
            line["by_frame"] = _by_frame_json(c)
            line["contact"] = _contact_json(c.contact)
            print_json_line(line)
        else:
            points = "no curve" if c.curve is None else f"{len(c.curve.s_m)} points"
            say(f"{name}: {points}{_by_frame_text(c)}{_contact_text(c.contact)}")
    for text in measurements.warnings:
        warn(f"warning: {text}")
    if output is not None:
        write_curves(measurements, output)
        warn(f"wrote {output}")


def _by_frame(condition: Condition) -> FrameAverage | None:
    """Average the curves of a condition's frames: the other path to its curve."""
    from labrig.analysis.curves import MEAN_OF
    from labrig.vision import average_of_frames

    counts = [r for r in condition.readings if r.valid and r.kind in MEAN_OF]
    return average_of_frames([r.curve for r in counts if r.curve is not None])


def _by_frame_text(condition: Condition) -> str:
    average = _by_frame(condition)
    if average is None:
        return ""
    text = f", {average.frames} frames scatter by {1e3 * average.scatter_rms_m:.4f} mm"
    if condition.curve is not None:
        text += f", their mean {1e3 * average.apart_m(condition.curve):.4f} mm from it"
    return text


def _by_frame_json(condition: Condition) -> dict[str, Any] | None:
    average = _by_frame(condition)
    if average is None:
        return None
    apart = None if condition.curve is None else 1e3 * average.apart_m(condition.curve)
    return {
        "frames": average.frames,
        "from_mean_image_mm": apart,
        "s_mm": 1e3 * average.s_m,
        "x_mm": 1e3 * average.x_m,
        "y_mm": 1e3 * average.y_m,
        "scatter_mm": 1e3 * average.scatter_m,
    }


def _contact_text(contact: Contact | None) -> str:
    if contact is None:
        return ""
    how = "" if contact.rolls_m else " (no rolls seen; where it crosses the arc)"
    sigma_mm = max(0.01, 1e3 * contact.position_sigma_m)
    return f", contact at {1e3 * contact.position_m:.2f} ± {sigma_mm:.2f} mm{how}"


def _contact_json(contact: Contact | None) -> dict[str, Any] | None:
    if contact is None:
        return None
    return {
        "position_mm": 1e3 * contact.position_m,
        "position_sigma_mm": 1e3 * contact.position_sigma_m,
        "s_mm": 1e3 * contact.s_m,
        "x_mm": 1e3 * contact.x_m,
        "y_mm": 1e3 * contact.y_m,
        "angle_rad": contact.angle_rad,
        "radius_mm": 1e3 * contact.radius_m,
        "rolls_mm": [[1e3 * value for value in roll] for roll in contact.rolls_m],
    }


def _curve_json(curve: Curve | None) -> dict[str, Any]:
    if curve is None:
        return {}
    return {
        "s_mm": 1e3 * curve.s_m,
        "x_mm": 1e3 * curve.x_m,
        "y_mm": 1e3 * curve.y_m,
        "curvature_per_m": curve.curvature_per_m,
        "sigma_mm": None if curve.sigma_m is None else 1e3 * curve.sigma_m,
        "curvature_sigma_per_m": curve.curvature_sigma_per_m,
    }


COMMAND = Command(
    "curves",
    curves,
    order=210,
    examples=(CommandExample(line="labrig curves strip.png -o strip.csv"),),
)
