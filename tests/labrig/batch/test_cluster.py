"""`labrig batch --scheduler`: Dask's own processes do the work, and may be killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from labrig.batch.plan import ROWS
from labrig.batch.rows import PieceOutcome, rows_in
from labrig.batch.run import run_batch
from labrig.batch.workers import cluster_workers
from labrig.errors import BadInputError, NotReadyError
from tests.end_to_end.real_rig import children
from tests.end_to_end.test_children_end import until
from tests.labrig.batch.a_batch import planned
from tests.labrig.batch.costless import Costless
from tests.processes import ended

pytestmark = pytest.mark.slow  # a cluster is started
ROOT = Path(__file__).parents[3]
# A cluster has its own ways with threads and time, which are not what is tested.
_CLUSTER = """
import sys
from distributed import LocalCluster

if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        print(cluster.scheduler_address, flush=True)
        sys.stdin.read()
"""


@contextmanager
def cluster(folder):
    """Yield the address of a scheduler with two workers; they end with their input."""
    script = folder / "cluster.py"
    script.write_text(_CLUSTER)
    process = subprocess.Popen(
        [sys.executable, script], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL, text=True, env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    try:
        yield process.stdout.readline().strip()
    finally:
        process.stdin.close()
        process.stdout.close()
        with suppress(subprocess.TimeoutExpired):  # killed: it may hang with a worker that was
            ended(process, 30)


@pytest.mark.thorough
@pytest.mark.filterwarnings("ignore")
def test_a_cluster_does_a_batch_and_a_killed_worker_loses_nothing(tmp_path):
    pytest.importorskip("distributed")
    (tmp_path / "a.h5").write_bytes(b"a")
    task = Costless(count=40, wait_s=0.02)
    plan = planned(tmp_path, task)
    killed = []

    def kill_one(progress, row):
        if progress.ended > 5 and not killed:
            pid = next(iter(client_pids()))
            os.kill(pid, signal.SIGKILL)
            killed.append(pid)

    with cluster(tmp_path) as address, cluster_workers(address) as workers:
        client = workers.executor._client

        def client_pids():
            return client.run(os.getpid).values()

        run_batch(plan, workers.executor, workers.places, kill_one)
    rows = list(rows_in(plan.folder / ROWS))
    assert killed
    assert sorted(row.name for row in rows) == sorted(plan.names)
    assert all(row.outcome is PieceOutcome.DONE for row in rows)


_BATCH = """
import sys
from pathlib import Path
from labrig.batch.run import run_batch
from labrig.batch.workers import cluster_workers
from tests.labrig.batch.a_batch import planned
from tests.labrig.batch.costless import Costless

plan = planned(Path(sys.argv[1]), Costless(count=5000, wait_s=0.02))
with cluster_workers(sys.argv[2]) as workers:
    run_batch(plan, workers.executor, workers.places)
"""


@pytest.mark.thorough
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("first", ["batch", "cluster"])
def test_a_killed_batch_leaves_a_cluster_idle_and_a_killed_cluster_ends_the_batch(tmp_path, first):
    distributed = pytest.importorskip("distributed")
    (tmp_path / "a.h5").write_bytes(b"a")
    rows = tmp_path / "out" / "costless" / ROWS
    with cluster(tmp_path) as address, (tmp_path / "said.txt").open("w") as told:
        batch = subprocess.Popen(
            [sys.executable, "-c", _BATCH, str(tmp_path), address], cwd=ROOT, stderr=told
        )
        try:
            until(lambda: (rows.exists() and rows.stat().st_size > 0) or batch.poll() is not None)
            assert batch.poll() is None, (tmp_path / "said.txt").read_text()
            assert children(batch.pid) == []
            if first == "batch":
                batch.kill()
                with distributed.Client(address, set_as_default=False) as client:
                    until(lambda: not any(client.processing().values()))
            else:
                for pid in cluster_pids(address, distributed):
                    os.kill(pid, signal.SIGKILL)
                batch.wait(90)
        finally:
            batch.kill()
            ended(batch)


def cluster_pids(address, distributed):
    with distributed.Client(address, set_as_default=False) as client:
        workers = list(client.run(os.getpid).values())
        return [*workers, client.run_on_scheduler(os.getpid)]


def test_a_scheduler_that_is_not_there_is_one_sentence(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("labrig.batch.workers._ANSWER_S", 1.0)
    with (
        pytest.raises(NotReadyError, match="no scheduler answers"),
        cluster_workers("tcp://127.0.0.1:9"),
    ):
        pass


def test_without_dask_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(BadInputError, match=r"pip install labrig\[cluster\]"), cluster_workers("x"):
        pass
