"""In a notebook linear algebra has threads of its own; a job of labrig's runs with one."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import labrig


def threads() -> int:
    return max(pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas")


class PathThatCounts(os.PathLike[str]):
    """A path to no file, which notes how many threads there were when it was asked for."""

    def __init__(self) -> None:
        self.threads: list[int] = []

    def __fspath__(self) -> str:
        self.threads.append(threads())
        return "missing.h5"


NEEDS: dict[Callable[..., Any], dict[str, Any]] = {
    labrig.fit: {},
    labrig.fit_in_time: {},
    labrig.diagnose: {},
    labrig.next_measurement: {},
    labrig.next_in_time: {},
    labrig.compare: {},
    labrig.simulate: {"position_mm": 5, "voltage": 2},
    labrig.design: {"section_mm": (0, 30)},
}


@pytest.mark.parametrize("job", NEEDS, ids=lambda job: job.__name__)
def test_a_job_has_one_thread_and_the_caller_has_his_again(job: Callable[..., Any]):
    np.linalg.inv(np.eye(2))  # loads the library
    path = PathThatCounts()
    with threadpool_limits(limits=2, user_api="blas"):
        before = threads()
        with pytest.raises((labrig.LabrigError, labrig.ModelError)):
            job(path, **NEEDS[job])
        assert threads() == before
    assert set(path.threads) == {1}
