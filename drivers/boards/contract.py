"""A family of boards: its table in rig.toml, how to connect to it, and how it is made safe.

A module of this folder, or a distribution with an entry point of the group `labrig.boards`, adds a
family by the constant `BOARDS`. Its kind is the name of its table in rig.toml.
The functions in `conformance` find one that breaks its contract.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, runtime_checkable

from drivers.amplifier import BoardOutput
from drivers.interfaces import Clock, Interlock, SignalInput
from drivers.kinds import kind_faults
from drivers.plugins import PluginFolder
from drivers.safe_shutdown import SafetyReport

DEFAULT = "ni"  # the family of a rig.toml that has no table of boards
FORCE, CURRENT, DRIVE = "force", "current", "drive"  # channels; drive: the sheet's voltage


class BoardInput(NamedTuple):
    """An input: the channel's name, where it is wired, and the largest voltage expected there."""

    name: str
    terminal: str  # in the family's own words, such as PCI6034E/ai0
    range_V: float  # either sign; the board takes the next larger range that it has


@dataclass(frozen=True)
class BoardFinding:
    """One thing that `labrig check` reports of the boards."""

    name: str
    ok: bool
    found: str
    wanted: str


@runtime_checkable
class BoardConnection(Protocol):
    """The boards of one rig. Everything raises DeviceError and nothing else.

    It reports what the boards are, and whether they are simulated, where it is `Identified`.
    """

    def open(self) -> None:
        """Make sure that somebody answers; blocks for 10 s at most. May be called twice.

        Raises DeviceNotFoundError, DeviceTimeoutError.
        """

    def findings(self) -> Sequence[BoardFinding]:
        """Return whether the boards that rig.toml names are there, in order. Open."""

    def voltage_output(self, limit_V: float) -> BoardOutput:
        """Return the output that drives the amplifier, not open yet.

        It refuses every value beyond ±`limit_V` (board volts) by itself, sends nothing, and raises
        LimitError.
        """

    def signal_input(self, inputs: Sequence[BoardInput]) -> SignalInput:
        """Return these inputs, wired differentially, as one acquisition; not open yet."""

    def interlock(self, line: str | None) -> Interlock:
        """Return what must hear of the working loop while a run is under way, not open yet.

        With `line`, an external interlock's. None, only where `own_watchdog` says that the boards
        watch by themselves without one.
        """

    def close(self) -> None:
        """Let go of the boards; what was made here is closed by then. May be called twice."""


@runtime_checkable
class OutputRescue(Protocol):
    """Makes the output safe from another process than the one that drives it.

    The guard opens one before the first voltage and keeps it; `labrig safe` opens one.
    """

    def open(self) -> None:
        """Connect, and load all that `make_safe` needs. Raises DeviceError. May be called again."""

    def make_safe(self, patience_s: float, on_held: Callable[[], None]) -> SafetyReport:
        """Take the output from whoever holds it, write 0 V, read it back, let go. Never raises.

        A device that somebody still holds is tried again for `patience_s`; `on_held` is called
        where only the end of that program would free it (the guard then ends the one that hangs).
        Safe may be reported only of 0 V that was written and read back.
        """

    def close(self) -> None:
        """Let go of the boards. Never raises; may be called twice."""


Transport = Any  # what a family's simulated device is reached through


def _any_line(name: str) -> object:
    """Take any name for a line."""
    return name.lower()


@dataclass(frozen=True, kw_only=True)
class Starter:
    """Text of a rig.toml to start from: each part whole lines of TOML, with comments."""

    table: str  # of the family
    simulated_table: str  # the same for a rig that needs no hardware
    interlock: str  # the table [interlock], commented out
    trigger_line: str = ""  # a digital line that may trigger a camera


def _no_watchdog(_settings: Any, _line: str | None) -> str:
    """Do nothing by itself."""
    return ""


@dataclass(frozen=True, kw_only=True)
class BoardFamily:
    """A family of boards.

    Its settings have at least `address` (where the boards are; `check` in its metadata refuses what
    is no address) and `sample_rate_hz` (of each input channel).
    """

    kind: str
    help: str  # one line
    settings: type
    # Make a connection, not open yet, from the settings and a clock; the transport, where there is
    # one, stands for what `address` names: the simulator's hook. Touches no device.
    connect: Callable[[Any, Clock, Transport | None], BoardConnection]
    # Return the channels force, current and drive as the settings wire them.
    inputs: Callable[[Any], tuple[BoardInput, ...]]
    # What another process needs to make the output safe, as plain data (JSON): from the settings,
    # the limit at the board in V, the voltage that counts as 0 V, the interlock's line if any.
    output_place: Callable[[Any, float, float, str | None], dict[str, Any]]
    # Make a rescue of that plain data. Raises DeviceError when it makes no sense. None: such boards
    # cannot be made safe from outside, and no rig is wired with them.
    rescue: Callable[[Mapping[str, Any], Clock], OutputRescue] | None = None
    # Return what is equal for all names of one digital line. Raise ValueError, with what a line
    # must be, where there can be none of this name.
    check_line: Callable[[str], object] = _any_line
    # Say what a watchdog in the boards' hardware does when labrig is silent, from the settings and
    # the interlock's line if any. Empty: there is none, and they hold their voltage.
    own_watchdog: Callable[[Any, str | None], str] = _no_watchdog
    # Whether `connect` reaches a simulated family through its transport. `labrig init --simulated`
    # then writes its table with address = "simulated", where no `starter` does.
    can_be_simulated: bool = False
    # For `labrig init --board`; None: there is nothing to start from.
    starter: Starter | None = None


def faults(part: object) -> list[str]:
    """Return what is wrong with a family of boards, a sentence each."""
    calls = {
        "connect": ("settings", "clock", "transport"),
        "inputs": ("settings",),
        "output_place": ("settings", "limit_V", "safe_below_V", "line"),
        "rescue": ("place", "clock"),
        "check_line": ("name",),
        "own_watchdog": ("settings", "line"),
    }
    return list(kind_faults(part, BoardFamily, calls, needed=("address", "sample_rate_hz")))


BOARD_FAMILIES: PluginFolder[BoardFamily] = PluginFolder(
    what="family of boards",
    package="drivers.boards",
    constant="BOARDS",
    group="labrig.boards",
    faults=faults,
)
