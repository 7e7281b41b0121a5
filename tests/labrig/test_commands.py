"""Commands: a file each, and those of other distributions."""

from __future__ import annotations

import os
import pkgutil
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest
import typer

import labrig.cli.commands
from labrig.cli.app import all_commands, module_of
from labrig.cli.command import Command, CommandExample, faults
from labrig.cli.main import run
from labrig.session.tables.columns import TABLES
from tests.cases import few
from tests.labrig.report_data import measure, session

ROOT = Path(__file__).parents[2]
OWN = [module.name for module in pkgutil.iter_modules(labrig.cli.commands.__path__)]
COUNT = '''
import labrig

def count(file: str) -> None:
    """Count the lines of a file."""
    with open(file) as lines:
        print(sum(1 for line in lines))

COMMAND = labrig.Command("count-lines", count)
'''


@pytest.mark.parametrize("name", OWN)
def test_each_file_of_the_folder_is_one_command_that_keeps_the_contract(name: str) -> None:
    command = import_module(f"labrig.cli.commands.{name}").COMMAND
    assert faults(command) == []
    assert module_of(command.name) == name


def test_the_order_of_the_commands_is_given_by_themselves() -> None:
    orders = [command.order for command in all_commands()]
    assert orders == sorted(orders)
    assert len(set(orders)) == len(orders)


@pytest.mark.slow
def test_to_list_the_commands_imports_nothing_slow() -> None:
    code = (
        "import sys; from labrig.cli.app import all_commands; all_commands(); "
        "print({'numpy', 'pydantic', 'scipy', 'h5py', 'cv2'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout == "set()\n"


def nothing() -> None: ...


def list_nothing() -> None:
    """List nothing."""


def documented(speed: int | str) -> None:
    """Do what no command line can say."""


@pytest.mark.parametrize(
    ("part", "fault"),
    [
        (nothing, "COMMAND is a function"),
        (Command("do it", list_nothing), "its name 'do it' is not lower-case words"),
        (Command("do", list_nothing, order="last"), "its order 'last'"),  # type: ignore[arg-type]
        (Command("do", "it"), "its action is neither"),  # type: ignore[arg-type]
        (Command("do", nothing), "it has no help"),
        (
            Command("do", list_nothing, examples=(CommandExample(line="labrig undo"),)),
            "its example 'labrig undo' does not begin with 'labrig do'",
        ),
        (
            Command("do", list_nothing, examples=("labrig do",)),  # type: ignore[arg-type]
            "its examples are not a tuple of labrig.CommandExample",
        ),
        (Command("do", typer.Typer()), "it has no help"),
        (Command("do", documented), "typer cannot read its arguments and options"),
    ],
)
def test_what_is_wrong_with_a_command_is_said(part: object, fault: str) -> None:
    assert fault in "; ".join(faults(part))


def documented_example(language: str) -> str:
    """The example of docs/howto/commands.md in this language, as it stands there."""
    text = (ROOT / "docs" / "howto" / "commands.md").read_text()
    return text.split(f"```{language}\n")[1].split("```")[0]


@pytest.mark.slow
def test_the_command_of_the_docs_works_as_it_stands_there(tmp_path: Path) -> None:
    session(tmp_path / "session.h5", measure("long"))
    points = tomllib.loads(documented_example("toml"))["project"]["entry-points"]
    ((name, value),) = points["labrig.commands"].items()
    assert value == "count_readings:COMMAND"
    install(tmp_path, "count_readings", name, documented_example("python"))
    counted = labrig_with(tmp_path, "count-readings", "session.h5")
    expected = sum(len(c.used()) for c in measure("long").conditions)
    assert counted.stdout == f"{expected}\n", counted.stderr
    listed = labrig_with(tmp_path, "--help").stdout
    assert listed.index("\n  list ") < listed.index("\n  count-readings ")
    assert listed.index("\n  count-readings ") < listed.index("\n  analyze ")


def install(where: Path, module: str, point: str, code: str) -> None:
    """Install a distribution with one module and one entry point."""
    (where / f"{module}.py").write_text(code)
    info = where / f"{module}-1.2.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.2\n")
    (info / "entry_points.txt").write_text(f"[labrig.commands]\n{point} = {module}:COMMAND\n")


def test_the_failure_of_another_distribution_is_said_to_be_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    install(tmp_path, "failing", "count-lines", COUNT.replace("open(file)", "1 / 0"))
    monkeypatch.syspath_prepend(str(tmp_path))
    assert run(["count-lines", "failing.py"]) == 5
    said = capsys.readouterr().err
    assert "labrig: failing 1.2 (failing.py, line 6) failed (ZeroDivisionError: " in said
    assert "report it to its authors with " in said
    monkeypatch.delitem(sys.modules, "failing")


