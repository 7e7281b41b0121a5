"""A cantilever with a dead load across its tip, EI = L = 1, by other programs in their environment.

`python _cantilever_peers.py LOAD`: prints a JSON object, name -> the tip's deflection and the CPU
seconds of one solution, or why there is none.
"""

from __future__ import annotations

import contextlib
import io
import json
import sys
import time
from collections.abc import Callable
from typing import Any


def opensees(elements: int, load: float, steps: int) -> float:
    """Corotational beam elements, the load in equal steps."""
    import openseespy.opensees as ops

    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    for i in range(elements + 1):
        ops.node(i + 1, i / elements, 0.0)
    ops.fix(1, 1, 1, 1)
    ops.geomTransf("Corotational", 1)
    for i in range(elements):  # a larger EA would drown the moments in rounding
        ops.element("elasticBeamColumn", i + 1, i + 1, i + 2, 1e7, 1.0, 1.0, 1)
    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    ops.load(elements + 1, 0.0, load, 0.0)
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", 1e-7, 50)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 1.0 / steps)
    ops.analysis("Static")
    if ops.analyze(steps) != 0:
        raise RuntimeError("no convergence")
    return float(ops.nodeDisp(elements + 1, 2))


def elastica(elements: int, load: float) -> float:
    """A Cosserat rod in time, damped until it rests; it can be sheared and stretched a little."""
    import elastica as ea
    import numpy as np

    class Simulator(ea.BaseSystemCollection, ea.Constraints, ea.Forcing, ea.Damping):
        pass

    radius, until = 0.02, 10.0
    E, area = 4.0 / (np.pi * radius**4), np.pi * radius**2
    axes = np.eye(3)
    rod = ea.CosseratRod.straight_rod(
        elements, np.zeros(3), axes[0], axes[1], 1.0, radius, density=1.0 / area,
        youngs_modulus=E, shear_modulus=E / 3.0,
    )  # fmt: skip
    simulator = Simulator()
    simulator.append(rod)
    simulator.constrain(rod).using(
        ea.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,)
    )
    simulator.add_forcing_to(rod).using(
        ea.EndpointForces, np.zeros(3), load * axes[1], ramp_up_time=1.0
    )
    step = 0.5 * radius / np.sqrt(E * area)  # what its stiffest motion, shear, allows
    simulator.dampen(rod).using(
        ea.AnalyticalLinearDamper, uniform_damping_constant=4.0, time_step=step
    )
    simulator.finalize()
    ea.integrate(ea.PositionVerlet(), simulator, until, int(until / step), progress_bar=False)
    return float(rod.position_collection[1, -1])


def timed(solve: Callable[[], float], repeats: int) -> dict[str, Any]:
    try:
        solve()
        times = []
        for _ in range(repeats):
            began = time.process_time()
            deflection = solve()
            times.append(time.process_time() - began)
    except (ImportError, RuntimeError) as error:
        return {"why": str(error).splitlines()[0]}
    return {"deflection": deflection, "seconds": min(times)}


def main(load: float) -> None:
    with contextlib.redirect_stdout(io.StringIO()):
        found = {
            "OpenSees, 100 elements, one step": timed(lambda: opensees(100, load, 1), 40),
            "OpenSees, 100 elements, five steps": timed(lambda: opensees(100, load, 5), 20),
            "PyElastica, 50 elements": timed(lambda: elastica(50, load), 1),
        }
    print(json.dumps(found))


if __name__ == "__main__":
    main(float(sys.argv[1]))
