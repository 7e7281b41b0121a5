"""A file of the wrong kind given to each command: one sentence that says what it is."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from _pytest.mark.structures import ParameterSet

from tests.labrig.wrong_inputs.files import make_files, refused

# what a file of each kind is called
KINDS = {
    "empty": "an empty file",
    "image.png": "an image",
    "session.h5": "a session",
    "rig.toml": "a rig.toml",
    "sheet.toml": "a sheet.toml",
    "protocol.toml": "a protocol.toml",
    "model.toml": "a model file",
    "load_cell.toml": "a load_cell.toml",
    "about.toml": "an about.toml",
    "optics.json": "an optics.json",
    "forces.csv": "a forces.csv",
}
# commands with the place of one file, by the kind that is needed there
COMMANDS = {
    "a session": (
        "analyze {}",
        "compare {}",
        "diagnose {}",
        "export {} -o out",
        "fit {}",
        "mark {} --run 1 --reading 1 --why x",
        "next {} -o out.toml",
        "note {} hello",
        "pause {}",
        "recover {}",
        "replay {}",
        "report {} -o out",
        "run --resume {}",
        "show {}",
        "verify {}",
    ),
    "a model file": (
        "compare session.h5 --model {}",
        "control {} --output force --position-mm 0 --rate-hz 200 --method pi -o out.toml",
        "design {} --section 0:10",
        "response {} --input voltage --output force --position-mm 0 -o out",
        "simulate {} --position-mm 5 --voltage 2",
    ),
    "a protocol.toml": ("plan {}", "run rig.toml {} sheet.toml -o out.h5"),
    "a rig.toml": (
        "calibrate load-cell {} --weight-mN 0 --weight-mN 10 --weight-mN 0",
        "check {}",
        "run {} protocol.toml sheet.toml -o out.h5",
        "safe {}",
    ),
    "a sheet.toml": (
        "curves image.png --optics optics.json --sheet {}",
        "import --sheet {} --forces forces.csv -o out.h5",
        "run rig.toml protocol.toml {} -o out.h5",
    ),
    "an about.toml": ("run rig.toml protocol.toml sheet.toml -o out.h5 --about {}",),
    "a controller.toml": (
        "run rig.toml protocol.toml sheet.toml -o out.h5 --controller {} --reference forces.csv",
    ),
    "an optics.json": ("curves image.png --optics {} --sheet sheet.toml --configuration long",),
    "an image": ("calibrate camera {} --clamp-px 1,1 -o out.json",),
    "a forces.csv": ("import --sheet sheet.toml --forces {} -o out.h5",),
    "a curves.csv": ("import --sheet sheet.toml --curves {} -o out.h5",),
}
PLACES = [(wanted, asked) for wanted, commands in COMMANDS.items() for asked in commands]
EVERY = 4  # kinds, of which a command is given one in `make test`; the next command the next one


def mixed_up() -> Iterator[ParameterSet]:
    for place, (wanted, asked) in enumerate(PLACES):
        for at, (file, kind) in enumerate(KINDS.items()):
            if kind == wanted or (wanted == "an about.toml" and file == "empty"):
                continue
            marks = [pytest.mark.thorough] if (place + at) % EVERY else []
            yield pytest.param(asked, wanted, file, id=asked.format(file), marks=marks)


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_files(tmp_path_factory.mktemp("files"))


@pytest.mark.parametrize(("asked", "wanted", "file"), list(mixed_up()))
def test_a_mix_up_is_told_as_one(
    files: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    asked: str,
    wanted: str,
    file: str,
) -> None:
    monkeypatch.chdir(files)
    said = refused(asked.format(file), capsys)
    assert len(said.splitlines()) == 1
    assert f"{file}: this is {KINDS[file]}; " in said
    assert f"; {wanted} is needed" in said
    assert len(said.split()) <= 25


@pytest.mark.parametrize(("wanted", "asked"), PLACES)
@pytest.mark.parametrize(
    ("name", "told"), [("gone", "there is no such file"), ("folder", "folder")]
)
def test_a_file_that_is_not_there_is_told(
    files: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    wanted: str,
    asked: str,
    name: str,
    told: str,
) -> None:
    del wanted
    monkeypatch.chdir(files)
    said = refused(asked.format(name), capsys)
    assert len(said.splitlines()) == 1
    assert f"{name}: " in said
    assert told in said


@pytest.mark.slow
def test_a_large_session_in_place_of_a_text_is_told_as_a_session(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)  # where nothing else writes
    large = tmp_path / "large.h5"
    with large.open("wb") as file:
        file.write(b"\x89HDF\r\n\x1a\n")
        file.truncate(100_000_000)
    said = refused(f"design {large} --section 0:10", capsys)
    assert said.endswith(
        "large.h5: this is a session; a model file is needed (`labrig fit SESSION -o model.toml`"
        " writes one)."
    )


def test_a_wrong_model_is_refused_before_the_session_is_analysed(
    files: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def analysed(*_given: object) -> None:
        raise AssertionError("the session was analysed first")

    monkeypatch.setattr("labrig.api.compare.measurements_of", analysed)
    monkeypatch.chdir(files)
    assert "this is a rig.toml" in refused("compare session.h5 --model rig.toml", capsys)
