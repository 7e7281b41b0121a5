"""A small run on a simulated rig in which something goes wrong, and what is left of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from labrig.session import open_session
from protocols.execution.events import Outcome, OutputState
from sim_hardware.world import World
from tests.end_to_end.small_rig import labrig, make_rig

PROTOCOL = """
[pulse_train]
zero_readings = 1
readings_per_voltage = 2
pulses_discarded = 0
[[places]]
configuration = "long"
positions_mm = [10]
[extras]
mode = "paper"
"""
FILES = ("rig.toml", "protocol.toml", "sheet.toml")


@dataclass
class Left:
    """What a run has left: its exit code, what the operator read, the file, the sheet's voltage."""

    code: int
    said: str
    path: Path
    board_V: float
    highest_V: float
    outcome: Outcome | None = None  # None: there is no session
    output: OutputState | None = None
    reason: str = ""
    readings: int = 0
    invalid: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


@dataclass
class FaultyRig:
    """Runs `labrig run` in this process, on the virtual clock."""

    folder: Path
    capsys: pytest.CaptureFixture[str]
    writes: list[float]
    board: str = "ni"

    def run(
        self,
        world: str = "",
        rig: Sequence[tuple[str, str]] = (),
        *,
        look: bool = True,
        options: Callable[[Path], Sequence[object]] = lambda _: (),
    ) -> Left:
        """Once, with these faults in world.toml and these replacements in rig.toml.

        `look`: into the session, too. `options`: more of the command's, once the files are there.
        """
        folder = make_rig(self.folder / "rig", PROTOCOL, world, self.board)
        text = (folder / "rig.toml").read_text()
        for old, new in rig:
            assert old in text
            text = text.replace(old, new)
        (folder / "rig.toml").write_text(text)
        path = folder / "s.h5"
        code = labrig("run", *(folder / name for name in FILES), "-o", path, *options(folder))
        said = self.capsys.readouterr()
        left = Left(code, said.err + said.out, path, self.writes[-1], max(map(abs, self.writes)))
        if look and path.exists():
            read(left)
        return left


def read(left: Left) -> None:
    """What the session says."""
    with open_session(left.path, live=True) as session:
        left.outcome, left.output = session.outcome, session.output_state
        left.reason = session.reason
        readings = session.runs[0].readings
        left.readings = len(readings)
        left.invalid = [str(row["why"]) for row in readings if not row["valid"]]
        left.warnings = [event.text for event in session.events if event.kind == "warned"]


def spied_writes(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Every voltage that the simulated board is told, as it comes."""
    writes = [0.0]
    real = World.write

    def write(self: World, device: str, channel: str, volts: float, when: float) -> None:
        if channel == "ao0":
            writes.append(volts)
        real(self, device, channel, volts, when)

    monkeypatch.setattr(World, "write", write)
    return writes
