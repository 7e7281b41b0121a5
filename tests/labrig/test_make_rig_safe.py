"""`labrig safe` needs nothing but the boards."""

from __future__ import annotations

from pathlib import Path

import pytest

from labrig.cli.main import run
from labrig.errors import BadInputError
from labrig.experiment.precautions.boards_watch import watched_rig
from labrig.experiment.safety import make_rig_safe
from tests.model.distributions import install

BOARDS = '[ni]\naddress = "simulated"\n'


@pytest.mark.parametrize(
    "rest",
    [
        '[camera]\nkind = "gone"\nsource = 0\noptics = "optics.json"\n',
        '[stage]\nkind = "gone"\n',
        '[force_sensor]\nkind = "gone"\n',
        '[channels.Wrong]\ninput = "PCI6034E/ai3"\n',
        '[hooks]\nwaitng = "x"\n',
        '[publish]\nblusky = "x"\n',
        '[simulated]\nwrld = "x"\n',
        "",  # not even the load cell's calibration
    ],
)
def test_whatever_is_wrong_with_other_parts_the_output_is_made_safe(
    tmp_path: Path, rest: str
) -> None:
    rig = tmp_path / "rig.toml"
    rig.write_text(BOARDS + rest)
    assert make_rig_safe(rig).is_safe
    with pytest.raises(BadInputError, match="nothing to watch"):  # of simulated boards
        watched_rig(rig)


def test_boards_that_are_not_known_are_not_taken_for_others(tmp_path: Path) -> None:
    rig = tmp_path / "rig.toml"
    rig.write_text('[gone]\naddress = "simulated"\n')
    with pytest.raises(BadInputError, match="gone is not a known key"):
        make_rig_safe(rig)


@pytest.mark.slow
@pytest.mark.parametrize("command", ["safe", "check"])
def test_boards_of_others_that_are_installed_but_not_used_are_not_even_loaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    """Whatever their maker's library does when it is loaded, hang or end the process."""
    module = "raise KeyboardInterrupt\n"
    points = "[labrig.boards]\nacme = acme_boards:BOARDS\n"
    install(tmp_path, "acme_boards", points, module)
    assert run(["init", str(tmp_path / "rig"), "--simulated"]) == 0
    monkeypatch.syspath_prepend(tmp_path)
    assert run([command, str(tmp_path / "rig" / "rig.toml")]) == 0
