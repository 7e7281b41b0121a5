"""What the read-back of the sheet's voltage shows during a run, and what ends the run."""

from __future__ import annotations

import numpy as np

from drivers.interfaces import DeviceError, FloatArray, OvervoltageError
from protocols.execution.rules import Rules, check_drive

NEWEST_S = 0.02  # of the read-back: its newest samples


class ReadBack:
    """Follows the drive channel of one run.

    It raises where the sheet has more than the limit, where it keeps a voltage long after 0 V was
    written, and where its voltage cannot be seen: what nobody sees may be any voltage.
    """

    def __init__(self, rules: Rules, limit_V: float, rate_hz: float, now_s: float) -> None:
        self._rules, self._limit_V = rules, limit_V
        self._newest = max(1, round(NEWEST_S * rate_hz))
        self._drive_V = 0.0  # when it was last seen
        self._seen_s = now_s  # and when that was
        self._zero_since_s: float | None = None  # when 0 V was written; None: it is not at 0 V
        self._looked_since_s = now_s  # for the 0 V that was written
        self._shown = False  # whether it was then seen at 0 V

    @property
    def shows_zero(self) -> bool:
        """Whether 0 V was written, has been seen since, and has not gone again."""
        return self._shown and not self._is_far()

    def take(self, drive_V: FloatArray, read_s: float, at_zero_s: float) -> None:
        """Look at samples that arrived at `read_s`, so long after 0 V was written (0: it was not).

        Raises OvervoltageError, DeviceError.
        """
        check_drive(drive_V, self._limit_V, self._rules)
        self._note_zero(read_s, at_zero_s)
        newest = drive_V[-self._newest :]
        numbers = newest[np.isfinite(newest)]
        if not numbers.size:
            self._check_seen(read_s)
            return
        self._drive_V, self._seen_s = float(np.median(numbers)), read_s
        if self._zero_since_s is not None:
            self._shown = self._shown or abs(self._drive_V) < self._rules.safe_below_V
            self._check_zero(read_s, at_zero_s)

    def _note_zero(self, read_s: float, at_zero_s: float) -> None:
        """Begin anew where 0 V was written since the last look, or is no longer there."""
        since_s = read_s - at_zero_s if at_zero_s > 0.0 else None
        known_s = self._zero_since_s
        if since_s is None or known_s is None or abs(since_s - known_s) > 1e-6:
            self._shown = False
            self._looked_since_s = max(self._looked_since_s, since_s or read_s)
        self._zero_since_s = since_s

    def _check_seen(self, read_s: float) -> None:
        unseen_s = read_s - self._seen_s
        if unseen_s > self._rules.unseen_s:
            raise DeviceError(
                f"the read-back of the drive has been no number for {unseen_s:.1f} s: nobody sees "
                "which voltage the sheet has; check the input of the read-back and its wiring"
            )

    def _check_zero(self, read_s: float, at_zero_s: float) -> None:
        within_s = self._rules.zero_within_s
        never = not self._shown and read_s - self._looked_since_s > within_s
        if at_zero_s > within_s and (never or self._is_far()):
            raise OvervoltageError(
                f"0 V was written {at_zero_s:.1f} s ago, and the drive still reads back "
                f"{self._drive_V:.3g} V"
            )

    def _is_far(self) -> bool:
        return abs(self._drive_V) > self._rules.drive_tolerance_V
