"""The boards that docs/howto/boards.md adds: checked, run and made safe, as the page has it."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
import time
import tomllib
from pathlib import Path
from types import SimpleNamespace

import pytest

from drivers.interfaces import RealClock
from labrig.session import open_session
from labrig.testing import simple_board_faults
from tests.end_to_end.small_rig import ONE_POSITION, labrig
from tests.processes import last_words

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "howto" / "boards.md").read_text(encoding="utf-8")
FAMILY, PROJECT, BOX, SIMULATED, POINT = re.findall(
    r"```(?:python|toml)\n(.*?)```", PAGE, re.DOTALL
)


def module(code: str) -> SimpleNamespace:
    names = {"__name__": "labrig_acme"}
    exec(compile(code, "docs/howto/boards.md", "exec", dont_inherit=True), names)
    return SimpleNamespace(**names)


@pytest.fixture
def box():
    """The box of the page, on a free port."""
    server = module(BOX).Server(0)
    thread = threading.Thread(target=server.serve_forever, args=(0.01,))
    thread.start()
    yield server
    server.shutdown()
    thread.join()
    server.server_close()


def address_of(box) -> str:
    return f"127.0.0.1:{box.server_address[1]}"


def test_the_family_keeps_every_contract(box, monkeypatch):
    acme = module(FAMILY)
    monkeypatch.setitem(sys.modules, "labrig_acme", acme)  # where its dataclass looks for names
    settings = acme.AcmeSettings(address=address_of(box))
    assert simple_board_faults(acme.BOARDS, settings, 0.25, RealClock()) == []
    assert max(abs(volts) for _, volts in box.edges) == 2.5
    assert box.edges[-1][1] == 0.0


def install(site: Path) -> None:
    """Write both modules of the page, and the entry points that it states."""
    info = site / "labrig_acme-0.1.dist-info"
    info.mkdir()
    (site / "labrig_acme.py").write_text(FAMILY, encoding="utf-8")
    (site / "labrig_acme_box.py").write_text(SIMULATED, encoding="utf-8")
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: labrig-acme\nVersion: 0.1\n")
    points = ""
    for project in (PROJECT, POINT):
        for group, parts in tomllib.loads(project)["project"]["entry-points"].items():
            points += f"[{group}]\n" + "".join(f"{one} = {parts[one]}\n" for one in parts)
    (info / "entry_points.txt").write_text(points)


@pytest.fixture
def rig(box, tmp_path, monkeypatch):
    """The files that `labrig init` writes, without a camera; `box` is where they say."""
    install(tmp_path)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), str(ROOT)]))
    monkeypatch.syspath_prepend(str(tmp_path))
    assert labrig("init", tmp_path / "rig", "--board", "acme") == 0
    file = tmp_path / "rig" / "rig.toml"
    text = file.read_text().replace("127.0.0.1:7117", address_of(box))
    camera, _, stage = text.partition("[camera]")[2].partition("[stage]")
    file.write_text(text.replace(f"[camera]{camera}", ""))
    assert stage
    (tmp_path / "rig" / "protocol.toml").write_text(ONE_POSITION + "free_shapes = false\n")
    return tmp_path / "rig"


def started(rig: Path) -> subprocess.Popen[str]:
    files = [str(rig / name) for name in ("rig.toml", "protocol.toml", "sheet.toml")]
    command = [sys.executable, "-m", "labrig", "run", *files, "-o", str(rig / "s.h5"), "--yes"]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True)


@pytest.mark.thorough
def test_a_session_is_run_on_it(rig):
    run = started(rig)
    _, said = last_words(run)
    assert run.returncode == 0, said
    with open_session(rig / "s.h5") as session:
        assert session.versions["boards.acme"] == "labrig-acme 0.1"
        assert session.devices[0].identity.serial == "4711"


@pytest.mark.parametrize(
    "kind", [signal.SIGKILL, pytest.param(signal.SIGSTOP, marks=pytest.mark.thorough)]
)
def test_the_guard_takes_the_box_from_a_program_that_died_or_hangs(rig, box, kind):
    run = started(rig)
    until_s = time.monotonic() + 60
    while abs(box.edges[-1][1]) < 1.0 and time.monotonic() < until_s:
        RealClock().sleep_until(RealClock().now() + 0.01)
    run.send_signal(kind)
    _, said = last_words(run)  # the guard holds its end of the pipe until it is done
    assert "the output is safe: 0 V written and read back" in said
    assert box.edges[-1][1] == 0.0


def test_a_session_is_run_on_the_simulated_box(tmp_path, monkeypatch):
    install(tmp_path)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), str(ROOT)]))
    monkeypatch.syspath_prepend(str(tmp_path))
    assert labrig("init", tmp_path / "rig", "--board", "acme", "--simulated") == 0
    (tmp_path / "rig" / "protocol.toml").write_text(ONE_POSITION + "free_shapes = false\n")
    run = started(tmp_path / "rig")
    _, said = last_words(run)
    assert run.returncode == 0, said
    with open_session(tmp_path / "rig" / "s.h5") as session:
        assert session.simulated
        assert session.devices[0].identity.serial == "0001"
        assert all(reading["valid"] for run in session.runs for reading in run.readings)
