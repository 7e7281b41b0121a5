"""What is lost of 25 frames/s of 640 x 480 from the fake GigE Vision camera, and is it counted.

    python -m benchmarks.camera_losses --seconds 60

The fake camera of aravis-tools sends over the loopback. It writes down each frame that it sends and
each packet that it drops; labrig's counts are compared with that.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from tests.drivers.fake_gige import Received, fake_camera, received

PER_THOUSAND = (0, 10)  # packets dropped


def received_with(lost_per_thousand: int, seconds: float) -> tuple[Received, float]:
    """Return what came in so long, and the CPU time of this process in s."""
    with (
        tempfile.TemporaryDirectory() as folder,
        fake_camera(Path(folder), lost_per_thousand) as fake,
    ):
        began_s = time.process_time()
        return received(fake, seconds), time.process_time() - began_s


def uncounted(found: Received) -> int:
    """Return how many frames neither came whole nor are counted as lost; should be 0."""
    return len(found.sent) - len(found.whole) - sum(found.lost)


def main() -> None:
    """Print a line for each rate of loss."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    seconds = parser.parse_args().seconds
    for lost_per_thousand in PER_THOUSAND:
        found, cpu_s = received_with(lost_per_thousand, seconds)
        incomplete, missed = found.lost
        print(
            f"{lost_per_thousand / 10:g} % of packets dropped: {len(found.sent)} frames sent in "
            f"{seconds:g} s, {len(found.whole)} whole, {incomplete} incomplete, {missed} missed, "
            f"{uncounted(found)} not counted; a packet was dropped of {len(found.spoilt)}; "
            f"{100 * cpu_s / seconds:.1f} % of a core",
            flush=True,
        )


if __name__ == "__main__":
    main()
