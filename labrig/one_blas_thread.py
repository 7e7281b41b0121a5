"""One thread for linear algebra while a job of labrig's runs in somebody's Python.

All matrices here are small: threads that share them only wait for one another, many times as long
where other programs want the cores. The command line sets this before numpy is loaded; a notebook
has loaded it already.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

Given = ParamSpec("Given")
Made = TypeVar("Made")


def one_blas_thread(job: Callable[Given, Made]) -> Callable[Given, Made]:
    """Return the function with one BLAS thread while it runs; the caller's setting comes back."""

    @wraps(job)
    def limited(*args: Given.args, **kwargs: Given.kwargs) -> Made:
        with threadpool_limits(limits=1, user_api="blas"):
            return job(*args, **kwargs)

    return limited
