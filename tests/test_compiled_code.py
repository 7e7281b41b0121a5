"""The end of a test run names what numba compiled in it."""

from __future__ import annotations

import os

from tests.compiled_code import compiled_since, summary


def test_modules_that_were_compiled_since_are_named_once(tmp_path):
    cache = tmp_path / "model" / "inner" / "__pycache__"
    cache.mkdir(parents=True)
    for name, at_s in (("march.step-1", 20), ("march.move-7", 30), ("old.step-1", 5)):
        path = cache / f"{name}.py311.nbi"
        path.touch()
        os.utime(path, (at_s, at_s))
    found = compiled_since(10.0, tmp_path)
    assert found == ["model/inner/march.py"]
    (line,) = summary(found)
    assert "model/inner/march.py" in line
    assert "Makefile" in line
    assert summary([]) == []
