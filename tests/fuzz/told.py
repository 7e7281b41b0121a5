"""A command in this process, which must end soon, small, and in words."""

from __future__ import annotations

import contextlib
import io
import sys
import time
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
    before, began_s = _most_bytes(), time.monotonic()
    yield
    taken = _most_bytes() - before
    assert taken < most_bytes, f"{taken / 1e6:.0f} MB"
    assert time.monotonic() - began_s < most_s


def _most_bytes() -> int:
    """The most memory that this process ever had, where the system tells."""
    if sys.platform == "win32":
        return 0
    import resource

    unit = 1 if sys.platform == "darwin" else 1024
    return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
