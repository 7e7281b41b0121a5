"""Before the first voltage: who is left to write 0 V, whether this computer keeps up, the disk."""

from __future__ import annotations

import shutil
from collections import namedtuple
from pathlib import Path

import pytest

from labrig.config import RigConfig, load_rig
from labrig.config.templates import write_templates
from labrig.experiment import preflight
from labrig.experiment.precautions.checks import beyond_the_guard, on_time
from tests.end_to_end.small_rig import ONE_POSITION, labrig, make_rig

WATCH = '[watch]\naddress = "192.0.2.7"\n'
INTERLOCK = '[interlock]\nline = "PCI6703/port0/line0"\n'


def config_of(folder: Path, more: str, board: str = "ni", changes=()) -> RigConfig:
    write_templates(folder, simulated=False, board=board)
    file = folder / "rig.toml"
    text = file.read_text() + more
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    file.write_text(text)
    config = load_rig(file)
    assert isinstance(config, RigConfig)
    return config


@pytest.mark.parametrize(
    ("more", "board", "changes", "found"),
    [
        ("", "ni", (), "nobody writes 0 V if this computer or the network fails"),
        (INTERLOCK, "ni", (), "the interlock on PCI6703/port0/line0"),
        (WATCH, "ni", (), "labrig watch at 192.0.2.7"),
        (WATCH + INTERLOCK, "ni", (), "labrig watch at 192.0.2.7 and the interlock on"),
        ("", "labjack", (), "nobody writes 0 V"),
        ('[interlock]\nline = "EIO0"\n', "labjack", (), "watchdog drops EIO0 after 1 s"),
        (
            "",
            "labjack",
            (('drive = "TDAC0" ', 'drive = "DAC0"\nzero_V = 2.5\nstage_gain = 4.0 '),),
            "watchdog sets DAC0 to 2.5 V after 1 s",
        ),
    ],
)
def test_who_ends_a_voltage_beyond_the_guard_is_said(
    tmp_path: Path, more: str, board: str, changes, found: str
) -> None:
    check = beyond_the_guard(config_of(tmp_path, more, board, changes))
    assert check.ok
    assert found in check.found
    assert check.warning is found.startswith("nobody")


def test_the_token_lies_beside_rig_toml_unless_it_says_otherwise(tmp_path: Path) -> None:
    watch = config_of(tmp_path, WATCH).watch
    assert watch is not None
    assert watch.token == tmp_path / "watch.token"
    assert watch.host_and_port == ("192.0.2.7", 31764)


@pytest.mark.parametrize("address", ["a:b:c", "host:", "host:1234567", ""])
def test_an_address_of_the_watch_that_is_none_is_refused(
    tmp_path: Path, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = make_rig(tmp_path)
    file = folder / "rig.toml"
    file.write_text(file.read_text() + f'[watch]\naddress = "{address}"\n')
    assert labrig("check", file) == 2
    assert "[watch] address" in (said := capsys.readouterr().err)
    assert "must be host or host:port" in said


class LateClock:
    """A computer that wakes a sleeper late now and then."""

    def __init__(self, late_s: float) -> None:
        self._now_s, self._late_s, self._sleeps = 0.0, late_s, 0

    def now(self) -> float:
        return self._now_s

    def sleep_until(self, when: float) -> None:
        self._sleeps += 1
        self._now_s = max(self._now_s, when) + (self._late_s if self._sleeps % 40 == 0 else 1e-4)


@pytest.mark.parametrize(("late_s", "warns"), [(0.0, False), (0.004, False), (0.03, True)])
def test_a_computer_that_stalls_is_told_before_readings_are_lost(
    late_s: float, warns: bool
) -> None:
    check = on_time(LateClock(late_s), 0.005)  # type: ignore[arg-type]
    assert check.ok
    assert check.warning is warns
    assert f"up to {1e3 * max(late_s, 1e-4):.1f} ms late" in check.found


@pytest.mark.slow
def test_a_run_looks_at_the_disk_of_its_output(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = make_rig(tmp_path / "rig", ONE_POSITION)
    asked = []
    Usage = namedtuple("Usage", "total used free")  # noqa: PYI024 - as shutil's

    def usage(path: Path):
        asked.append(Path(path))
        return Usage(10**9, 10**9, 1000)

    monkeypatch.setattr(preflight.shutil, "disk_usage", usage)
    assert shutil.disk_usage is usage
    (tmp_path / "disk").mkdir()
    files = [folder / name for name in ("rig.toml", "protocol.toml", "sheet.toml")]
    session = tmp_path / "disk" / "s.h5"
    assert labrig("run", *files, "-o", session) == 3
    assert "disk space: 0.0 GB free, wanted at least" in capsys.readouterr().err
    assert asked == [tmp_path / "disk"]
    assert not session.exists()
