"""Python looks for garbage seldom in a program of labrig: there must be little of it."""

from __future__ import annotations

import gc
from pathlib import Path

import pytest

from tests.end_to_end.small_rig import ONE_POSITION, make_rig, run_rig

pytestmark = pytest.mark.thorough
OF_A_READING = 20  # objects; an image or a block of signals that refers to itself has more


def test_a_run_leaves_no_more_garbage_the_longer_it_lasts(tmp_path: Path) -> None:
    def left_by(readings: int) -> int:
        protocol = ONE_POSITION.replace("voltage = 1", f"voltage = {readings}")
        folder = make_rig(tmp_path / str(readings), protocol)
        gc.collect()
        gc.disable()
        try:
            run_rig(folder)
            return gc.collect()
        finally:
            gc.enable()

    left_by(2)  # what is imported
    assert left_by(12) < left_by(1) + OF_A_READING * 2 * 11
