"""A recorded session is shown as it was shown while it was recorded."""

from __future__ import annotations

import time
from itertools import pairwise

import numpy as np
import pytest

from labrig.panel.replay import Recording
from tests.labrig.panel.page import Page, panel

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def recorded(rig_folder):
    """What a page was told of a run, and the file that was made of it."""
    with panel(rig_folder / "rig.toml", lean=True) as server:
        page = Page(server)
        page.take_control()
        run = {"protocol": "short.toml", "session": "recorded.h5", "clock": "virtual"}
        assert page.ended(page.do("/api/run", **run))["code"] == 0
        messages, strips = page.messages, page.strips
        page.close()
    return messages, strips, rig_folder / "recorded.h5"


@pytest.fixture(scope="module")
def replayer(recorded):
    """A panel on that file."""
    with panel(recorded[2]) as server:
        yield server


@pytest.fixture
def replaying(replayer):
    """A page that replays it."""
    page = Page(replayer, "/ws/replay?session=recorded.h5")
    yield page
    page.close()


def alike(live, again):
    """The same but for the last digit of times; who acted is in words in the file."""
    assert live.keys() == again.keys()
    for key, value in live.items():
        if key == "log" or (live["type"], key) in {("action", "who"), ("action", "what")}:
            continue
        if (live["type"], key) in {("prompt", "configuration"), ("prompt", "position_mm")}:
            continue  # the file has them in the prompt's words only
        if isinstance(value, float):
            assert again[key] == pytest.approx(value, abs=2e-6), (live, again)
        else:
            assert again[key] == value, (live, again)


def test_a_replay_tells_what_the_run_told(recorded, replaying):
    live = recorded[0]
    replaying.until("plan")
    first = replaying.first_replay
    assert {mark["kind"] for mark in first["marks"]} == {"run", "reading", "log"}
    replaying.say(do="seek", at_s=first["duration_s"])
    replaying.until("ended")
    kinds = ("started", "output", "prompt", "answered", "run_started", "voltage", "reading",
             "action", "run_stopped", "ended")  # fmt: skip
    for kind in kinds:
        was, is_now = [m for m in live if m["type"] == kind], replaying.of(kind)
        assert len(was) == len(is_now) > 0, kind
        for one, other in zip(was, is_now, strict=True):
            alike(one, other)
    plan, planned = replaying.of("plan")[0], next(m for m in live if m["type"] == "plan")
    assert plan["runs"] == planned["runs"]
    assert plan["limits"] == planned["limits"]
    assert plan["clock"] == "replay"
    replaying.until(lambda _: bool(replaying.pictures))


def test_the_signals_of_a_replay_are_those_of_the_run(recorded):
    _, strips, path = recorded
    live = np.concatenate(
        [np.frombuffer(payload, "<f4").reshape(7, -1) for _, payload in strips], axis=1
    )
    recording = Recording(path, path.name)
    try:
        span = recording.spans[0]
        edges = np.linspace(0, span.to_s, 41)
        parts = [recording.strip(a, b, fresh=False) for a, b in pairwise(edges)]
    finally:
        recording.close()
    again = np.concatenate([part.values for part in parts if part is not None], axis=1)
    shared = np.intersect1d(live[0], again[0])
    assert len(shared) > 0.95 * live.shape[1]
    assert len(np.unique(again[0])) == again.shape[1]
    pick = [np.isin(values[0], shared) for values in (live, again)]
    np.testing.assert_allclose(again[:, pick[1]], live[:, pick[0]], rtol=1e-4, atol=1e-4)


def test_a_replay_plays_at_its_speed_and_leaves_gaps_out(replaying):
    first = replaying.until("replay")
    replaying.say(do="speed", speed=10)
    replaying.say(do="play")
    began_s = time.monotonic()
    replaying.until("ended")
    took_s = time.monotonic() - began_s
    assert took_s > 0.6 * (first["duration_s"] - 4) / 10
    assert took_s < first["duration_s"] / 10 + 3
    readings = replaying.of("reading")
    assert [r["index"] for r in readings] == list(range(len(readings)))
    replaying.until(lambda m: m["type"] == "replay" and not m["playing"])


def test_scrubbing_goes_back_and_forth_and_answers_the_last_place(replaying):
    duration_s = replaying.until("replay")["duration_s"]
    for at_s in np.linspace(duration_s, 0.3 * duration_s, 12):
        replaying.say(do="seek", at_s=float(at_s))
    at = replaying.until(
        lambda m: m["type"] == "replay" and m["at_s"] == pytest.approx(0.3 * duration_s)
    )
    assert not at["playing"]
    assert not replaying.of("ended")
    late = [m for m in replaying.messages if (m.get("time_s") or 0) > 0.3 * duration_s]
    assert not [m for m in late if m["type"] in {"reading", "voltage"}]


def test_what_cannot_be_replayed_is_told_in_a_sentence(recorded, replayer):
    folder = recorded[2].parent
    (folder / "none.h5").write_bytes(b"nothing")
    for name, part in (
        ("none.h5", "not an HDF5 file"),
        ("gone.h5", "no such file"),
        ("../a.h5", "name"),
    ):
        page = Page(replayer, f"/ws/replay?session={name}")
        assert page.hello["type"] == "error"
        assert part in page.hello["error"]
        page.close()
    status = replayer.ask("GET", "/api/status")[1]
    assert (status["mode"], status["session"]) == ("replay", "recorded.h5")


def test_two_replays_side_by_side_do_not_disturb_each_other(replayer):
    pages = [Page(replayer, "/ws/replay?session=recorded.h5") for _ in range(2)]
    ends = [page.until("replay")["duration_s"] for page in pages]
    pages[0].say(do="seek", at_s=ends[0])
    pages[0].until("ended")
    assert not pages[1].of("ended")
    for page in pages:
        page.close()
