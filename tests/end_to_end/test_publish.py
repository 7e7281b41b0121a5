"""`[publish]` of rig.toml: documents while the run is on, and nothing depends on them."""

from __future__ import annotations

import json
import sys

import pytest

from labrig.session import open_session
from tests.end_to_end.small_rig import ONE_POSITION, labrig, make_rig

pytestmark = pytest.mark.slow


def publishing(folder, target="documents.jsonl"):
    make_rig(folder, ONE_POSITION)
    rig = folder / "rig.toml"
    rig.write_text(f'{rig.read_text()}\n[publish]\nbluesky = "{target}"\n')
    return [rig, folder / "protocol.toml", folder / "sheet.toml", "-o", folder / "s.h5", "--yes"]


def test_a_run_publishes_valid_documents_with_the_readings_of_its_session(tmp_path):
    from event_model import DocumentNames, schema_validators

    assert labrig("run", *publishing(tmp_path)) == 0
    text = (tmp_path / "documents.jsonl").read_text(encoding="utf-8")
    found = [json.loads(line) for line in text.splitlines()]
    for name, content in found:
        schema_validators[DocumentNames[name]].validate(content)
    with open_session(tmp_path / "s.h5") as session:
        rows = [row for run in session.runs for row in run.readings_as_taken]
        samples = sum(run.samples for run in session.runs)
        assert found[0][1]["uid"] == session.identifier
    events = [content for name, content in found if name == "event"]
    assert [e["data"]["force_N"] for e in events] == [float(row["force_N"]) for row in rows]
    ends = {c["stream_resource"]: c["indices"]["stop"] for n, c in found if n == "stream_datum"}
    forces = [c for n, c in found if n == "stream_resource" and c["data_key"] == "force"]
    assert sum(ends[each["uid"]] for each in forces) == samples
    assert found[-1][0] == "stop"
    assert found[-1][1]["exit_status"] == "success"


def test_a_file_that_cannot_be_written_is_refused_before_anything_is_opened(tmp_path, capsys):
    assert labrig("run", *publishing(tmp_path, "not/there.jsonl")) == 2
    assert "publish.bluesky" in capsys.readouterr().err
    assert not (tmp_path / "s.h5").exists()


def test_a_missing_package_is_refused_before_anything_is_opened(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "event_model", None)
    assert labrig("run", *publishing(tmp_path)) == 2
    assert 'pip install "labrig[bluesky]"' in capsys.readouterr().err
    assert not (tmp_path / "s.h5").exists()


@pytest.mark.thorough
def test_a_publisher_that_fails_leaves_the_session_whole(tmp_path, monkeypatch):
    from labrig.experiment.notices.publish import BlueskyPublisher

    def broken(self, event):
        raise OSError("the share is gone")

    monkeypatch.setattr(BlueskyPublisher, "_reading", broken)
    assert labrig("run", *publishing(tmp_path)) == 0
    with open_session(tmp_path / "s.h5") as session:
        assert session.outcome == "completed"
        said = [event.text for event in session.events if event.kind == "warned"]
        assert any("the publisher failed" in text for text in said)
