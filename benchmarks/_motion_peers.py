"""The sheet let go from a large deflection, by Exudyn in the peers' environment.

`python _motion_peers.py`: JSON on stdin (B, mu, l, eta, load, times_s); prints a JSON object,
name -> tip's y at the times and the CPU seconds of the motion alone, or why there is none.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any

AXIAL_N = 346.0  # stiffness in tension: 150 MPa times the cross-section


def release(elements: int, step_s: float, given: dict[str, Any]) -> dict[str, Any]:
    """ANCF cable elements, generalized-alpha; held by a tip load first, then let go."""
    import exudyn as exu
    from exudyn.beams import GenerateStraightLineANCFCable2D
    from exudyn.utilities import Cable2D, Force, MarkerNodePosition, SensorNode

    system = exu.SystemContainer()
    mbs = system.AddSystem()
    cable = Cable2D(
        physicsMassPerLength=given["mu"],
        physicsBendingStiffness=given["B"],
        physicsAxialStiffness=AXIAL_N,
        physicsBendingDamping=given["B"] * given["eta"],
    )
    made = GenerateStraightLineANCFCable2D(
        mbs=mbs,
        positionOfNode0=[0, 0, 0],
        positionOfNode1=[given["l"], 0, 0],
        numberOfElements=elements,
        cableTemplate=cable,
        massProportionalLoad=[0, 0, 0],
        fixedConstraintsNode0=[1, 1, 0, 1],
        fixedConstraintsNode1=[0, 0, 0, 0],
    )
    tip = made[0][-1]
    marker = mbs.AddMarker(MarkerNodePosition(nodeNumber=tip))
    load = mbs.AddLoad(Force(markerNumber=marker, loadVector=[0, given["load"], 0]))
    sensor = mbs.AddSensor(
        SensorNode(
            nodeNumber=tip, storeInternal=True, outputVariableType=exu.OutputVariableType.Position
        )
    )
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.staticSolver.numberOfLoadSteps = 10
    settings.staticSolver.newton.relativeTolerance = 1e-8
    settings.staticSolver.newton.absoluteTolerance = 1e-12
    settings.solutionSettings.writeSolutionToFile = False
    settings.solution.sensors.writePeriod = 0.02
    settings.timeIntegration.verboseMode = settings.staticSolver.verboseMode = 0
    mbs.SolveStatic(settings)
    held = mbs.systemData.GetODE2Coordinates()
    mbs.SetLoadParameter(load, "loadVector", [0, 0, 0])
    end = given["times_s"][-1]
    settings.timeIntegration.endTime = end
    settings.timeIntegration.numberOfSteps = round(end / step_s)
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.linearSolver.solverType = exu.LinearSolverType.EXUdense
    best = float("inf")
    for _ in range(3):
        mbs.systemData.SetODE2Coordinates(held, exu.ConfigurationType.Initial)
        began = time.process_time()
        mbs.SolveDynamic(settings)
        best = min(best, time.process_time() - began)
    rows = mbs.GetSensorStoredData(sensor)
    found = {round(float(row[0]), 9): float(row[2]) for row in rows}
    return {"tip_y_m": [found[round(t, 9)] for t in given["times_s"]], "seconds": best}


def main() -> None:
    given = json.loads(sys.stdin.read())
    found: dict[str, Any] = {}
    for elements, step_s in ((5, 1e-3), (10, 5e-4)):
        name = f"Exudyn, {elements} elements, {step_s * 1e3:g} ms"
        try:
            found[name] = release(elements, step_s, given)
        except Exception as error:  # noqa: BLE001  (a peer may fail in any way)
            found[name] = {"why": str(error).splitlines()[0] if str(error) else repr(error)}
    print(json.dumps(found))


if __name__ == "__main__":
    main()
