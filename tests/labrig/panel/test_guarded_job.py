"""A panel that comes upon a run without a process says what the guard has made of the output."""

from __future__ import annotations

import json
import socket
import threading

import pytest

from labrig.errors import LabrigError
from labrig.panel.job.jobs import Jobs
from labrig.panel.job.order import Order
from labrig.panel.job.registry import GOING, JobAddress, write_address
from labrig.panel.live.event_stream import EventStream
from labrig.panel.live.frame_pipeline import FramePipeline
from labrig.session.reading.guard_report import guard_report_path

REPORT = {"why": "the program hangs", "state": "safe", "read_back_V": 0.0, "failures": []}


class StreamToWaitFor(EventStream):
    """An event stream whose messages can be waited for."""

    def __init__(self):
        super().__init__()
        self.changed = threading.Condition()

    def publish(self, message):
        super().publish(message)
        with self.changed:
            self.changed.notify_all()

    def publish_story(self, messages):
        super().publish_story(messages)
        with self.changed:
            self.changed.notify_all()

    def until(self, **wanted):
        def there():
            return [m for m in self.messages() if wanted.items() <= m.items()]

        with self.changed:
            assert self.changed.wait_for(there, 20), f"{wanted} was not told: {self.messages()}"
        return there()[-1]


@pytest.fixture
def jobs(tmp_path):
    """`(stream, jobs)` of a panel that finds a run whose process is gone."""
    with socket.socket() as closed:  # nobody will listen there
        closed.bind(("127.0.0.1", 0))
        port = closed.getsockname()[1]
    run = JobAddress(
        id="7",
        kind="run",
        by="Ann",
        wall="now",
        session="s.h5",
        rig=None,
        pid=1,
        port=port,
        key="key",
        state=GOING,
    )
    write_address(tmp_path, run)
    made = []

    def start():
        stream = StreamToWaitFor()
        made.append(Jobs(tmp_path, stream, FramePipeline(stream)))
        return stream, made[-1]

    yield start
    for each in made:
        each.close()


@pytest.mark.slow
@pytest.mark.parametrize("when", ["before the panel looks", "later"])
def test_that_the_guard_ended_the_run_and_wrote_0_V_is_told(jobs, tmp_path, when):
    if when == "before the panel looks":
        guard_report_path(tmp_path / "s.h5").write_text(json.dumps(REPORT))
    stream, panel = jobs()
    if when == "later":
        assert stream.until(type="output")["state"] == "unknown"
        guard_report_path(tmp_path / "s.h5").write_text(json.dumps(REPORT))
    assert stream.until(type="output", by="guard")["state"] == "safe"
    told = panel.message()
    assert told["state"] == "lost"
    assert "the output guard has ended this run (the program hangs)" in told["text"]
    assert "0 V written and read back" in told["text"]
    assert "labrig recover" in told["text"]
    assert stream.messages()[-2] == told


@pytest.mark.slow
def test_a_guard_that_has_read_0_V_back_at_last_is_heard(jobs, tmp_path):
    report = guard_report_path(tmp_path / "s.h5")
    report.write_text(json.dumps({**REPORT, "state": "unknown", "read_back_V": None}))
    stream, panel = jobs()
    stream.until(type="output", by="guard", state="unknown")
    assert "NOT KNOWN TO BE SAFE" in panel.message()["text"]
    report.write_text(json.dumps(REPORT))
    stream.until(type="output", by="guard", state="safe")
    assert "NOT KNOWN TO BE SAFE" not in panel.message()["text"]


def test_a_new_run_does_not_inherit_the_report_of_an_old_one_of_its_name(jobs, tmp_path):
    """It would be shown as safe while it begins, and its own guard would not be heard."""
    stale = guard_report_path(tmp_path / "new.h5")
    stale.write_text(json.dumps(REPORT))
    stream, panel = jobs()
    stream.until(type="output", state="unknown")

    def spawned(processes, order):
        assert not stale.exists()
        raise LabrigError("far enough")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("labrig.panel.job.process.JobProcesses.begin", spawned)
        with pytest.raises(LabrigError, match="far enough"):
            panel.start(run_into(tmp_path / "new.h5"))


def test_an_order_that_will_be_refused_takes_no_report_from_the_session_that_is_there(
    jobs, tmp_path
):
    (tmp_path / "s.h5").write_bytes(b"cut short")
    guard_report_path(tmp_path / "s.h5").write_text(json.dumps(REPORT))
    stream, panel = jobs()
    stream.until(type="output", by="guard")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("labrig.panel.job.process.JobProcesses.begin", refusing)
        with pytest.raises(LabrigError, match="refused"):
            panel.start(run_into(tmp_path / "s.h5"))
    assert guard_report_path(tmp_path / "s.h5").exists()


def run_into(session):
    return Order(
        id="8", kind="run", by="Ann", wall="now", data=str(session.parent), session=str(session)
    )


def refusing(processes, order):
    raise LabrigError("refused")


def test_an_output_that_the_guard_could_not_make_safe_stays_unknown(jobs, tmp_path):
    failed = {**REPORT, "state": "unknown", "failures": ["no connection"]}
    guard_report_path(tmp_path / "s.h5").write_text(json.dumps(failed))
    stream, _ = jobs()
    told = stream.until(type="output", by="guard")
    assert told["state"] == "unknown"
    assert "switch the amplifier off by hand" in told["why"]
