"""[hooks] of rig.toml: who is told, of what, and that nothing else depends on it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

import pytest

from drivers.interfaces import Prompt
from labrig.config import parse_rig
from labrig.config.hooks import HooksConfig
from labrig.errors import BadInputError
from labrig.experiment.notices.hook_watch import hooks_of
from labrig.experiment.notices.hooks import Hooks, Notice, NotifyingOperator
from labrig.experiment.resume import resumed_plan
from labrig.session import open_session
from labrig.session.reading.guard_report import guard_report_path
from tests.end_to_end.real_rig import children
from tests.end_to_end.small_rig import ONE_POSITION, labrig, make_rig
from tests.end_to_end.test_children_end import until

KEEP = "import sys, os; open(sys.argv[1], 'a').write(sys.stdin.read() + '\\n')"


def keeping(file: Path, **more: object) -> HooksConfig:
    """Hooks that append what they are told to a file."""
    return HooksConfig.model_validate({"command": [sys.executable, "-c", KEEP, str(file)], **more})


def told(file: Path) -> list[dict[str, str]]:
    return [json.loads(line) for line in file.read_text().splitlines()]


@pytest.fixture
def log():
    return []


@pytest.fixture
def webhook():
    """A server that keeps what is posted to it."""
    posted = []

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self):
            posted.append(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
            self.send_response(204)
            self.end_headers()

        def log_message(self, *_):
            pass

    server = HTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}/hook", posted
    server.shutdown()
    thread.join()
    server.server_close()


def test_a_command_is_told_event_session_and_text(tmp_path, log):
    hooks = Hooks(keeping(tmp_path / "told"), "a.h5", log.append)
    hooks.ended(completed=True, text="all runs are done")
    hooks.close()
    (message,) = told(tmp_path / "told")
    assert message["event"] == "done"
    assert message["session"] == "a.h5"
    assert message["text"] == "all runs are done"
    assert log == []


def test_arguments_are_filled_in_and_no_shell_reads_them(tmp_path, log):
    file = tmp_path / "arguments"
    code = "import sys; open(sys.argv[1], 'w').write('|'.join(sys.argv[2:]))"
    words = ["{event}", "{session}", "{text}", "$HOME; {unknown}"]
    config = HooksConfig(command=(sys.executable, "-c", code, str(file), *words))
    hooks = Hooks(config, "a b.h5", log.append)
    hooks.tell(Notice.STOPPED, "`date` > {event}")
    hooks.close()
    assert file.read_text() == "stopped|a b.h5|`date` > {event}|$HOME; {unknown}"


def test_a_webhook_is_sent_json(webhook, log):
    address, posted = webhook
    hooks = Hooks(HooksConfig(webhook=address), "a.h5", log.append)
    hooks.tell(Notice.WAITING, "move to 5 mm")
    hooks.close()
    assert [(one["event"], one["text"]) for one in posted] == [("waiting", "move to 5 mm")]


def test_the_address_of_a_webhook_may_stand_in_the_environment(webhook, log, monkeypatch):
    address, posted = webhook
    hooks = Hooks(HooksConfig(webhook="env:OUR_HOOK"), "a.h5", log.append)
    monkeypatch.setenv("OUR_HOOK", address)
    hooks.tell(Notice.DONE, "")
    hooks.close()
    assert len(posted) == 1


@pytest.mark.parametrize(
    ("config", "why"),
    [
        ({"command": ["/no/such/program"]}, "FileNotFoundError"),
        ({"command": [sys.executable, "-c", "raise SystemExit(3)"]}, "ended with code 3"),
        ({"webhook": "http://127.0.0.1:9/"}, "URLError"),
        ({"webhook": "env:NOT_SET_ANYWHERE"}, "is not set"),
    ],
)
def test_a_hook_that_fails_is_logged_and_nothing_else(config, why, log):
    with hooks_of(
        HooksConfig.model_validate(config), Path("a.h5"), log.append, is_guarded=False
    ) as hooks:
        hooks.tell(Notice.DONE, "")
        hooks.close()
    assert len(log) == 1
    assert why in log[0]


@pytest.mark.slow
def test_a_hook_that_hangs_is_ended_after_its_time(log):
    sleeper = (sys.executable, "-c", "import time; time.sleep(60)")
    hooks = Hooks(HooksConfig(command=sleeper, timeout_s=0.5), "a.h5", log.append)
    began = time.monotonic()
    hooks.tell(Notice.DONE, "")
    assert time.monotonic() - began < 0.4  # it is not waited for
    hooks._threads[0].join(20)
    assert "was ended after 0.5 s" in log[0]


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="asks for a process by a signal")
def test_a_command_that_hangs_does_not_outlive_the_program(tmp_path, log):
    file = tmp_path / "pid"
    code = "import os, sys, time; open(sys.argv[1], 'w').write(str(os.getpid())); time.sleep(60)"
    hooks = Hooks(
        HooksConfig(command=(sys.executable, "-c", code, str(file)), timeout_s=1.0),
        "a.h5",
        log.append,
    )
    hooks.tell(Notice.DONE, "")
    hooks.close()
    assert "was ended" in log[0]  # before the program itself ends
    with pytest.raises(ProcessLookupError):
        os.kill(int(file.read_text()), 0)


@pytest.mark.slow
def test_what_stands_by_for_a_program_that_is_killed_while_starting_it_ends_without_a_word():
    module = [sys.executable, "-m", "labrig.experiment.notices.hook_watch"]
    done = subprocess.run(module, input=b"", capture_output=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="needs /proc")
@pytest.mark.parametrize("fails", [False, True])
def test_nothing_stands_by_after_the_session(tmp_path, log, fails):
    before = set(children(os.getpid()))
    with (
        suppress(BadInputError),
        hooks_of(keeping(tmp_path / "told"), tmp_path / "a.h5", log.append, is_guarded=True),
    ):
        (pid,) = set(children(os.getpid())) - before
        if fails:
            raise BadInputError("the rig is not ready.")
    assert pid not in children(os.getpid())
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


STANDING_BY = """
import sys, threading
from pathlib import Path
from labrig.config.hooks import HooksConfig
from labrig.experiment.notices.hook_watch import hooks_of

