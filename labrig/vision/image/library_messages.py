"""Lines that image libraries write to standard error themselves, past Python."""

from __future__ import annotations

import os
import re
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager

# of libpng, libjpeg, and of FFmpeg where it opens a film: labrig says in a sentence what is wrong
_THEIRS = re.compile(
    rb"libpng (error|warning): |\[[\w,]+ @ 0x| \([\w ]+\): fmt:\w+ csp:"
    rb"|Corrupt JPEG data: |Inconsistent progression|Invalid SOS parameters|Unknown Adobe color"
)
_STDERR = 2
_one_at_a_time = threading.Lock()  # standard error is one for all threads


@contextmanager
def without_lines_of_libraries() -> Iterator[list[str]]:
    """Hold back what libpng, libjpeg and FFmpeg write to standard error; all else follows.

    Yields a list that has their lines at the end.
    """
    theirs: list[str] = []
    with _one_at_a_time, tempfile.TemporaryFile() as held:
        try:
            real = os.dup(_STDERR)
        except OSError:  # a program without a standard error: nothing is seen there
            yield theirs
            return
        os.dup2(held.fileno(), _STDERR)
        try:
            yield theirs
        finally:
            os.dup2(real, _STDERR)
            os.close(real)
            held.seek(0)
            for line in held:
                if _THEIRS.match(line):
                    theirs.append(line.decode(errors="replace").strip())
                else:
                    os.write(_STDERR, line)
