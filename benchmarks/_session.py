"""`python -m benchmarks._session LABRIG-ARGUMENTS`: one labrig command; its cost as JSON, last."""

from __future__ import annotations

import json
import sys
import time

from labrig.cli.main import run


def peak_bytes() -> int | None:
    """The largest memory this process has had in RAM; None where the system does not tell."""
    try:
        import resource
    except ImportError:  # Windows
        return None
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


if __name__ == "__main__":
    code = run(sys.argv[1:])
    print(json.dumps({"code": code, "cpu_s": time.process_time(), "peak_bytes": peak_bytes()}))
