"""Sheets that a world which shares no code with the model bends to a ring."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.bent_to_a_ring import bent_world, fitted, session_of


@pytest.mark.slow
@pytest.mark.parametrize("seed", [5006, 5001])  # of the second the EIBM falls most along the sheet
def test_a_sheet_that_is_bent_to_a_ring_is_fitted(seed):
    """A small edition of the benchmark, which states how many are."""
    world = bent_world(np.random.default_rng(seed))
    said, is_right = fitted(session_of(world, seed), world)
    assert is_right, said
