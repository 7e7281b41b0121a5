"""NI's published examples for voltage, unedited, against the simulated server.

Run: python -m benchmarks.ni_examples CHECKOUT, with the folder of a checkout of ni/nidaqmx-python.
Left out are thermocouples, power, current loops and files of NI's own format (TDMS). The boards
have the names that the examples use; square waves come to the terminals of their triggers.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

BOARDS = (
    "Dev1=PCIe-6363",
    "PXI1Slot3=PXIe-6363",
    "PXI1Slot7=PXIe-6363",
    "cDAQ1=cDAQ-9174",
    "cDAQ1Mod1=NI 9215",
)
EDGES = ("Dev1/PFI0=0.8", "Dev1/PFI8=2")
LEFT_OUT = ("thrmcpl", "power", "current", "tdms")
LONGEST_S = 30.0


def examples(checkout: Path) -> list[Path]:
    """Return the examples for voltage."""
    folder = checkout / "examples"
    found = [*folder.glob("analog_in/*.py"), *folder.glob("analog_out/*.py")]
    found.append(folder / "every_n_samples_event.py")
    return sorted(p for p in found if not any(word in p.name for word in LEFT_OUT))


def outcome(example: Path, address: str) -> str:
    """Run one; empty where it ended as it should, else the last line that it said."""
    here = Path(__file__).resolve().parents[1]
    more = {"PYTHONPATH": str(here), "MPLBACKEND": "Agg"}
    try:
        done = subprocess.run(
            [sys.executable, "-m", "benchmarks._ni_example", str(example), address],
            env=os.environ | more,
            cwd=here,
            capture_output=True,
            text=True,
            timeout=LONGEST_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"it had not ended after {LONGEST_S:g} s"
    said = done.stderr.strip().splitlines()
    return "" if done.returncode == 0 else (said or ["?"])[-1]


def main(arguments: list[str]) -> int:
    """Run all and print a line for each."""
    if not arguments:
        print("left out: name the folder of a checkout of ni/nidaqmx-python")
        return 0
    command = [sys.executable, "-m", "sim_hardware", "serve", "--end-with-input"]
    command += ["--wire", "ao3:ai31", "--test-signals", "--strict-ownership"]
    command += [text for board in BOARDS for text in ("--device", board)]
    command += [text for edge in EDGES for text in ("--edges", edge)]
    root = Path(__file__).resolve().parents[1]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=root
    ) as server:
        address = (server.stdout.readline() if server.stdout else "").rpartition("=")[2].strip()
        found = examples(Path(arguments[0]).resolve())
        faults = {example: outcome(example, address) for example in found}
        server.terminate()
    for example, fault in faults.items():
        print(f"{example.parent.name}/{example.name}: {fault or 'ended as it should'}")
    print(f"{sum(not fault for fault in faults.values())} of {len(faults)}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
