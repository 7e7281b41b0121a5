"""Fits and diagnoses that do not look for data stated wrongly.

That search fits the data once for each datum that could be wrong, which takes most of the time of a
fit, and three quarters of that of a small diagnosis. tests/model/discrepancy/test_data_checks.py
and tests/labrig/test_data_warnings.py test it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest


@contextmanager
def fits_unchecked() -> Iterator[None]:
    """What the data show without a fit (wild readings, shapes that swing) is told all the same."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("model.discrepancy.data_checks.check._once", lambda _data, _checks: ())
        yield
