"""Nobody who follows holds anything back, and nothing that matters is lost on the way."""

from __future__ import annotations

import socket
import threading
from contextlib import suppress

import numpy as np
import pytest

from labrig.panel.job.connection import JobConnection, JobConnectionServer
from labrig.panel.live.event_stream import MOST_WAITING, EventStream, Mailbox
from labrig.panel.live.packing import BrokenConnectionError, dumps, pack, receive, send, unpack
from labrig.panel.live.strip_chart import (
    BIN_S,
    KEEP_S,
    PREDICTED,
    SIGNALS,
    Envelope,
    StripChart,
    joined,
    strip_from,
)

KEYS = ("drive_V", "force_mN", "current_mA")


def strip(run, values, **more):
    return StripChart(run=run, keys=KEYS, values=np.asarray(values, dtype=np.float32), **more)


def taken(box):
    """All that is in a mailbox."""
    found = []
    while (mail := box.take()) is not None:
        found.append(mail)
    return found


def test_a_follower_is_told_the_story_and_then_what_happens():
    stream, box = EventStream(), Mailbox(lambda: None)
    stream.publish({"type": "started"})
    stream.join(box)
    stream.publish({"type": "reading", "index": 0})
    (mail,) = taken(box)
    assert mail.story == [{"type": "started"}]
    assert mail.messages == [{"type": "reading", "index": 0}]
    assert taken(box) == []


def test_a_follower_that_takes_nothing_has_a_bounded_box_and_hears_the_story_anew():
    stream, box = EventStream(), Mailbox(lambda: None)
    stream.join(box)
    count = 3 * MOST_WAITING + 7
    for index in range(count):
        stream.publish({"type": "reading", "index": index})
        assert len(box._messages) <= MOST_WAITING
    mails = taken(box)
    told = [m["index"] for mail in mails for m in [*(mail.story or []), *mail.messages]]
    assert told == list(range(count))


def test_of_pictures_only_the_newest_waits():
    stream, box = EventStream(), Mailbox(lambda: None)
    stream.join(box)
    for number in range(100):
        stream.publish_picture(({"type": "picture", "frame": number}, b"x" * 1000))
        stream.publish_newest({"type": "curve", "frame": number})
    assert box.take_picture() is None  # its story first
    (mail,) = taken(box)
    assert box.take_picture()[0]["frame"] == 99
    assert box.take_picture() is None
    assert [m["frame"] for m in mail.newest] == [99]


def test_who_has_left_is_told_nothing():
    stream, box = EventStream(), Mailbox(lambda: None)
    stream.join(box)
    stream.leave(box)
    taken(box)
    stream.publish({"type": "reading"})
    assert taken(box) == []


def test_no_spike_is_lost_in_a_strip_however_the_samples_come():
    rng = np.random.default_rng(3)
    times = np.arange(3000) / 1000.0
    values = rng.normal(size=(3, 3000))
    values[1, 1234] = 99.0
    samples = np.vstack([times, values])
    envelope, parts, at = Envelope(4, KEYS), [], 0
    while at < 3000:
        step = int(rng.integers(1, 97))
        part = envelope.add(samples[:, at : at + step])
        parts += [part] if part is not None else []
        at += step
    whole = np.concatenate([part.values for part in parts], axis=1)
    assert [part.fresh for part in parts] == [True] + [False] * (len(parts) - 1)
    bins = np.floor(times / BIN_S + 1e-6).astype(int)
    for column, number in enumerate(np.unique(bins)[:-1]):
        inside = values[:, bins == number]
        np.testing.assert_allclose(whole[1::2, column], inside.min(axis=1), rtol=1e-6)
        np.testing.assert_allclose(whole[2::2, column], inside.max(axis=1), rtol=1e-6)
        assert whole[0, column] == pytest.approx((number + 0.5) * BIN_S)
    assert whole[4].max() == 99.0


