"""Compiled code of the extractor never outlives the source of a kernel it calls."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

VISION = Path(__file__).parents[3] / "labrig" / "vision"
COPIED = (
    "jit", "thresholds", "search/beam_selection", "search/path_search", "search/straight_ridges",
)  # fmt: skip
RUN = """
import numpy as np
from labrig.vision.search.straight_ridges import _direction
maps = np.zeros((1, 5, 120, 120), np.float32)
maps[0, 2, 60, :] = -8.0  # a bright ridge along the row 60
print(_direction(maps, 1.0, 20.0, 60.0, 0.0, np.array([0.0]), 0.0, 60.0)[1])
"""


@pytest.mark.thorough  # tests/test_jit_cache.py has the same for made-up kernels
def test_a_change_of_the_ridge_score_reaches_the_kernel_that_calls_it(tmp_path):
    for name in COPIED:
        copy = tmp_path / "labrig" / "vision" / f"{name}.py"
        for folder in (copy.parent, *copy.parents):
            folder.mkdir(parents=True, exist_ok=True)
            if folder == tmp_path:
                break
            (folder / "__init__.py").touch()
        if (VISION / f"{name}.py").exists():
            copy.write_bytes((VISION / f"{name}.py").read_bytes())
    before = _score(tmp_path)
    path = tmp_path / "labrig" / "vision" / "search" / "path_search.py"
    text = path.read_text()
    assert text.count("return best / (best + half)") == 1
    path.write_text(text.replace("return best /", "return 100.0 * best /"))
    assert _score(tmp_path) == pytest.approx(100 * before)
    assert before > 0.5


def _score(root: Path) -> float:
    environment = {**os.environ, "PYTHONPATH": str(root)}
    environment.pop("NUMBA_CACHE_DIR", None)
    command = [sys.executable, "-c", RUN]
    ran = subprocess.run(
        command, env=environment, cwd=root, capture_output=True, text=True, check=True
    )
    return float(ran.stdout)
