"""`python -m benchmarks.soak`: kill runs, judge them, print a table; ends with 1 if one failed."""

from __future__ import annotations

import argparse
import platform
import sys
import tempfile
from pathlib import Path

from benchmarks.soak.figures import line, summary
from benchmarks.soak.judge import Verdict
from benchmarks.soak.series import soak


def main() -> int:
    """Run the soak; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.soak")
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1, help="rigs side by side (default: 1)")
    parser.add_argument("--only", type=int, nargs="+", default=[], help="of the runs, by number")
    parser.add_argument("--folder", type=Path, help="where to work (default: a temporary folder)")
    options = parser.parse_args()
    if sys.platform != "linux":
        sys.stderr.write("soak: looks for stray processes in /proc, which only Linux has\n")
        return 2
    folder = options.folder or Path(tempfile.mkdtemp(prefix="labrig-soak-"))
    folder.mkdir(exist_ok=True)
    verdicts = soak(options.runs, options.seed, folder, _tell, options.jobs, options.only)
    print(f"\n{len(verdicts)} runs, seed {options.seed}, {platform.platform()}")
    print("\n".join(summary(verdicts)))
    failed = [v for v in verdicts if v.faults]
    if failed:
        print(f"{len(failed)} runs failed; their files are in {folder}")
    return 1 if failed else 0


def _tell(verdict: Verdict) -> None:
    print(line(verdict), flush=True)


if __name__ == "__main__":
    sys.exit(main())
