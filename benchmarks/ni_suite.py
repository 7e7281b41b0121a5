"""NI's own test-suite for nidaqmx-python against the simulated server.

Run: python -m benchmarks.ni_suite CHECKOUT, with the folder of a checkout of ni/nidaqmx-python.
It needs pykka (pip install pykka). The tests for gRPC alone are run: component, legacy, acceptance.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

FOLDERS = ("tests/component", "tests/legacy", "tests/acceptance")


def main(arguments: list[str]) -> int:
    """Run the suite and print pytest's last line."""
    if not arguments:
        print("left out: name the folder of a checkout of ni/nidaqmx-python")
        return 0
    here = Path(__file__).resolve().parents[1]
    command = [sys.executable, "-m", "pytest", "-p", "benchmarks._ni_suite_plugin", *FOLDERS]
    command += ["-k", "grpc_init_kwargs", "-q", "--tb=no", "-o", "addopts=", "-W", "ignore"]
    command += ["--timeout", "60", "--continue-on-collection-errors"]
    path = os.pathsep.join([arguments[0], str(here), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        command,
        cwd=arguments[0],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    lines = [line for line in done.stdout.splitlines() if " passed" in line]
    print(lines[-1] if lines else done.stdout + done.stderr)
    return 0 if lines else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
