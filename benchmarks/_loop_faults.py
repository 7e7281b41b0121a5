"""Random faults in a controlled run on the simulated rig, and what the board put out afterwards."""

from __future__ import annotations

import io
import random
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks._spied_output import highest_V, spied_output, under_voltage_s
from labrig.cli.main import run
from labrig.config.templates import write_templates
from labrig.session import open_session
from protocols.execution.events import OutputState
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
mode = "paper"
"""
FOR_GOOD = None
NOBODY_CAN = " for good"
# What goes wrong, and for how long (least, most, s). Boards that refuse or hang for some time
# answer within the time that the safe shutdown of the program itself tries.
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
    # Nobody can write 0 V to these, or read it back: UNKNOWN has to be said.
    "daq_refused" + NOBODY_CAN: FOR_GOOD,
    "daq_write_refused" + NOBODY_CAN: FOR_GOOD,
    "output_stuck" + NOBODY_CAN: FOR_GOOD,
    "drive_nan" + NOBODY_CAN: FOR_GOOD,
}


@dataclass(frozen=True)
class Fault:
    """One fault, from a moment after the first voltage."""

    name: str  # of FAULTS
    from_s: float
    until_s: float | None
    amount_s: float

    @property
    def can_be_made_safe(self) -> bool:
        """Whether the boards answer again."""
        return not self.name.endswith(NOBODY_CAN)

    def toml(self) -> str:
        until = "" if self.until_s is None else f"until_s = {self.until_s:.4f}\n"
        what = self.name.removesuffix(NOBODY_CAN)
        return (
            f'[[faults]]\nwhat = "{what}"\nsince = "first_voltage"\n'
            f"from_s = {self.from_s:.4f}\n{until}amount_s = {self.amount_s:.4f}\n"
        )


@dataclass(frozen=True, kw_only=True)
class Ended:
    """How a run with a fault ended."""

    name: str
    code: int
    board_V: float  # the last voltage that the board was told
    highest_V: float
    under_voltage_s: float
    zero_after_s: float  # from the fault to the first 0 V after it, on the rig's clock
    output: str
    says_unknown: bool
    has_traceback: bool
    can_be_made_safe: bool

    @property
    def is_right(self) -> bool:
        """Whether it ended at 0 V and says so; where nobody can do that, whether it says that."""
        if self.has_traceback or self.highest_V > LIMIT_V * (1 + 1e-6):
            return False
        if self.can_be_made_safe:
            safe = self.board_V == 0.0 and self.output == OutputState.SAFE.value
            return safe and self.code == 5 and not self.says_unknown
        return self.code == 6 and self.output == OutputState.UNKNOWN.value and self.says_unknown


def random_faults(count: int, seed: int) -> Iterator[Fault]:
    """Yield faults at random moments, each kind as often as any other."""
    dice = random.Random(seed)
    kinds = list(FAULTS)
    for number in range(count):
        name = kinds[number % len(kinds)]
        from_s = dice.uniform(0.05, 3.0)
        lasts_s = FAULTS[name]
        until_s = None if lasts_s is None else from_s + dice.uniform(*lasts_s)
        amount_s = dice.uniform(1.0, 5.0) if name == "clock_jump" else dice.uniform(0.03, 0.3)
        yield Fault(name, from_s, until_s, amount_s)


def run_with(fault: Fault) -> Ended:
    """Run the shipped rig under control with this fault."""
    with TemporaryDirectory() as name, spied_output() as writes:
        folder = Path(name)
        write_templates(folder, simulated=True)
        (folder / "protocol.toml").write_text(_PROTOCOL)
        (folder / "world.toml").write_text(fault.toml())
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
        name=fault.name,
        code=code,
        board_V=writes[-1][1],
        highest_V=highest_V(writes),
        under_voltage_s=under_voltage_s(writes),
        zero_after_s=zeros[0] - began_s if zeros else float("inf"),
        output="" if output is None else output.value,
        says_unknown="NOT KNOWN TO BE SAFE" in said.getvalue(),
        has_traceback="Traceback" in said.getvalue(),
        can_be_made_safe=fault.can_be_made_safe,
    )
