"""When a reading does not count without anybody saying so, and the loop's own times."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from drivers.interfaces import FORCE_GAP_S, FloatArray, Frame, OvervoltageError
from protocols.execution.channels import Channel

_COARSE = slice(None, None, 4)  # of rows and columns: enough to see whether there is a picture
AT_THE_RAIL = 0.999  # of the input's range: the last counts of the converter


@dataclass(frozen=True, kw_only=True)
class Rules:
    """Thresholds beyond which a reading is invalid."""

    late_edge_s: float = 0.005  # an edge written later spoils its reading
    drive_tolerance_V: float = 0.2  # of the read-back against the voltage that was written
    safe_below_V: float = 0.05  # a read-back below this shows 0 V
    zero_within_s: float = 0.5  # after 0 V was written the read-back must have shown it
    unseen_s: float = 0.5  # a read-back that is no number for so long shows nothing
    force_gap_s: float = FORCE_GAP_S  # values of a meter further apart do not show an edge
    frame_periods: float = 1.5  # a frame further from the sampling point is not its frame
    blank_frame: float = 0.01  # of full scale: a picture that varies less shows nothing
    position_tolerance_m: float = 0.0005  # of the stage's report; beyond it the operator is warned


def late_edge(lateness_s: float, rules: Rules) -> Iterator[str]:
    """Yield a reason when the reading's own edge came late."""
    if lateness_s > rules.late_edge_s:
        yield (
            f"its edge came {lateness_s * 1e3:.1f} ms late (limit {rules.late_edge_s * 1e3:g} ms)"
        )


def bad_samples(raw: FloatArray, channels: Sequence[Channel]) -> Iterator[str]:
    """Reasons in the raw samples (channels, samples) of a window: lost ones, or a channel's end."""
    if np.isnan(raw).any():
        yield "samples were lost in its window"
    for row, channel in zip(raw, channels, strict=True):
        if np.nanmax(np.abs(row), initial=0.0) >= AT_THE_RAIL * channel.range_V:
            end = f"±{channel.range_V:g} {channel.raw_unit}"
            yield f"the {channel.name} input is at the end of its range ({end})"


def wrong_drive(drive_V: float, written_V: float, rules: Rules) -> Iterator[str]:
    """Yield a reason when the sheet did not get what was written."""
    if abs(drive_V - written_V) > rules.drive_tolerance_V:
        yield f"the drive reads back {drive_V:.3g} V instead of {written_V:g} V"


def force_across_edge(
    times_s: FloatArray, begin_s: float, end_s: float, rules: Rules
) -> Iterator[str]:
    """Yield a reason when the force is a long line to a value at another voltage.

    `times_s`: of the values around the window; the reading's voltage is there from `begin_s` to
    `end_s`.
    """
    gaps_s = [
        after_s - before_s
        for before_s, after_s in pairwise(times_s)
        if before_s < begin_s or after_s > end_s
    ]
    longest_s = max(gaps_s, default=0.0)
    if longest_s > rules.force_gap_s:
        yield (
            f"the force meter gave no value for {longest_s:.2f} s, across an edge of the voltage "
            f"(limit {rules.force_gap_s:g} s)"
        )


def check_drive(drive_V: FloatArray, limit_V: float, rules: Rules) -> None:
    """Raise OvervoltageError when the read-back is beyond the limit, whatever was written.

    A single sample, or an edge's overshoot, is not enough: most of the block must be beyond it.
    """
    most_V = limit_V + rules.drive_tolerance_V
    if np.abs(drive_V).max(initial=0.0) <= most_V:
        return  # as nearly always, and ten times as quick as a median; not where one is no number
    finite = drive_V[np.isfinite(drive_V)]
    seen_V = float(np.median(finite)) if finite.size else 0.0
    if abs(seen_V) > most_V:
        raise OvervoltageError(
            f"the drive reads back {seen_V:.3g} V, beyond the limit of {limit_V:g} V; measure the "
            "amplifier's gain, correct [amplifier] gain or the wiring of the read-back"
        )


def bad_frame(frame: Frame, before: Frame | None, reach_s: float, rules: Rules) -> Iterator[str]:
    """Reasons in a reading's picture; `before` is that of the reading before.

    A frame that came later than `reach_s` shows a moment that is none of the reading's, unless its
    trigger says which it shows.
    """
    if frame.trigger_s is None and frame.late_s > reach_s:
        yield f"its frame came {frame.late_s * 1e3:.0f} ms late"
    coarse = frame.image[_COARSE, _COARSE]
    if coarse.std() < rules.blank_frame * np.iinfo(frame.image.dtype).max:
        yield "its frame is blank"
    elif before is not None and np.array_equal(frame.image, before.image):
        # Noise alone makes any two pictures differ.
        yield "its frame is the picture of the reading before, bit by bit: the camera is frozen"
