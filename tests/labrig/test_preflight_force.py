"""A meter that reads the force too seldom for a protocol is told before the session begins."""

from __future__ import annotations

import pytest

from labrig.experiment.preflight import meter_check
from protocols import Place, make_schedule
from protocols.kinds.pulse_train import PulseTrain


@pytest.mark.parametrize(
    ("interval_s", "half_window_s", "wanted", "warning"),
    [
        (0.05, 0.1, "one in each window of 0.2 s (protocol.toml)", False),
        (0.6, 0.1, "one in each window of 0.2 s (protocol.toml)", True),
        (0.052, 0.01, "one in each window of 0.05 s (protocol.toml)", False),  # as often as asked
    ],
)
def test_a_meter_reads_the_force_in_each_window(interval_s, half_window_s, wanted, warning):
    pulses = PulseTrain(half_window_s=half_window_s)
    check = meter_check(interval_s, make_schedule(pulses, [Place("long", (0.0,))]))
    assert (check.ok, check.warning, check.wanted) == (True, warning, wanted)
    assert check.found == f"one in {interval_s:.2f} s"
