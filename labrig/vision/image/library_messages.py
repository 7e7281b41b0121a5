"""Lines that image libraries write to standard error themselves, past Python."""

from __future__ import annotations

import os
import re
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager

# of libpng, and of FFmpeg where it opens a film: labrig says in a sentence what is wrong
_THEIRS = re.compile(rb"libpng (error|warning): |\[[\w,]+ @ 0x")
_STDERR = 2
_one_at_a_time = threading.Lock()  # standard error is one for all threads


@contextmanager
def without_lines_of_libraries() -> Iterator[None]:
    """Leave out what libpng and FFmpeg write to standard error; all else follows at the end."""
    with _one_at_a_time, tempfile.TemporaryFile() as held:
        try:
            real = os.dup(_STDERR)
        except OSError:  # a program without a standard error: nothing is seen there
            yield
            return
        os.dup2(held.fileno(), _STDERR)
        try:
            yield
        finally:
            os.dup2(real, _STDERR)
            os.close(real)
            held.seek(0)
            for line in held:
                if not _THEIRS.match(line):
                    os.write(_STDERR, line)