config = HooksConfig.model_validate_json(sys.argv[1])
with hooks_of(config, Path(sys.argv[2]), print, is_guarded=True):
    print("ready", flush=True)
    threading.Event().wait()
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="kills a process")
def test_what_the_guard_found_is_told_where_the_clock_was_set_back_during_the_run(tmp_path):
    told_file, session = tmp_path / "told", tmp_path / "a.h5"
    told_file.touch()
    config = keeping(told_file).model_dump_json()
    command = [sys.executable, "-c", STANDING_BY, config, str(session)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as program:
        assert program.stdout.readline() == b"ready\n"
        report = guard_report_path(session)
        facts = {"why": "killed", "state": "safe", "read_back_V": 0.0, "failures": []}
        report.write_text(json.dumps(facts))
        hour_ago_s = time.time() - 3600.0
        os.utime(report, (hour_ago_s, hour_ago_s))
        program.kill()
    until(lambda: told_file.stat().st_size > 0)
    (message,) = told(told_file)
    assert "the output guard has ended this run (killed)" in message["text"]


class Answers:
    def __init__(self, after_s):
        self.after_s = after_s

    def ask(self, prompt):
        time.sleep(self.after_s)  # noqa: TID251 - an operator takes real time
        return True


@pytest.mark.slow
@pytest.mark.parametrize(("after_s", "events"), [(0.0, []), (0.6, ["waiting"])])
def test_the_operator_is_told_of_a_question_that_stands_for_long(tmp_path, log, after_s, events):
    file = tmp_path / "told"
    file.touch()
    hooks = Hooks(keeping(file, waiting_after_s=0.2), "a.h5", log.append)
    operator = NotifyingOperator(Answers(after_s), hooks)
    assert operator.ask(Prompt(kind="moisten", text="Moisten the sheet."))
    hooks.close()
    assert [one["event"] for one in told(file)] == events


def test_an_error_before_the_first_voltage_is_told_as_stopped(tmp_path, log):
    with (
        pytest.raises(BadInputError),
        hooks_of(keeping(tmp_path / "told"), Path("a.h5"), log.append, is_guarded=False) as hooks,
    ):
        raise BadInputError("the rig is not ready.")
    hooks.close()
    assert [(one["event"], one["text"]) for one in told(tmp_path / "told")] == [
        ("stopped", "the rig is not ready.")
    ]


@pytest.mark.parametrize("webhook", ["ftp://example.org/", "example.org", "file:///etc/passwd"])
def test_a_webhook_is_http_or_https(webhook):
    text = f'[load_cell]\ncalibration = "c.toml"\n[hooks]\nwebhook = "{webhook}"\n'
    with pytest.raises(BadInputError, match="webhook"):
        parse_rig(text, "rig.toml")


@pytest.mark.slow
def test_a_run_tells_that_it_is_done_and_its_file_runs_no_command_elsewhere(tmp_path):
    rig = make_rig(tmp_path / "rig", ONE_POSITION)
    file = tmp_path / "told"
    hook = json.dumps([sys.executable, "-c", KEEP, str(file)])
    with (rig / "rig.toml").open("a") as text:
        text.write(f"\n[hooks]\ncommand = {hook}\n")
    files = [rig / name for name in ("rig.toml", "protocol.toml", "sheet.toml")]
    assert labrig("run", *files, "-o", rig / "night.h5") == 0
    assert [(one["event"], one["session"]) for one in told(file)] == [("done", "night.h5")]
    with open_session(rig / "night.h5") as session:
        assert resumed_plan(session).rig.hooks is None


@pytest.mark.thorough
def test_a_ctrl_c_while_hooks_are_waited_for_does_not_change_how_the_session_ended(
    tmp_path, monkeypatch, capsys
):
    """The code of an output that is not known to be safe must not be lost to impatience."""
    rig = make_rig(tmp_path / "rig", ONE_POSITION)
    closed = Hooks.close

    def interrupted(hooks):
        signal.raise_signal(signal.SIGINT)
        closed(hooks)

    monkeypatch.setattr(Hooks, "close", interrupted)
    files = [rig / name for name in ("rig.toml", "protocol.toml", "sheet.toml")]
    assert labrig("run", *files, "-o", rig / "night.h5") == 0
    assert "completed" in capsys.readouterr().out
