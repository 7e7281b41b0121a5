"""`python -m benchmarks._bare_loop`: sleeps until the times it is told, one JSON list on stdin.

Answers with how late it was at each, s, as a JSON list. Nothing but labrig's own clock is used, so
this is what the computer can do. `time.perf_counter` is one for all processes of a computer.
"""

from __future__ import annotations

import json
import sys

from drivers.interfaces import RealClock


def lateness_s(due_s: list[float]) -> list[float]:
    """How late each sleep ended."""
    clock = RealClock()
    late = []
    for when in due_s:
        clock.sleep_until(when)
        late.append(clock.now() - when)
    return late


if __name__ == "__main__":
    told = sys.stdin.readline()
    if told:  # else whoever started it has ended
        print(json.dumps(lateness_s(json.loads(told))))
