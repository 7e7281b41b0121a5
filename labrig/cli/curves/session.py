"""`labrig curves SESSION`: the curves of a session's conditions, beside those of their frames."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig.cli.screen import print_json_line, say, warn

if TYPE_CHECKING:
    from labrig.vision import FrameAverage
    from model import Curve
    from model.measurements import Condition, Contact


def session_curves(path: Path, output: Path | None, extractor: str, *, as_json: bool) -> None:
    """Print the curves of a session, and write them as curves.csv."""
    from labrig.analysis import measure
    from labrig.cli.screen import progress
    from labrig.session import open_session
    from labrig.session.tables.write import write_curves
    from model.measurements import in_volts

    with open_session(path) as session, progress("curves") as advance:
        measurements = measure(session, advance, extractor=extractor)
    for c in measurements.conditions:
        where = "free" if c.position_m is None else f"{1e3 * c.position_m:g} mm"
        name = f"{c.configuration}, {where}, {in_volts(c.voltage_V)}"
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
