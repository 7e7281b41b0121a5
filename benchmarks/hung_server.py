"""A device server that hangs: seconds until the operator is told, and until the run has ended.

    python -m benchmarks.hung_server --times 3

The network to the boards is cut, which to labrig is a server that takes every request and never
answers: in a run before its first voltage (`before`), in a pulse (`pulse`), and when a stop was
asked for (`stop`); with the output guard, and with the guard killed at the same moment. Linux.
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass
from itertools import product
from pathlib import Path

from tests.end_to_end.real_rig import ServedRig, children, serving
from tests.end_to_end.relay import Relay

MOMENTS = ("before", "pulse", "stop")
TOLD_WITHIN_S, ENDED_WITHIN_S = 2.0, 10.0
_TOLD = ("switch the amplifier off", "does not answer")
_READY = "run 1 of"
_LONGEST_S = 60.0


@dataclass(frozen=True)
class Hang:
    """How one went. `told_s`: until the operator was told; `code`: of the run."""

    moment: str
    guarded: bool
    told_s: float
    ended_s: float
    code: int
    guards: tuple[int, ...]  # processes that may still try, and write what they do

    @property
    def good(self) -> bool:
        """Whether it kept the promise."""
        return self.told_s <= TOLD_WITHIN_S and self.ended_s <= ENDED_WITHIN_S and self.code == 6

    @property
    def words(self) -> str:
        """One line."""
        guard = "guard" if self.guarded else "no guard"
        return (
            f"{self.moment:6} {guard:8} told {self.told_s:.2f} s, ended {self.ended_s:.2f} s, "
            f"code {self.code}"
        )


def guards(pid: int) -> list[int]:
    """Return the guard's process, if it has been started."""
    return [
        child
        for child in children(pid)
        if b"drivers.guard" in Path(f"/proc/{child}/cmdline").read_bytes()
    ]


def hang(rig: ServedRig, network: Relay, moment: str, *, guarded: bool) -> Hang:
    """Run, let the server hang at that moment, and wait for the end."""
    process = rig.start() if moment == "before" else rig.energised()
    if moment == "before":
        rig.until(lambda: _READY in rig.said())
    else:
        rig.until(rig.is_energised)
    if moment == "stop":
        process.terminate()
    network.cut()
    began_s, before = time.monotonic(), len(rig.said())
    watching = guards(process.pid)
    if not guarded:
        for pid in watching:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
    told_s: list[float] = []

    def over() -> bool:
        if not told_s and any(words in rig.said()[before:] for words in _TOLD):
            told_s.append(time.monotonic() - began_s)
        return process.poll() is not None

    rig.until(over, _LONGEST_S)
    ended_s = time.monotonic() - began_s
    told = (told_s or [ended_s])[0]
    return Hang(moment, guarded, told, ended_s, process.wait(), tuple(watching))


def is_alive(pid: int) -> bool:
    """Whether there is such a process."""
    return Path(f"/proc/{pid}").exists()


def main() -> None:
    """Print a line for each, and the counts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--times", type=int, default=3)
    times = parser.parse_args().times
    found: list[Hang] = []
    with tempfile.TemporaryDirectory() as folder, serving(Path(folder)) as rig:
        real = rig.addresses["grpc"]
        file = rig.folder / "rig" / "rig.toml"
        network = Relay(int(real.rpartition(":")[2]))
        file.write_text(file.read_text().replace(real, f"127.0.0.1:{network.port}"))
        for moment, guarded, _ in product(MOMENTS, (True, False), range(times)):
            found.append(hang(rig, network, moment, guarded=guarded))
            print(found[-1].words, flush=True)
            network.mend()
            command = [sys.executable, "-m", "labrig", "safe", str(file)]
            subprocess.run(command, check=True, capture_output=True)
            # a guard that still wrote would do so into the next run's output
            rig.until(lambda: not any(map(is_alive, found[-1].guards)), _LONGEST_S)
    for moment, guarded in product(MOMENTS, (True, False)):
        some = [each for each in found if (each.moment, each.guarded) == (moment, guarded)]
        print(
            f"{moment}, {'guard' if guarded else 'no guard'}: "
            f"{sum(each.good for each in some)} of {len(some)}, told at the latest after "
            f"{max(each.told_s for each in some):.2f} s, ended after "
            f"{max(each.ended_s for each in some):.2f} s"
        )


if __name__ == "__main__":
    main()