def test_another_distribution_that_ends_the_program_is_told_in_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    install(tmp_path, "leaving", "count-lines", COUNT.replace("open(file)", "exit(0)"))
    monkeypatch.syspath_prepend(str(tmp_path))
    assert run(["count-lines", "leaving.py"]) == 5
    said = capsys.readouterr().err
    assert "labrig: leaving 1.2 (leaving.py, line 6) failed (SystemExit: 0); please" in said
    monkeypatch.delitem(sys.modules, "leaving")


def test_a_command_of_another_distribution_ends_with_the_code_of_typers_exit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = "import typer" + COUNT.replace("with open(file) as lines:", "raise typer.Exit(4)")
    code = code.replace("        print(sum(1 for line in lines))\n", "")
    install(tmp_path, "exiting", "count-lines", code)
    monkeypatch.syspath_prepend(str(tmp_path))
    assert run(["count-lines", "exiting.py"]) == 4
    monkeypatch.delitem(sys.modules, "exiting")


def test_our_own_end_of_the_program_stays_one(monkeypatch: pytest.MonkeyPatch) -> None:
    def leave(*_arguments: object, **_options: object) -> None:
        raise SystemExit(7)

    monkeypatch.setattr("labrig.cli.app._Application.main", leave)
    with pytest.raises(SystemExit):
        run(["list"])


def labrig_with(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(ROOT), str(folder)])
    return subprocess.run(
        [sys.executable, "-m", "labrig", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.slow
def test_a_command_of_another_distribution_is_listed_and_runs(tmp_path: Path) -> None:
    install(tmp_path, "counting", "count-lines", COUNT)
    shown = labrig_with(tmp_path, "--help")
    assert "count-lines  Count the lines of a file." in shown.stdout
    assert shown.stderr == ""
    assert labrig_with(tmp_path, "count-lines", "counting.py").stdout == "9\n"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("point", "code", "why"),
    few(
        [
            (
                "broken",
                "raise RuntimeError('no board')",
                "loading it failed with RuntimeError: no boa",
            ),
            (
                "undocumented",
                COUNT.replace('    """Count the lines of a file."""\n', ""),
                "no help",
            ),
            ("plan", COUNT, "there is a command of that name already"),
            ("imported", COUNT.replace("count-lines", "import"), "a command of that name already"),
        ]
    ),
)
def test_a_broken_command_is_left_out_with_one_sentence(
    tmp_path: Path, point: str, code: str, why: str
) -> None:
    install(tmp_path, "counting", point, code)
    shown = labrig_with(tmp_path, "--help")
    assert shown.returncode == 0
    assert "Commands:" in shown.stdout
    assert shown.stderr.startswith("labrig: the command '")
    assert "of counting" in shown.stderr
    assert why in shown.stderr
    assert len(shown.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run", "--resume", "--yes"], "--resume needs a value, --yes is another option"),
        (["fit", "s.h5", "-o", "--json"], "-o needs a value, --json is another option"),
    ],
)
def test_an_option_whose_value_was_forgotten_does_not_take_the_next_option(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(arguments) == 2
    assert f"{said}; see labrig {arguments[0]} -h." in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "option", "command"),
    [
        (["curves", "--batch", "A", "--batch", "B"], "--batch", "curves"),
        (["fit", "s.h5", "-o", "a.toml", "--output=b.toml"], "--output", "fit"),
        (["fit", "s.h5", "-oa.toml", "-o", "b.toml"], "--output", "fit"),
        (["batch", "fit", "A", "-o", "B", "-o", "C"], "--output", "batch fit"),
    ],
)
def test_an_option_that_takes_one_value_is_not_given_two(
    arguments: list[str], option: str, command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(arguments) == 2
    said = f"labrig: {option} is given twice, and takes one value; see labrig {command} -h.\n"
    assert capsys.readouterr().err == said


def test_options_that_may_be_repeated_are_and_what_follows_two_dashes_is_no_option(
    capsys: pytest.CaptureFixture[str],
) -> None:
    repeated = ["--position-mm", "1", "--position-mm", "2", "--json", "--json"]
    assert run(["simulate", "no.toml", *repeated]) == 2
    assert "no.toml: there is no such file" in capsys.readouterr().err
    assert run(["curves", "-o", "a", "--", "-o", "b"]) == 2
    assert "twice" not in capsys.readouterr().err


def test_a_value_that_looks_like_an_option_can_still_be_given(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["run", "--resume=--yes"]) == 2
    assert "--yes: there is no such file" in capsys.readouterr().err


def test_the_columns_of_the_tables_are_explained_with_their_axes_and_signs(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["config", "columns"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("Axes and signs: x runs along the sheet")
    for name, (about, required, optional) in TABLES.items():
        assert f"{name}: {about.rstrip('.')}" in said
        assert all(column in said for column in (*required, *optional))
    assert "towards larger positions" in said
