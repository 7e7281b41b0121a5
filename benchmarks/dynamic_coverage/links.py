"""How far a chain of few links leads `identify` astray, in stated standard deviations.

The world without noise, in chains of more and more links, against the model: to first order the
parameters are off by C J' W (world - model), C their covariance.

    python -m benchmarks.dynamic_coverage.links [SEED ...]
"""

from __future__ import annotations

import benchmarks._one_thread  # noqa: F401  (before numpy)

# isort: split

import sys

import numpy as np

from benchmarks.dynamic_coverage.drawn import drawn_session
from benchmarks.dynamic_coverage.measured import measured
from model.dynamics.identification.parameters import LogParameters
from model.dynamics.identification.predicted_run import FINE, coarser
from model.dynamics.identification.residuals import RunResiduals

CHAINS = ((64, 0.5), (80, 0.5), (160, 0.5), (160, 0.25), (320, 0.25))  # links, step in ms


def shifts(seed: int) -> tuple[list[str], np.ndarray]:
    """Return names (p,) and errors (chains, p) over standard deviations."""
    session = drawn_session(seed)
    parameters = LogParameters(session.truth)
    J, said = [], []
    for plan in session.plans:
        rough = RunResiduals(plan, session.noise, coarser(FINE))
        J.append(rough.sensitivity(parameters, parameters.theta, symmetric=True))
        of = RunResiduals(plan, session.noise, FINE)
        said.append((of, of.predict(session.truth)))
    covariance = np.linalg.inv(sum(j.T @ j for j in J) + np.diag(parameters.precision))
    sigma = np.sqrt(np.diag(covariance))
    rows = []
    for links, step_ms in CHAINS:
        runs = measured(drawn_session(seed, links, step_ms), noisy=False)
        gradient = sum(
            j.T @ of.whitened([(at, run)])[:, 0]
            for j, (of, at), run in zip(J, said, runs, strict=True)
        )
        rows.append(covariance @ gradient / sigma)
    return [q.name for q in parameters.quantities], np.array(rows)


def main(arguments: list[str]) -> None:
    found = [shifts(int(seed)) for seed in arguments or ["2", "3", "4"]]
    print("largest of the sessions, in standard deviations; columns: links, step in ms")
    print(f"{'':26}" + "".join(f"{f'{n}, {h}':>12}" for n, h in CHAINS))
    worst = np.max(np.abs([rows for _, rows in found]), axis=0)
    for name, row in zip(found[0][0], worst.T, strict=True):
        print(f"{name:26}" + "".join(f"{value:12.2f}" for value in row))


if __name__ == "__main__":
    main(sys.argv[1:])
