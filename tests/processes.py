"""Nothing waits without a limit for the end of a process that a test has started.

While a test is cleaned up after, its time-out ends nothing any more.
"""

from __future__ import annotations

import subprocess
from typing import Any

END_S = 60.0  # beyond that: what still loads is slow while other tests compute
KILLED_S = 10.0
Process = subprocess.Popen[Any]


def ended(process: Process, limit_s: float = END_S) -> int:
    """Wait for its end; its exit code. What does not end is killed, and the test fails."""
    try:
        return process.wait(limit_s)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait(KILLED_S)
        raise


def last_words(process: Process, limit_s: float = END_S) -> tuple[Any, Any]:
    """Close its input and wait for its end; what it still said on its output and its errors."""
    try:
        return process.communicate(timeout=limit_s)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate(timeout=KILLED_S)
        raise
