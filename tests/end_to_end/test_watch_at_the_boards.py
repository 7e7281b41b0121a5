"""`labrig watch`: 0 V within a second when nothing is left at the operator's computer."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from labrig.session import open_session
from protocols.execution.events import OutputState
from tests.end_to_end.small_rig import labrig
from tests.end_to_end.watched_rig import WatchedRig, watched

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="needs ptys, signals and /proc"),
]
WITHIN_S, ROW_S = 1.0, 0.02


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WatchedRig]:
    with watched(tmp_path_factory.mktemp("watched")) as rig:
        yield rig


@pytest.mark.alone
@pytest.mark.parametrize("what", ["killed", pytest.param("stopped", marks=pytest.mark.thorough)])
def test_program_and_guard_gone_together_are_0_V_within_a_second(
    served: WatchedRig, what: str
) -> None:
    assert served.zeroed_after(what) < WITHIN_S + ROW_S
    served.hear("the output is safe: 0 V written and read back")


@pytest.mark.thorough
@pytest.mark.alone
def test_a_run_that_is_watched_ends_as_any_other(served: WatchedRig) -> None:
    process = served.rig.energised()
    process.terminate()
    assert process.wait(30) == 4, served.rig.said()
    served.hear("has finished")
    with open_session(served.rig.session) as session:
        assert session.output_state is OutputState.SAFE


@pytest.mark.alone
def test_a_cut_network_is_0_V_within_a_second_and_the_program_says_unknown(
    tmp_path: Path,
) -> None:
    with watched(tmp_path, board="labjack") as served:
        process = served.rig.energised()
        begin_s = float(served.rig.rows()[-1]["time_s"])
        served.cut()
        served.rig.until(lambda: not served.rig.is_energised(), 5.0)
        assert float(served.rig.rows()[-1]["time_s"]) - begin_s < WITHIN_S + ROW_S
        assert process.wait(90) == 6  # it cannot know
        served.hear("the output is safe: 0 V written and read back")


@pytest.mark.alone
def test_a_watch_that_dies_stops_the_run_at_0_V(tmp_path: Path) -> None:
    with watched(tmp_path) as served:
        process = served.rig.energised()
        os.kill(served.watch.pid, signal.SIGKILL)
        assert process.wait(30) == 5
        assert "the run must stop" in served.rig.said()
        assert served.rig.drive_V() == pytest.approx(0.0, abs=0.02)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("token", "the token is another one"),
        ("wiring", "drive_channel = 'PCI6034E/ai3', the watch's has 'PCI6034E/ai2'"),
        ("absent", "start `labrig watch` at the boards"),
    ],
)
def test_a_run_without_its_watch_is_refused_before_the_first_voltage(
    served: WatchedRig,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    change: str,
    said: str,
) -> None:
    folder = served.rig.folder / "rig"
    file = folder / "rig.toml"
    files = [folder / name for name in ("rig.toml", "protocol.toml", "sheet.toml")]
    text = file.read_text()
    other = tmp_path / "other.token"
    other.write_text("f" * 64)
    old, new = {
        "token": (str(served.token), str(other)),
        "wiring": ("PCI6034E/ai2", "PCI6034E/ai3"),
        "absent": (str(served.networks[1].port), "9"),
    }[change]
    file.write_text(text.replace(old, new))
    served.rig.forget()
    try:
        assert labrig("run", *files, "-o", tmp_path / "refused.h5", "--yes") == 3
    finally:
        file.write_text(text)
    assert said in capsys.readouterr().err
    assert not any(abs(float(row["drive_V"])) > 0.02 for row in served.rig.rows())


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--listen", "nowhere"), "must be address:port"),
        (("--token", "gone/watch.token"), "watch.token"),
    ],
)
def test_what_makes_no_sense_is_one_sentence(
    tmp_path: Path, arguments: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    rig = tmp_path / "rig.toml"
    rig.write_text('[ni]\naddress = "127.0.0.1:9"\n')
    assert labrig("watch", rig, *arguments) == 2
    assert said in capsys.readouterr().err


def test_a_simulated_rig_and_boards_that_are_not_there_are_said_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rig = tmp_path / "rig.toml"
    rig.write_text('[ni]\naddress = "simulated"\n')
    assert labrig("watch", rig) == 2
    assert "nothing to watch" in capsys.readouterr().err
    rig.write_text('[ni]\naddress = "127.0.0.1:9"\n')
    assert labrig("watch", rig, "--listen", "127.0.0.1:0") == 3
    assert "no connection to the NI gRPC Device Server" in capsys.readouterr().err
    assert (tmp_path / "watch.token").stat().st_mode & 0o077 == 0
