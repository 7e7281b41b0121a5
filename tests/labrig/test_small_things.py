"""--version, -h, completion, help that fits a terminal, and the lines that tell of waiting."""

from __future__ import annotations

import importlib.metadata
import logging
import os
import re
import shlex
import signal
import subprocess
import sys
import threading
from pathlib import Path
from types import SimpleNamespace

import pytest
import typer

from labrig.cli.app import all_commands, app_for
from labrig.cli.main import ignore_unraisable, main, run
from labrig.cli.screen import print_table, say, time_left, warn
from labrig.cli.sentences.compiling import TOLD, compiling_is_told
from labrig.errors import ExitCode
from labrig.files import typed
from labrig.session.reading.opening import cut_short
from labrig.version import NOT_INSTALLED, commit_of, version

COMMANDS = {command.name: command for command in all_commands()}


def test_the_version_is_that_of_the_distribution(capsys):
    assert run(["--version"]) == 0
    said = capsys.readouterr().out
    assert re.fullmatch(r"labrig \S+ \(Python 3\.\d+\.\d+\S*, \w+\)\n", said)
    assert version() in said
    installed = importlib.metadata.version("labrig")
    assert version().partition("+")[0] == installed.partition("+")[0]


def test_an_editable_checkout_has_the_version_of_its_present_commit(tmp_path, monkeypatch):
    """A session recorded the commit at which labrig was installed, not the one that ran."""

    def git(*arguments):
        identity = ("-c", "user.name=x", "-c", "user.email=x@x.invalid")
        command = ["git", *identity, "-C", str(tmp_path), *arguments]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()

    (tmp_path / "pyproject.toml").write_text('name = "labrig"\n')
    git("init", "--quiet", "--initial-branch=main")
    git("add", ".")
    git("commit", "--quiet", "-m", "first")
    monkeypatch.setattr("labrig.version._SOURCES", tmp_path)
    commit_of.cache_clear()
    assert version().endswith(f"+g{git('rev-parse', 'HEAD')[:9]}")
    git("commit", "--quiet", "--allow-empty", "-m", "second")
    git("pack-refs", "--all")
    git("worktree", "add", "--quiet", str(tmp_path / "beside"), "-b", "other")
    commit = git("rev-parse", "HEAD")
    for sources in (tmp_path, tmp_path / "beside"):
        commit_of.cache_clear()
        assert commit_of(sources) == commit
    git("checkout", "--quiet", "--detach")
    commit_of.cache_clear()
    assert commit_of(tmp_path) == commit
    assert commit_of(tmp_path / "nowhere") == ""
    monkeypatch.setattr("labrig.version._SOURCES", tmp_path / "nowhere")
    assert version() == importlib.metadata.version("labrig")
    commit_of.cache_clear()


def test_what_somebody_has_named_is_printed_as_it_is(capsys, monkeypatch):
    say("fork:a: 3 mm [bold]")
    warn("fork:a: 3 mm [bold]")
    monkeypatch.setattr("labrig.cli.screen.sys.stdout.isatty", lambda: True, raising=False)
    print_table("[x] table", ["name"], [["strip:a: [/red]"]])
    said = capsys.readouterr()
    assert said.out.startswith("fork:a: 3 mm [bold]\n")
    assert said.err == "fork:a: 3 mm [bold]\n"
    assert "strip:a: [/red]" in said.out


@pytest.mark.parametrize("width", [20, 60])
def test_no_number_is_cut_where_a_table_is_wider_than_the_terminal(capsys, monkeypatch, width):
    monkeypatch.setenv("COLUMNS", str(width))
    monkeypatch.setattr("labrig.cli.screen.sys.stdout.isatty", lambda: True, raising=False)
    columns = ["session", "largest force, mN", "scatter, mN"]
    print_table("night", columns, [["01-protocol.h5", "1.9624", "0.0223"]])
    said = capsys.readouterr().out
    assert {"01-protocol.h5", "1.9624", "0.0223"} <= set(said.split())


def test_sources_that_nobody_installed_have_a_version_too(monkeypatch):
    def none(name):
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(importlib.metadata, "version", none)
    assert version() == NOT_INSTALLED


