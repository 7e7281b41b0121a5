"""A free step and release: what tells the sheet's mass and loss."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from protocols.extras.contract import Extra, ExtraRun, largest_V, voltages_or_own
from protocols.kinds.bounds import require_no_0_V
from protocols.kinds.contract import ProtocolKind
from protocols.kinds.fields import duration
from protocols.planning.builder import Builder, StepsAndReadings


@dataclass(frozen=True, kw_only=True)
class Release(Extra):
    """A free sheet under voltage, then at 0 V, where it swings; every frame is kept.

    A sheet that the load cell holds hardly moves, so pulses in contact tell neither its mass nor
    its loss; this does. It begins at rest.
    """

    name: ClassVar[str] = "release"
    dynamic: ClassVar[bool] = True

    voltages_V: tuple[float, ...] = voltages_or_own(
        "one release after each; none: the largest positive one of the protocol"
    )
    rest_s: float = duration(3.0, "at 0 V, before the voltage", may_be_0=True)
    hold_s: float = duration(0.6, "under voltage")
    swing_s: float = duration(1.5, "at 0 V, after the voltage")

    def check(self) -> None:
        """Raise ScheduleError for a release from 0 V."""
        require_no_0_V(self.voltages_V, "no release")

    def runs(
        self,
        protocol: ProtocolKind,
        positions_m: tuple[float, ...],  # noqa: ARG002 - the load cell is away
    ) -> Iterator[ExtraRun]:
        """See `Extra.runs`."""
        for voltage_V in self.voltages_V or (largest_V(protocol),):
            yield ExtraRun(parts=self._parts(voltage_V), keep_all_frames=True)

    def _parts(self, voltage_V: float) -> StepsAndReadings:
        run = Builder()
        if self.rest_s:
            run.step(0.0, self.rest_s)
        run.step(voltage_V, self.hold_s)
        run.step(0.0, self.swing_s)
        return run.finish()


EXTRA = Release
