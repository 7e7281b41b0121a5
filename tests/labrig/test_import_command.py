"""labrig import, and the commands that read tables: what they show, ask and refuse."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from labrig.cli.main import run
from labrig.session import load_measurements, open_session
from labrig.session.tables.examples import write_examples

OLD = "--sheet sheet.toml --forces labview.txt --value configuration=long"
NAMES = (
    "--columns position_mm=p --columns voltage_V=U --columns force_mN=F --columns sd_mN=std "
    "--columns mean_of=n"
)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    write_examples(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


class Terminal:
    """Somebody who is asked."""

    def __init__(self, answer: str) -> None:
        self.answer = answer

    def isatty(self) -> bool:
        return True

    def readline(self, *_: object) -> str:
        return f"{self.answer}\n"


def answer(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setattr(sys, "stdin", Terminal(text))
    monkeypatch.setattr("typer.confirm", lambda *_, **__: text == "y")


def test_without_an_output_it_only_looks(capsys, folder):
    before = sorted(folder.iterdir())
    assert run(f"import {OLD}".split()) == 0
    said = capsys.readouterr().out
    assert "12 rows, UTF-16, tabs between columns, decimal comma, names in line 10" in said
    assert "a guess: --columns force_mN=F" in said
    force = next(line for line in said.splitlines() if line.startswith("F (N)"))
    assert force.split()[-5:] == ["-1.96742", "2.87011", "6", "0", "6"]  # mN, and the signs
    assert sorted(folder.iterdir()) == before


def test_where_it_only_looks_a_wrong_about_toml_is_told(capsys):
    looked = run(["import", "--sheet", "sheet.toml", "--forces", "old.txt", "--about", "no.toml"])
    assert looked == 2
    assert capsys.readouterr().err == "labrig: no.toml: there is no such file.\n"


def test_a_table_as_labrig_writes_it_needs_no_answer(capsys):
    asked = "import --sheet sheet.toml --forces forces.csv --curves curves.csv -o old.h5"
    assert run(asked.split()) == 0
    assert "forces.csv: 48 rows, UTF-8, commas between columns" in capsys.readouterr().out
    assert len(load_measurements(Path("old.h5")).conditions) == 12


def test_another_table_is_not_taken_without_an_answer(capsys):
    assert run(f"import {OLD} {NAMES} -o old.h5".split()) == 2
    told = capsys.readouterr()
    assert "decimal comma" in told.out
    assert "give --yes if it is right" in told.err
    assert not Path("old.h5").exists()


def test_yes_takes_what_is_stated_and_the_session_says_how_it_was_read(capsys):
    assert run(f"import {OLD} {NAMES} --yes -o old.h5".split()) == 0
    found = load_measurements(Path("old.h5"))
    assert {(r.mean_of, r.sd_N is None) for c in found.conditions for r in c.readings} == {
        (10, False)
    }
    with open_session(Path("old.h5")) as session:
        assert "F (N) is force_mN" in session.resolved["imported_as"]["labview.txt"]


def test_yes_takes_no_guess(capsys):
    assert run(f"import {OLD} --yes -o old.h5".split()) == 2
    assert "if this is meant, give --columns position_mm=p" in capsys.readouterr().err
    assert not Path("old.h5").exists()


@pytest.mark.parametrize(("text", "code"), [("y", 0), ("n", 2)])
def test_somebody_at_a_terminal_is_asked_and_may_agree_to_guesses(monkeypatch, capsys, text, code):
    answer(monkeypatch, text)
    assert run(f"import {OLD} -o old.h5".split()) == code
    assert Path("old.h5").exists() == (code == 0)


@pytest.mark.slow
def test_an_imported_session_shows_what_was_imported(capsys):
    tables = "--sheet sheet.toml --forces forces.csv --curves curves.csv"
    assert run(f"import {tables} -o old.h5".split()) == 0
    capsys.readouterr()
    assert run(["show", "old.h5"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "imported conditions 12 of long readings 48 neutral curves 12" in said
    assert "output none: imported" in said
    assert "Runs" not in said  # a table without rows
    assert "runs complete" not in said


@pytest.mark.parametrize("name", ["old.csv", "old", "old.toml"])
def test_a_session_is_not_made_under_the_name_of_another_file(capsys, name, folder):
    before = sorted(folder.iterdir())
    assert run(f"import --sheet sheet.toml --forces forces.csv -o {name}".split()) == 2
    assert capsys.readouterr().err == f"labrig: {name}: a session is HDF5; name it old.h5.\n"
    assert run(f"run rig.toml protocol.toml sheet.toml -o {name}".split()) == 2
    assert f"{name}: a session is HDF5; name it old.h5." in capsys.readouterr().err
    assert sorted(folder.iterdir()) == before


@pytest.mark.slow
def test_fit_reads_the_same_tables(capsys):
    assert run(f"fit {OLD} {NAMES} -o model.toml".split()) == 0
    told = capsys.readouterr()
    assert "F (N) is force_mN; std (N) is sd_mN; n is mean_of; not used: Comment." in told.err
    assert "bending stiffness B" in told.out
    assert run(["fit", "--sheet", "sheet.toml", "--forces", "forces.csv", "--apart"]) == 2
    assert "--apart and --by-run compare sessions" in capsys.readouterr().err


def test_the_examples_are_written_once(capsys):
    assert run(["import", "--example", "there"]) == 0
    said = capsys.readouterr().out
    assert f"labrig import --sheet {Path('there') / 'sheet.toml'}" in said
    assert run(["import", "--example", "there"]) == 2
    assert "already there; give another folder" in capsys.readouterr().err
