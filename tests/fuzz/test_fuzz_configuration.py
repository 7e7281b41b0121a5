"""Configuration files that are broken in every way: a sentence, code 2, and nothing else."""

from __future__ import annotations

import os
import random
import sys
from pathlib import Path

import pytest

from labrig.config.templates import write_templates
from labrig.errors import BadInputError
from labrig.experiment.plan import load_plan
from sim_hardware.world import WorldError, load_world
from tests.cases import few
from tests.fuzz.mangle import DEEP, text_of
from tests.fuzz.told import small_and_soon, told

ROOT = Path(__file__).resolve().parents[2]
FILES = ("rig.toml", "protocol.toml", "sheet.toml", "load_cell.toml", "optics.json")
ROOTS = FILES[:3]  # those that a person names
CASES = 60  # of each file


@pytest.fixture
def rig(tmp_path: Path) -> Path:
    """A simulated rig's files."""
    folder = tmp_path / "rig"
    write_templates(folder, simulated=True)
    return folder


def is_refused(rig: Path) -> bool:
    """Whether the files make no plan, which is all that a run does with them."""
    said = ""
    with small_and_soon():
        try:
            load_plan(*(rig / name for name in ROOTS)).resolved()
        except BadInputError as fault:
            said = str(fault)
    assert len(said) < 20_000
    return bool(said)


def refused_by_run(rig: Path) -> str:
    """What `labrig run` says when it refuses."""
    return told("run", *(rig / name for name in ROOTS), "-o", rig / "s.h5", codes={2})[1]


def test_unharmed_files_are_read(rig: Path) -> None:
    assert not is_refused(rig)


@pytest.mark.slow
@pytest.mark.parametrize("name", few(FILES))
def test_a_damaged_file_is_refused_in_words_or_read(rig: Path, name: str) -> None:
    sound = (rig / name).read_text(encoding="utf-8")
    dice = random.Random(name)
    refused = 0
    for _ in range(CASES):
        (rig / name).write_text(text_of(sound, dice), encoding="utf-8", errors="surrogatepass")
        refused += is_refused(rig)
    assert refused > CASES / 4  # else there was no damage


@pytest.mark.slow
@pytest.mark.parametrize("name", few(FILES))
def test_bytes_that_are_no_text_are_refused(rig: Path, name: str) -> None:
    for raw in (b"\xff\xfe\0\0", b"\x80" * 1000, b"\0" * 1000, b""):
        (rig / name).write_bytes(raw)
        assert refused_by_run(rig)


@pytest.mark.slow
@pytest.mark.parametrize("name", few(FILES))
def test_brackets_without_end_are_refused(rig: Path, name: str) -> None:
    for text in ("[" * DEEP, "a = " + "[" * DEEP, '{"a":' * DEEP, "a = " + "{a = " * DEEP):
        (rig / name).write_text(text)
        assert refused_by_run(rig)


@pytest.mark.thorough
@pytest.mark.slow
def test_a_hundred_thousand_faults_are_told_in_a_few_sentences(rig: Path) -> None:
    text = (rig / "rig.toml").read_text()
    (rig / "rig.toml").write_text("".join(f"key{i} = 1\n" for i in range(100_000)) + text)
    assert "99980 more keys are wrong" in refused_by_run(rig)


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
@pytest.mark.skipif(sys.platform == "win32", reason="POSIX devices and pipes")
def test_what_is_no_file_is_neither_read_for_ever_nor_waited_for(rig: Path, name: str) -> None:
    for make in (lambda path: path.symlink_to("/dev/zero"), os.mkfifo, Path.mkdir):
        (rig / name).unlink(missing_ok=True)
        make(rig / name)
        assert refused_by_run(rig)


@pytest.mark.parametrize("name", FILES)
def test_a_file_of_absurd_size_is_refused_before_it_is_read(rig: Path, name: str) -> None:
    with (rig / name).open("r+b") as file:
        file.truncate(20 << 30)  # a hole: takes no room on the disk
    assert refused_by_run(rig)


HUGE = {
    "long pulses": "[pulse_train]\nzero_readings = 1000\npulse_s = 3600.0\nsample_at_s = 3000.0\n",
    "tiny steps": "[step_response]\nhold_s = 3600.0\nsample_every_s = 1e-300\n",
    "many cycles": "[hold]\ncycles = 1000\nhold_s = 3600.0\nsample_every_s = 0.4\n",
    "many readings": "[pulse_train]\nvoltages_V = [1.0, -1.0]\nreadings_per_voltage = 1000\n",
    "many voltages": f"[staircase]\nvoltages_V = [{'2.0, -2.0, ' * 600}]\n",
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", few(HUGE))
def test_a_protocol_without_measure_is_refused(rig: Path, kind: str) -> None:
    positions = ", ".join(map(str, range(900)))
    places = f'[[places]]\nconfiguration = "long"\npositions_mm = [{positions}]\n'
    (rig / "protocol.toml").write_text(HUGE[kind] + places)
    assert refused_by_run(rig)
    told("plan", rig / "protocol.toml", "--json")


def world_refused(path: Path) -> bool:
    """Whether a world's file was refused in words."""
    said = ""
    with small_and_soon():
        try:
            load_world(path)
        except WorldError as fault:
            said = str(fault)
    assert len(said) < 20_000
    return bool(said)


@pytest.mark.slow
def test_a_damaged_world_is_refused_in_words_or_read(tmp_path: Path) -> None:
    sound = (ROOT / "sim_hardware" / "world" / "world.toml").read_text(encoding="utf-8")
    path = tmp_path / "world.toml"
    path.write_text(sound, encoding="utf-8")
    assert not world_refused(path)
    dice = random.Random(6)
    refused = 0
    for _ in range(CASES):
        path.write_text(text_of(sound, dice), encoding="utf-8", errors="surrogatepass")
        refused += world_refused(path)
    assert refused > CASES / 4
    for text in ("[" * DEEP, "a = " + "[" * DEEP, "seed = " + "9" * 5000):
        path.write_text(text)
        assert world_refused(path)
