"""`labrig curves --method`: list the curve extractors, and run one against another."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from labrig.cli.screen import say, warn
from labrig.errors import BadInputError

if TYPE_CHECKING:
    from labrig.extractors.comparison import MethodCurve
    from labrig.vision import BatchOptions


def list_methods() -> None:
    """Print each curve extractor with where it comes from and what it does."""
    from labrig.extractors.choice import EXTRACTORS

    for name, part in EXTRACTORS.parts().items():
        origin = f"{part.distribution} {part.version}".strip()
        say(f"{name} ({origin}): {part.part.summary}")


def compare_methods(
    sources: list[Path], names: list[str], options: BatchOptions, output: Path | None
) -> None:
    """Print what each extractor makes of each image; a single one is compared with ours."""
    from labrig.extractors.choice import BUILT_IN, chosen_extractor
    from labrig.extractors.comparison import compared, summaries, write_comparison

    names = [BUILT_IN, *names] if len(names) == 1 else names
    if len(set(names)) < len(names):
        raise BadInputError(
            f"--method: {', '.join(names)}: an extractor cannot be compared with itself; "
            "`labrig curves --method list` lists all."
        )
    methods = [chosen_extractor(name, option="method") for name in names]
    rows: list[MethodCurve] = []
    for image in compared(sources, options, methods):
        rows += image
        say(f"{image[0].label.name}: " + "; ".join(map(_of_image, image)))
    say("")
    for one in summaries(rows):
        apart = ""
        if one.method != names[0] and one.apart_px is not None:
            apart = f", {one.apart_px:.3f} px from {names[0]} (median; {one.apart_max_px:.3f} most)"
        say(
            f"{one.method}: {one.found} curves, {one.refused} refused{apart}, "
            f"{one.cpu_ms:.0f} ms of processor time an image"
        )
    if output is not None:
        write_comparison(output, rows)
        warn(f"wrote {output}")


def _of_image(row: MethodCurve) -> str:
    if not row.curve.ok:
        return f"{row.method} refuses: {row.curve.why.rstrip('.')}"
    if row.apart_px is None or not row.apart_px.any():
        return f"{row.method} {1e3 * row.curve.s_m[-1]:.1f} mm"
    return f"{row.method} {row.rms_px:.3f} px apart (RMS; {row.apart_px.max():.3f} most)"
