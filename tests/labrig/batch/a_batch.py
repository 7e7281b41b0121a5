"""A batch of costless pieces, as a program of its own: `python -m tests.labrig.batch.a_batch`."""

from __future__ import annotations

import sys
from pathlib import Path

from labrig.batch.inputs import found_inputs
from labrig.batch.plan import BatchOrder, plan
from labrig.batch.run import run_batch
from labrig.batch.workers import local_workers
from tests.labrig.batch.costless import Costless


def planned(folder, task, **more):
    """The plan of a batch over the sessions of a folder; its output lies beside them."""
    found = found_inputs([str(folder)], task.takes, folder)
    wanted = BatchOrder(
        name="costless", task=task, inputs=found.inputs, output=folder / "out", **more
    )
    return plan(wanted)


def do_batch(folder, task, workers=2, tell=lambda *_: None, **more):
    """Plan and do it."""
    todo = planned(folder, task, **more)
    with local_workers(workers) as them:
        run_batch(todo, them.executor, them.places, tell)
    return todo


if __name__ == "__main__":
    do_batch(Path(sys.argv[1]), Costless(count=int(sys.argv[2]), wait_s=0.01))
