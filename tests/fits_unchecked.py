"""Fits and diagnoses that do not look for data stated wrongly.

That search fits data that the base model does not fit once for each datum that could be wrong. It
takes most of the time of a fit, and more than half of some diagnoses. Tests of it:
tests/model/discrepancy/test_data_checks.py and tests/labrig/test_data_warnings.py.
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