def test_strips_of_a_run_are_joined_and_not_longer_than_what_is_kept():
    pieces = [strip(0, np.full((7, 500), float(i))) for i in range(40)]
    (made,) = joined(pieces)
    assert made.values.shape[1] == round(KEEP_S / BIN_S)
    assert made.values[0, -1] == 39.0
    fresh = strip(1, np.zeros((7, 3)), fresh=True)
    assert joined([*pieces, fresh]) == [fresh]


def test_what_is_measured_and_what_is_predicted_wait_beside_each_other():
    stream, box = EventStream(), Mailbox(lambda: None)
    stream.join(box)
    for number in range(5):
        stream.publish_strip(strip(0, np.full((7, 2), float(number)), fresh=number == 0))
        predicted = np.full((7, 3), float(number))
        stream.publish_strip(strip(0, predicted, fresh=number == 0, kind=PREDICTED))
    sent = {mail.strip.kind: mail.strip for mail in taken(box) if mail.strip is not None}
    assert {kind: one.values.shape[1] for kind, one in sent.items()} == {SIGNALS: 10, PREDICTED: 15}
    assert strip_from(*unpack(sent[PREDICTED].packed())).kind == PREDICTED
    late = Mailbox(lambda: None)
    stream.join(late)
    assert [mail.strip.kind for mail in taken(late)] == [SIGNALS, PREDICTED]


def test_what_is_packed_comes_back_and_numbers_lie_where_a_page_can_read_them():
    values = np.arange(21, dtype="<f4").reshape(7, 3)
    packed = strip(2, values, fresh=True).packed()
    header, payload = unpack(packed)
    assert (len(packed) - len(payload)) % 8 == 0
    again = strip_from(header, payload)
    np.testing.assert_array_equal(again.values, values)
    assert (again.run, again.keys, again.fresh) == (2, KEYS, True)
    assert dumps({"a": [float("nan"), 1.0]}) == '{"a":[null,1.0]}'


@pytest.mark.parametrize("packed", [b"", b"abc", b"\xff\xff\xff\xff", pack({"a": 1})[:9], pack([])])
def test_what_is_damaged_is_refused(packed):
    with pytest.raises(BrokenConnectionError):
        unpack(packed)


class Silent:
    """A publisher that says one thing, then nothing until it is closed."""

    def __init__(self):
        self._closed = threading.Event()

    def run(self, send_it):
        send_it(pack({"type": "told"}))
        self._closed.wait()

    def close(self):
        self._closed.set()


@pytest.fixture
def server():
    """The job's side, doing what it is asked."""
    done = []

    def do(asked):
        done.append(asked)
        return {"error": "no."} if asked["do"] == "refuse" else {}

    found = JobConnectionServer(do, lambda _role: Silent())
    found.done = done
    yield found
    found.close(1.0)


@pytest.mark.slow
def test_a_link_asks_is_answered_and_is_told(server):
    told, ended = threading.Event(), threading.Event()
    connection = JobConnection(server.port, server.key, "panel", lambda *_: told.set(), ended.set)
    assert connection.ask({"do": "this"}).get("error") is None
    assert connection.ask({"do": "refuse"})["error"] == "no."
    assert told.wait(5)
    assert [asked["do"] for asked in server.done] == ["this", "refuse"]
    server.close(1.0)
    assert ended.wait(5)
    with pytest.raises(BrokenConnectionError):
        connection.ask({"do": "this"}, 0.5)
    connection.close()


@pytest.mark.parametrize("key", ["", "wrong", None, 3, []])
def test_a_link_without_the_key_is_closed_and_asks_nothing(server, key):
    with socket.create_connection(("127.0.0.1", server.port), 5) as raw:
        raw.settimeout(5)
        send(raw, pack({"key": key, "role": "panel"}))
        with suppress(OSError):
            send(raw, pack({"do": "this", "ask": 1}))
        with pytest.raises((BrokenConnectionError, OSError)):
            receive(raw)
    assert server.done == []


def test_a_message_that_claims_to_be_huge_closes_the_link(server):
    with socket.create_connection(("127.0.0.1", server.port), 5) as raw:
        raw.settimeout(5)
        raw.sendall(b"\xff\xff\xff\x7f")
        assert raw.recv(1) == b""
