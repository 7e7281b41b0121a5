"""What a newcomer waits for: the demo from nothing, and the documentation.

    python -m benchmarks from_nothing

CPU times are those of all processes. The demo is installed into a new environment and compiles all
it needs; the documentation is built with compiled code that is kept.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from benchmarks.report import Report, Table, busy

ROOT = Path(__file__).parents[1]
DEMO_S, DOCS_S = 200.0, 90.0  # goals


def measure() -> Report:
    """Return CPU seconds of installation, demo and documentation."""
    with tempfile.TemporaryDirectory(prefix="labrig-from-nothing-") as folder:
        place = Path(folder)
        fresh = os.environ | {"NUMBA_CACHE_DIR": str(place / "compiled")}
        environment = place / "venv"
        install = _cpu_s(("make", "setup", f"VENV={environment}"), fresh)
        labrig = environment / "bin" / "labrig"
        demo = _cpu_s((str(labrig), "demo", str(place / "demo")), fresh)
        sphinx = (sys.executable, "-m", "sphinx", "-b", "html", "-W", "-q", "docs")
        docs = _cpu_s((*sphinx, str(place / "html")), dict(os.environ))
    rows = (
        ("installation", f"{install:.0f}", ""),
        ("demo, all that it needs compiled", f"{demo:.0f}", ""),
        ("both", f"{install + demo:.0f}", f"{DEMO_S:.0f}"),
        ("documentation, compiled code kept", f"{docs:.0f}", f"{DOCS_S:.0f}"),
    )
    return Report(
        tables=(Table("From nothing", ("what", "CPU, s", "goal, s"), rows),),
        figures={"install_s": install, "demo_s": demo, "docs_s": docs},
        notes=(busy(),),
    )


def _cpu_s(command: tuple[str, ...], environment: dict[str, str]) -> float:
    """Run a command in the repository; return the CPU time of its processes."""
    before = os.times()
    subprocess.run(command, cwd=ROOT, env=environment, check=True, stdout=subprocess.DEVNULL)
    after = os.times()
    user = after.children_user - before.children_user
    return user + after.children_system - before.children_system