@pytest.mark.slow
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_signal_after_a_command_has_ended_does_not_change_its_code(name):
    """Somebody presses Ctrl-C until the prompt returns."""
    late = (
        "import atexit, importlib, signal\n"
        "cli = importlib.import_module('labrig.cli.main')\n"
        f"atexit.register(signal.raise_signal, signal.{name})\n"
        "cli.run = lambda _arguments: 6\n"
        "cli.main()"
    )
    done = subprocess.run([sys.executable, "-c", late], capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (6, b"")


@pytest.mark.parametrize("name", COMMANDS)
def test_each_command_knows_the_short_form_of_help(name, capsys):
    assert run([name, "-h"]) == 0
    said = capsys.readouterr().out
    assert f"Usage: labrig {name}" in said
    assert "-h, --help" in said


def test_the_first_sentences_fit_a_terminal(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    assert run(["-h"]) == 0
    listed = capsys.readouterr().out.partition("Commands:")[2]
    assert "..." not in listed
    assert len(listed.strip().splitlines()) == len(COMMANDS)


GROUPS = [name for name, one in COMMANDS.items() if isinstance(one.action, typer.Typer)]


def subcommands(name):
    group = app_for([name]).commands[name]
    return group.list_commands(typer.Context(group))


@pytest.mark.parametrize("name", GROUPS)
def test_the_first_sentences_of_a_groups_commands_fit_too(name, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    assert run([name, "-h"]) == 0
    listed = capsys.readouterr().out.partition("Commands:")[2].partition("\n\n")[0]
    assert "..." not in listed
    assert len(listed.strip().splitlines()) == len(subcommands(name))


SUBCOMMANDS = [f"{group} {name}" for group in GROUPS for name in subcommands(group)]


@pytest.mark.parametrize("name", [*COMMANDS, *SUBCOMMANDS])
def test_each_help_ends_with_an_example(name, capsys):
    assert run([*name.split(), "-h"]) == 0
    shown = re.split(r"\n  Examples?:\n", capsys.readouterr().out)[1].splitlines()
    assert shown
    assert all(line.startswith(f"    labrig {name}") for line in shown)


def completed(words: str) -> set[str]:
    place = {"_LABRIG_COMPLETE": "complete_bash", "COMP_WORDS": words, "COMP_CWORD": "1"}
    found = subprocess.run(
        [sys.executable, "-m", "labrig"],
        env=os.environ | place, capture_output=True, text=True, check=False,
    )  # fmt: skip
    return set(found.stdout.split())


@pytest.mark.slow
def test_a_shell_completes_commands():
    assert completed("labrig di") == {"diagnose"}


def test_what_is_compiled_first_is_told_once(capsys):
    with compiling_is_told():
        for _ in range(3):
            logging.getLogger("labrig.compiling").info("compiling once")
    logging.getLogger("labrig.compiling").info("nobody asks")
    assert capsys.readouterr().err == f"{TOLD}\n"


COMPILED = """
import logging, os, sys
sys.path.insert(0, os.environ["SOURCES"])
from labrig.cli.sentences.compiling import compiling_is_told
with compiling_is_told():
    from model.jit import jit
    import small
    small.twice(1.0)
"""


@pytest.mark.slow
def test_a_line_is_printed_where_nothing_compiled_was_kept_and_only_there(tmp_path):
    sources = Path(__file__).resolve().parents[2]
    (tmp_path / "small.py").write_text(
        "from model.jit import jit\n\n\n@jit\ndef twice(x):\n    return 2 * x\n"
    )
    place = os.environ | {"SOURCES": str(sources), "PYTHONPATH": str(tmp_path)}
    place |= {"NUMBA_CACHE_DIR": str(tmp_path / "kept")}
    said = [
        subprocess.run(
            [sys.executable, "-c", COMPILED],
            env=place, capture_output=True, text=True, check=True, cwd=tmp_path,
        ).stderr
        for _ in range(2)
    ]  # fmt: skip
    assert said == [f"{TOLD}\n", ""]


@pytest.mark.parametrize(
    ("taken_s", "fraction", "said"),
    [
        (60.0, 0.0, ""),
        (1.0, 0.5, ""),
        (20.0, 0.5, " - about 20 s left"),
        (60.0, 0.1, " - about 9 min left"),
        (60.0, 1.0, ""),
    ],
)
def test_how_long_a_job_takes_is_estimated_once_it_can_be(taken_s, fraction, said):
    assert time_left(taken_s, fraction) == said


def in_short_waits(seconds):
    """Wait: a signal that another thread sends is heard only between two waits."""
    for _ in range(int(seconds / 0.01)):
        threading.Event().wait(0.01)


def test_a_ctrl_c_that_comes_while_an_object_is_discarded_is_not_lost(monkeypatch):
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        ignore_unraisable(SimpleNamespace(exc_type=KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            in_short_waits(5.0)
        ignore_unraisable(SimpleNamespace(exc_type=ValueError))
        threading.Event().wait(0.1)
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.skipif(os.name == "nt", reason="words of a POSIX shell")
@pytest.mark.parametrize("name", ["plain.h5", "my session.h5", "Größe 'a' $b.h5"])
def test_a_command_that_is_proposed_can_be_typed(name):
    assert shlex.split(f"labrig recover {typed(name)}") == ["labrig", "recover", name]
    assert typed(name) in cut_short(Path(name))


def test_a_command_that_is_stopped_says_so_and_ends_with_the_documented_code(monkeypatch, capsys):
    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("labrig.session.recover", stopped)
    assert run(["recover", __file__]) == ExitCode.STOPPED
    assert capsys.readouterr().err == "labrig: stopped.\n"


def test_a_command_line_whose_reading_is_stopped_says_so_too(monkeypatch, capsys):
    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("typer.core.TyperGroup.parse_args", stopped)
    assert run(["recover", __file__]) == ExitCode.STOPPED
    assert capsys.readouterr().err == "labrig: stopped.\n"


def test_a_program_that_is_stopped_before_its_command_says_so_too(monkeypatch, capsys):
    def stopped():
        raise KeyboardInterrupt

    monkeypatch.setattr(sys.modules["labrig.cli.main"], "hidden", stopped)
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == ExitCode.STOPPED
    assert capsys.readouterr().err == "labrig: stopped.\n"
