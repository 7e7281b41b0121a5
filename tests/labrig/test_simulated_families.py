"""A simulated family of boards of another distribution that cannot be used is named."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from labrig.cli.main import run

CODE = """
from dataclasses import dataclass

from drivers.boards.simple import SimpleBoard, SimpleSettings, simple_family
from sim_hardware.families import SimulatedFamily


@dataclass(frozen=True, kw_only=True)
class Settings(SimpleSettings):
    address: str = "here"


class Board(SimpleBoard):
    def __init__(self, *settings):
        pass

    def real(self, *asked):
        raise RuntimeError("the real board was reached")

    open = write = start = read = stop = real

    def close(self):
        pass


class Boards:
    def transport(self): ...

    listen = stop = fault = transport


BOARDS = simple_family(kind="mine", help="boards", settings=Settings, board=Board,
                       simulated=Board)
REAL = simple_family(kind="real", help="boards", settings=Settings, board=Board)
NONE = SimulatedFamily(kind="mine", served_as="mine", make=lambda *_: None)
NO_TRANSPORT = SimulatedFamily(kind="mine", served_as="mine", make=lambda *_: Boards())
"""


@pytest.fixture
def checked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    def check(boards: str, simulated: str) -> tuple[int, str]:
        site = tmp_path / "site"
        info = site / "mine-1.0.dist-info"
        info.mkdir(parents=True)
        (site / "mine.py").write_text(CODE)
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n")
        (info / "entry_points.txt").write_text(
            f"[labrig.boards]\nmine = mine:{boards}\n"
            f"[labrig.simulated_families]\nmine = mine:{simulated}\n"
        )
        monkeypatch.syspath_prepend(str(site))
        monkeypatch.delitem(sys.modules, "mine", raising=False)
        code = run(["init", str(tmp_path / "rig"), "--simulated", "--board", "mine"])
        if code == 0:
            code = run(["check", str(tmp_path / "rig" / "rig.toml")])
        return code, " ".join(capsys.readouterr().err.split())

    return check


def test_boards_whose_driver_cannot_be_simulated_get_no_simulated_rig(checked) -> None:
    code, said = checked("REAL", "NO_TRANSPORT")
    assert "these boards bring no simulated rig to start from" in said
    assert code == 2


def test_a_simulated_family_that_makes_nothing_is_named(checked) -> None:
    code, said = checked("BOARDS", "NONE")
    assert "[mine] cannot be simulated: the make of its simulated family returned NoneT" in said
    assert code == 2


def test_a_simulated_family_without_a_transport_does_not_reach_real_boards(checked) -> None:
    code, said = checked("BOARDS", "NO_TRANSPORT")
    assert "the transport of its simulated family is None" in said
    assert "real board" not in said
    assert code == 2
