"""A command in this process, which must end soon, small, and in words."""

from __future__ import annotations

import contextlib
import io
import time
import tracemalloc
from collections.abc import Iterator

from labrig.cli.main import run

MOST_BYTES = 300 << 20
MOST_S = 10.0  # of one command on a busy computer: an endless loop is what this is for
WORDS = {0, 2, 3}  # done, or found before anything happened


def told(*arguments: object, codes: set[int] = WORDS) -> tuple[int, str]:
    """Exit code and standard error of a command; asserts that nobody has seen a traceback."""
    out, err = io.StringIO(), io.StringIO()
    with small_and_soon(), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = int(run([str(argument) for argument in arguments]))
    said = err.getvalue()
    assert "should not have happened" not in said, said[:500]
    assert "Traceback" not in said + out.getvalue(), said[:500]
    assert code in codes, (code, said[:500])
    if code == 2:
        assert said.strip(), "a refusal without a word"
        assert len(said) < 20_000, f"{len(said)} characters are no sentence"
    return code, said


@contextlib.contextmanager
def small_and_soon(most_bytes: int = MOST_BYTES, most_s: float = MOST_S) -> Iterator[None]:
    """Assert that what is inside takes neither much memory nor long."""
    tracemalloc.start(1)
    began_s = time.monotonic()
    try:
        yield
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < most_bytes, f"{peak / 1e6:.0f} MB"
    assert time.monotonic() - began_s < most_s
