"""`labrig safe` needs nothing but the boards."""

from __future__ import annotations

from pathlib import Path

import pytest

from labrig.errors import BadInputError
from labrig.experiment.safety import make_rig_safe

BOARDS = '[ni]\naddress = "simulated"\n'


@pytest.mark.parametrize(
    "rest",
    [
        '[camera]\nkind = "gone"\nsource = 0\noptics = "optics.json"\n',
        '[stage]\nkind = "gone"\n',
        '[force_sensor]\nkind = "gone"\n',
        '[channels.Wrong]\ninput = "PCI6034E/ai3"\n',
        "",  # not even the load cell's calibration
    ],
)
def test_whatever_is_wrong_with_other_parts_the_output_is_made_safe(
    tmp_path: Path, rest: str
) -> None:
    rig = tmp_path / "rig.toml"
    rig.write_text(BOARDS + rest)
    assert make_rig_safe(rig).is_safe


def test_boards_that_are_not_known_are_not_taken_for_others(tmp_path: Path) -> None:
    rig = tmp_path / "rig.toml"
    rig.write_text('[gone]\naddress = "simulated"\n')
    with pytest.raises(BadInputError, match="gone is not a known key"):
        make_rig_safe(rig)
