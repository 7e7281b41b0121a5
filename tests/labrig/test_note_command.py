"""Notes and photographs at the command line, and wherever a session is shown."""

from __future__ import annotations

import csv
import json
import shutil

import cv2
import numpy as np
import pytest

from labrig.cli.main import run
from labrig.library import Library, SessionQuery
from labrig.report.page.write import write_report
from labrig.session import SessionWriter, open_session, verify
from tests.cases import few
from tests.labrig.report_data import TEXTS, measure, session
from tests.labrig.session.session_recording import session_events, settings, small_schedule
from tests.labrig.test_about import FULL


def photograph(path, size=(40, 60), kind=None):
    """A photograph's file: a bright disk."""
    image = np.zeros((*size, 3), dtype=np.uint8)
    cv2.circle(image, (size[1] // 2, size[0] // 2), size[0] // 4, (40, 200, 250), -1)
    good, packed = cv2.imencode(kind or path.suffix, image)
    assert good
    path.write_bytes(packed.tobytes())
    return path


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("noted")
    return session(folder / "s.h5", measure("long"), texts={**TEXTS, "about.toml": FULL})


@pytest.fixture
def path(recorded, tmp_path):
    return shutil.copy(recorded, tmp_path / "s.h5")


def note(path, *more):
    return run(["note", str(path), *map(str, more)])


def refused(capsys, path, *more):
    assert note(path, *more) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    return line


@pytest.mark.thorough
@pytest.mark.slow
def test_a_note_is_by_the_operator_unless_somebody_else_is_named(path, capsys):
    assert note(path, "a bubble at the clamp") == 0
    assert note(path, "gone again", "--who", "Bo") == 0
    assert capsys.readouterr().out.splitlines() == [f"added to {path}"] * 2
    with open_session(path) as opened:
        found = [(one.who, one.text) for one in opened.notes]
    assert found == [("Ada Example", "a bubble at the clamp"), ("Bo", "gone again")]
    assert all(check.ok for check in verify(path))


@pytest.mark.slow
def test_a_note_during_a_run_waits_beside_the_file(tmp_path, capsys):
    path = tmp_path / "s.h5"
    schedule = small_schedule(positions_m=(0.0,))
    with SessionWriter(path, **settings(schedule)) as writer:
        assert note(path, "it runs") == 0
        assert "kept beside" in capsys.readouterr().out
        assert run(["show", str(path), "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["notes"][0]["text"] == "it runs"
        for event in session_events(schedule):
            writer.handle(event)
    with open_session(path) as opened:
        assert [one.text for one in opened.notes] == ["it runs"]


@pytest.mark.slow
@pytest.mark.parametrize("suffix", few([".jpg", ".png"]))
def test_a_photograph_is_kept_byte_by_byte_with_its_caption(path, tmp_path, suffix):
    file = photograph(tmp_path / f"clamp{suffix}")
    assert note(path, "the clamp", "--photograph", file) == 0
    with open_session(path) as opened:
        (found,) = opened.notes
        assert (found.text, found.file_name) == ("the clamp", file.name)
        assert opened.photograph(found.identifier) == file.read_bytes()


@pytest.mark.thorough
@pytest.mark.slow
def test_a_photograph_is_known_by_its_content_not_by_its_name(path, tmp_path, capsys):
    good = photograph(tmp_path / "really.png", kind=".jpg")
    assert note(path, "--photograph", good) == 0
    with open_session(path) as opened:
        assert opened.notes[0].media_type == "image/jpeg"
    (tmp_path / "no.jpg").write_bytes(b"<svg onload='alert(1)'/>")
    assert "neither a JPEG nor a PNG" in refused(capsys, path, "--photograph", tmp_path / "no.jpg")


@pytest.mark.slow
def test_photographs_that_cannot_be_are_refused(path, tmp_path, capsys):
    torn = photograph(tmp_path / "torn.png")
    torn.write_bytes(torn.read_bytes()[:40])
    assert "is damaged" in refused(capsys, path, "--photograph", torn)
    bomb = bytearray(photograph(tmp_path / "bomb.png").read_bytes())
    bomb[16:24] = (60_000).to_bytes(4, "big") * 2
    (tmp_path / "bomb.png").write_bytes(bomb)
    assert "60000 x 60000 pixels" in refused(capsys, path, "--photograph", tmp_path / "bomb.png")
    with (tmp_path / "huge.jpg").open("wb") as file:
        file.truncate(17 << 20)
    assert "at most 16.8 MB" in refused(capsys, path, "--photograph", tmp_path / "huge.jpg")
    assert "no such file" in refused(capsys, path, "--photograph", tmp_path / "none.jpg")
    assert "needs a text" in refused(capsys, path)
    assert "no such file" in refused(capsys, tmp_path / "none.h5", "text")
    with open_session(path) as opened:
        assert opened.notes == []


@pytest.mark.slow
def test_show_names_people_sample_and_notes(path, capsys):
    note(path, "a bubble")
    capsys.readouterr()
    assert run(["show", str(path)]) == 0
    printed = capsys.readouterr().out
    for text in ("Ada Example", "CC-BY-4.0", "S-17", "Li+ exchanged", "a bubble"):
        assert text in printed
    assert run(["show", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["about"]["sample"]["identity"] == "S-17"
    assert found["notes"][0]["text"] == "a bubble"


@pytest.mark.slow
@pytest.mark.parametrize(
    "words", few(["aged sheets", "Sheets 2026", "s-17", "ada", "nafion", "bubble clamp"])
)
def test_the_library_finds_a_session_by_people_sample_and_notes(path, words):
    note(path, "a bubble at the clamp")
    library = Library(path.parent)
    library.refresh()
    (found,) = library.find(SessionQuery(text=words)).entries
    assert (found.sample, found.operators, found.notes) == ("S-17", ("Ada Example",), 1)
    assert not library.find(SessionQuery(text="somebody else")).total


@pytest.mark.slow
def test_list_shows_the_sample(path, capsys):
    assert run(["list", str(path.parent), "--text", "S-17", "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["sessions"]
    assert (found["title"], found["project"]) == ("Blocked force of aged sheets", "Sheets 2026")


@pytest.mark.slow
def test_export_writes_people_sample_and_notes_and_import_reads_them(path, tmp_path, capsys):
    file = photograph(tmp_path / "clamp.jpg")
    note(path, "a bubble, at the clamp")
    note(path, "--photograph", file)
    out = tmp_path / "tables"
    assert run(["export", str(path), "-o", str(out)]) == 0
    assert (out / "about.toml").read_text() == FULL
    with (out / "notes.csv").open(newline="") as table:
        rows = list(csv.DictReader(table))
    assert [row["text"] for row in rows] == ["a bubble, at the clamp", ""]
    assert (out / rows[1]["photograph"]).read_bytes() == file.read_bytes()
    (out / "sheet.toml").write_text(TEXTS["sheet.toml"])
    made = tmp_path / "imported.h5"
    files = ["--sheet", out / "sheet.toml", "--forces", out / "forces.csv", "-o", made]
    assert run(["import", *map(str, files)]) == 0
    with open_session(made) as opened:
        assert opened.about.sample.identity == "S-17"
    assert all(check.ok for check in verify(made))


@pytest.mark.slow
def test_export_that_would_overwrite_a_file_writes_nothing(path, tmp_path, capsys):
    out = tmp_path / "tables"
    out.mkdir()
    (out / "about.toml").write_text("mine")
    assert run(["export", str(path), "-o", str(out)]) == 2
    assert [one.name for one in out.iterdir()] == ["about.toml"]


@pytest.mark.thorough
def test_the_report_names_people_and_sample_and_shows_notes_and_photographs(path, tmp_path):
    note(path, "a <b>bubble</b> & $more")
    note(path, "the clamp", "--photograph", photograph(tmp_path / "clamp.jpg", size=(300, 400)))
    page = write_report(path).read_text()
    for text in ("Sample and people", "Ada Example", "orcid.org/0000-0002-1825-0097", "S-17"):
        assert text in page
    assert "a &lt;b&gt;bubble&lt;/b&gt; &amp; $more" in page
    assert "the clamp (photograph clamp.jpg)" in page
    assert (path.parent / "s-report" / "figures" / "photographs.png").exists()
