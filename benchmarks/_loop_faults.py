"""Random faults in a controlled run on the simulated rig, and what the board put out afterwards."""

from __future__ import annotations

import io
import random
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from labrig.cli.main import run
from labrig.config.templates import write_templates
from labrig.session import open_session
from protocols.execution.events import OutputState
from sim_hardware.world import World
from tests.labrig.simple_controller import write_control

LIMIT_V = 0.2  # of the board: 2 V at the sheet
LONGEST_S = 6.0  # of boards that hang
_PROTOCOL = """
moisten = false
[pulse_train]
[[places]]
configuration = "long"
positions_mm = [10]
[extras]
"""
FOR_GOOD = None
# What goes wrong, and for how long (least, most, s). Nobody can write 0 V to boards that never
# answer again: they do within the time that the safe shutdown of the program itself tries.
FAULTS: dict[str, tuple[float, float] | None] = {
    "daq_refused": (0.05, 0.8),
    "daq_write_refused": (0.05, 0.8),
    "daq_buffer_overflow": (0.05, 0.8),
    "daq_hung": (1.2, LONGEST_S),
    "daq_read_hung": (1.2, LONGEST_S),
    "daq_slow": FOR_GOOD,
    "force_nan": FOR_GOOD,
    "cell_unplugged": FOR_GOOD,
    "cell_overloaded": FOR_GOOD,
    "camera_gone": FOR_GOOD,
    "clock_jump": FOR_GOOD,
}


@dataclass(frozen=True)
class Fault:
    """One fault, from a moment after the first voltage."""

    what: str
    from_s: float
    until_s: float | None
    amount_s: float

    def toml(self) -> str:
        until = "" if self.until_s is None else f"until_s = {self.until_s:.4f}\n"
        return (
            f'[[faults]]\nwhat = "{self.what}"\nsince = "first_voltage"\n'
            f"from_s = {self.from_s:.4f}\n{until}amount_s = {self.amount_s:.4f}\n"
        )


@dataclass(frozen=True)
class Ended:
    """How a run with a fault ended."""

    fault: Fault
    code: int
    board_V: float  # the last voltage that the board was told
    highest_V: float
    zero_after_s: float  # from the fault to the first 0 V after it, on the rig's clock
    output: OutputState
    said: str

    @property
    def is_safe(self) -> bool:
        """Whether 0 V was the last voltage, the file says so, and no limit was passed."""
        return (
            self.board_V == 0.0
            and self.output is OutputState.SAFE
            and self.highest_V <= LIMIT_V * (1 + 1e-6)
            and self.code == 5
            and "Traceback" not in self.said
        )


def random_faults(count: int, seed: int) -> Iterator[Fault]:
    """Yield faults at random moments, each kind as often as any other."""
    dice = random.Random(seed)
    kinds = list(FAULTS)
    for number in range(count):
        what = kinds[number % len(kinds)]
        from_s = dice.uniform(0.05, 3.0)
        lasts_s = FAULTS[what]
        until_s = None if lasts_s is None else from_s + dice.uniform(*lasts_s)
        amount_s = dice.uniform(1.0, 5.0) if what == "clock_jump" else dice.uniform(0.03, 0.3)
        yield Fault(what, from_s, until_s, amount_s)


def run_with(fault: Fault) -> Ended:
    """Run the shipped rig under control with this fault."""
    with TemporaryDirectory() as name, _spied() as writes:
        folder = Path(name)
        write_templates(folder, simulated=True)
        (folder / "protocol.toml").write_text(_PROTOCOL)
        (folder / "world.toml").write_text(fault.toml())
        rig = folder / "rig.toml"
        rig.write_text(rig.read_text().replace("# world =", "world ="))
        options = write_control(folder, position_mm=10.0)
        files = [folder / file for file in ("rig.toml", "protocol.toml", "sheet.toml")]
        said = io.StringIO()
        with redirect_stdout(said), redirect_stderr(said):
            code = run([str(each) for each in ("run", *files, "-o", folder / "s.h5", *options)])
        with open_session(folder / "s.h5") as session:
            output = session.output_state
        first_s = next(when for when, volts in writes if volts)
        began_s = first_s + fault.from_s
        zeros = [when for when, volts in writes if when >= began_s and volts == 0.0]
        return Ended(
            fault=fault,
            code=code,
            board_V=writes[-1][1],
            highest_V=max(abs(volts) for _, volts in writes),
            zero_after_s=zeros[0] - began_s if zeros else float("inf"),
            output=output,
            said=said.getvalue(),
        )


@contextmanager
def _spied() -> Iterator[list[tuple[float, float]]]:
    """Yield what the simulated board is told, (clock time, volts), as it comes."""
    writes: list[tuple[float, float]] = []
    real = World.write

    def write(self: World, device: str, channel: str, volts: float, when: float) -> None:
        if channel == "ao0":
            writes.append((when, volts))
        real(self, device, channel, volts, when)

    World.write = write  # type: ignore[method-assign]
    try:
        yield writes
    finally:
        World.write = real  # type: ignore[method-assign]
