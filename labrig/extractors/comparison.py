"""One curve extractor against another on the same images."""

from __future__ import annotations

import csv
import io
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.extractors.choice import ChosenExtractor
from labrig.files import write_bytes
from labrig.vision import BatchOptions, NeutralCurve, Optics, StripGeometry
from labrig.vision.batch.curves import curves_of
from labrig.vision.image.names import PictureLabel

FloatArray = npt.NDArray[np.float64]
COLUMNS = ("image", "strip", "method", "state", "apart_rms_px", "apart_max_px", "tip_apart_px",
           "cpu_ms", "reason")  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class MethodCurve:
    """What one extractor makes of one image, and how far that is from the first extractor's."""

    label: PictureLabel
    method: str
    curve: NeutralCurve
    cpu_s: float
    apart_px: FloatArray | None = None  # (points,) from the first one's curve; None: one is refused
    tip_apart_px: float | None = None

    @property
    def rms_px(self) -> float | None:
        """RMS distance of its points from the first one's curve."""
        return None if self.apart_px is None else float(np.sqrt(np.mean(self.apart_px**2)))


class _TimedFind:
    """An extractor, and the processor time that its last image took."""

    def __init__(self, chosen: ChosenExtractor) -> None:
        self.chosen = chosen
        self.cpu_s = 0.0

    def __call__(
        self,
        image: npt.NDArray[Any],
        optics: Optics,
        strip: StripGeometry,
        *,
        start: NeutralCurve | None = None,
    ) -> NeutralCurve:
        begin = time.process_time()
        found = self.chosen.curve(image, optics, strip, start=start)
        self.cpu_s = time.process_time() - begin
        return found


def compared(
    sources: Sequence[Path], options: BatchOptions, methods: Sequence[ChosenExtractor]
) -> Iterator[list[MethodCurve]]:
    """Yield what each extractor makes of an image, image by image; the first is the reference."""
    timed = [_TimedFind(chosen) for chosen in methods]
    runs = [curves_of(sources, replace(options, find=find)) for find in timed]
    for pictures in zip(*runs, strict=True):
        reference = pictures[0][2]
        yield [
            _beside(
                MethodCurve(label=label, method=find.chosen.name, curve=curve, cpu_s=find.cpu_s),
                reference,
            )
            for find, (label, _, curve) in zip(timed, pictures, strict=True)
        ]


def _beside(found: MethodCurve, reference: NeutralCurve) -> MethodCurve:
    if not (found.curve.ok and reference.ok):
        return found
    points, line = found.curve.points_px, reference.points_px
    tip = float(np.hypot(*(points[-1] - line[-1])))
    return replace(found, apart_px=distances(points, line), tip_apart_px=tip)


def distances(points: FloatArray, line: FloatArray) -> FloatArray:
    """Return (n,) the distance of points (n, 2) from a line through points (m, 2)."""
    first, along = line[:-1], np.diff(line, axis=0)
    square = np.maximum((along**2).sum(axis=1), 1e-12)
    beside = points[:, None] - first
    share = np.clip((beside * along).sum(axis=2) / square, 0, 1)
    gap = beside - share[..., None] * along
    return np.asarray(np.hypot(gap[..., 0], gap[..., 1]).min(axis=1))


@dataclass(frozen=True, kw_only=True)
class MethodSummary:
    """One extractor on all images."""

    method: str
    found: int
    refused: int
    apart_px: float | None  # median of the images' RMS distances; None: there is none
    apart_max_px: float | None  # the largest of these
    cpu_ms: float  # of an image, mean


def summaries(rows: Sequence[MethodCurve]) -> list[MethodSummary]:
    """Return a summary of each extractor, in their order."""
    return [
        _summary(name, [row for row in rows if row.method == name])
        for name in dict.fromkeys(row.method for row in rows)
    ]


def _summary(name: str, rows: list[MethodCurve]) -> MethodSummary:
    apart = [row.rms_px for row in rows if row.rms_px is not None]
    found = sum(row.curve.ok for row in rows)
    return MethodSummary(
        method=name,
        found=found,
        refused=len(rows) - found,
        apart_px=float(np.median(apart)) if apart else None,
        apart_max_px=max(apart, default=None),
        cpu_ms=1e3 * sum(row.cpu_s for row in rows) / len(rows),
    )


def write_comparison(path: Path, rows: Sequence[MethodCurve]) -> None:
    """Write a line for each image and extractor."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(map(_line, rows))
    write_bytes(path, text.getvalue().encode("utf-8"))


def _line(row: MethodCurve) -> dict[str, str]:
    line = {
        "image": row.label.name,
        "strip": row.label.strip,
        "method": row.method,
        "state": "found" if row.curve.ok else "refused",
        "cpu_ms": f"{1e3 * row.cpu_s:.1f}",
        "reason": row.curve.why,
    }
    if row.apart_px is not None and row.rms_px is not None:
        line |= {
            "apart_rms_px": f"{row.rms_px:.4f}",
            "apart_max_px": f"{row.apart_px.max():.4f}",
            "tip_apart_px": f"{row.tip_apart_px:.4f}",
        }
    return line
