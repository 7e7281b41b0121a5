"""A cantilever with a dead load across its tip (F l^2/EI = 2) against OpenSees and PyElastica.

The peers run in an environment of their own. The exact deflection is Mattiasson's elliptic integral
(20 digits; tests/data/reference). CPU times of one solution, set-up included, as each program's
user would write it.
"""

from __future__ import annotations

import benchmarks._one_thread  # noqa: F401  (before numpy)

# isort: split

import csv
import json
import subprocess
from pathlib import Path
from typing import Any

from benchmarks.model_equilibrium import cpu
from benchmarks.overhead_per_reading import peers_python
from benchmarks.report import Report, Table
from model.mechanics.field import Field
from model.mechanics.tip_load import tip_load

LOAD = 2.0
_HERE = Path(__file__).parent
_EXACT = _HERE.parent / "tests" / "data" / "reference" / "i_mattiasson_dead_tip_load.csv"


def exact() -> float:
    with _EXACT.open() as file:
        for row in csv.DictReader(file):
            if float(row["FL2_over_EI"]) == LOAD:
                return float(row["w_over_L(deflection)"])
    raise ValueError(f"no reference for a load of {LOAD}")


def peers() -> dict[str, dict[str, Any]]:
    script = str(_HERE / "_cantilever_peers.py")
    done = subprocess.run(
        [str(peers_python()), script, str(LOAD)], capture_output=True, text=True, check=True
    )
    last = [line for line in done.stdout.splitlines() if line.startswith("{")][-1]
    found: dict[str, dict[str, Any]] = json.loads(last)
    return found


def measure() -> Report:
    """About half a minute; longer when the peers' environment is made."""
    straight, wanted = Field.constant(0.0, 1.0), exact()
    tip = tip_load(straight, (0.0, LOAD), follows=False).tip_y_m
    own = cpu(lambda: tip_load(straight, (0.0, LOAD), follows=False), 200)
    found = {"labrig": {"deflection": tip, "seconds": own}, **peers()}
    rows, notes = [], []
    for name, one in found.items():
        if "why" in one:
            notes.append(f"{name}: not measured, {one['why']}")
            continue
        error = abs(one["deflection"] / wanted - 1.0)
        rows.append((
            name, f"{one['seconds'] * 1e3:.3g} ms", f"{one['seconds'] / own:.0f}", f"{error:.0e}"
        ))  # fmt: skip
    table = Table("Cantilever, dead tip load", ("", "CPU time", "ratio", "error"), tuple(rows))
    return Report((table,), {**found, "exact": wanted}, tuple(notes))


if __name__ == "__main__":
    print(measure().text())
