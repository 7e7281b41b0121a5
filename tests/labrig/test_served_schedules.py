"""Which schedules a simulated rig can run on the real clock, where no hands are at it."""

from __future__ import annotations

import pytest

from labrig.config import parse_protocol
from labrig.experiment.rig.networked_rig import why_not_served

PROTOCOL = """
[pulse_train]
zero_readings = 2
readings_per_voltage = 2
[[places]]
configuration = "long"
positions_mm = [5, 10]
[extras]
random_order = false
reversed_approach = false
"""


@pytest.mark.parametrize(
    ("text", "runs"),
    [
        (PROTOCOL + "no_touch_zero = false\nfree_shapes = false\n", True),
        (PROTOCOL + "no_touch_zero = false\nfree_shapes = true\nrelease = true\n", True),
        (PROTOCOL + "no_touch_zero = false\nchirp = true\n", True),
        (PROTOCOL + "no_touch_zero = true\n", False),
        (PROTOCOL + "no_touch_zero = false\nremounts = 1\n", False),
        (PROTOCOL + "no_touch_zero = false\ndead_weights_mN = [10.0]\n", False),
        (PROTOCOL.replace("[extras]", '[[places]]\nconfiguration = "short"\n'
         "positions_mm = [5]\n[extras]") + "no_touch_zero = false\n", False),
    ],
)  # fmt: skip
def test_it_measures_what_needs_no_hands_once_the_sheet_is_free(text: str, runs: bool) -> None:
    schedule = parse_protocol(text, "protocol.toml").schedule("protocol.toml")
    assert (not why_not_served(schedule)) is runs
