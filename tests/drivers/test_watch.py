"""The watch at the boards: who may speak to it, what it hears, and when it writes 0 V."""

from __future__ import annotations

import contextlib
import errno
import os
import socket
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from drivers.guard import GuardSettings
from drivers.interfaces import DeviceError, RealClock
from drivers.safe_shutdown import Safety, SafetyReport
from drivers.watch import BoardsWatch, WatchLink, read_token
from drivers.watch.wire import Frames, NotProvenError, read_line

TOKEN = b"0123456789abcdef0123456789abcdef"
PLACE = {"address": "local", "output_channel": "PCI6703/ao0", "limit_board_V": 0.25}
CLOCK = RealClock()


class FakeRescue:
    """Boards that note when they were made safe; they refuse as often as they are told."""

    def __init__(self) -> None:
        self.safe_s: list[float] = []
        self.refusals = 0

    def open(self) -> None:
        """They are there."""

    def make_safe(self, _patience_s, _on_held) -> SafetyReport:
        """0 V, or not yet."""
        if self.refusals:
            self.refusals -= 1
            return SafetyReport(Safety.UNKNOWN, None, ("refused",))
        self.safe_s.append(CLOCK.now())
        return SafetyReport(Safety.SAFE, 0.0, ())

    def close(self) -> None:
        """Nothing is held."""


class Scene:
    """A watch, its boards, and what it has said."""

    def __init__(self, tell=None) -> None:
        self.boards, self.said = FakeRescue(), []
        settings = GuardSettings(boards="fake", place=PLACE)
        tell = tell or self.said.append
        self.watch = BoardsWatch(settings, self.boards, TOKEN, CLOCK, tell)
        self.port = self.watch.listen("127.0.0.1", 0)
        self.links: list[WatchLink] = []

    def link(self, token: bytes = TOKEN, place=None) -> WatchLink:
        """A program; its boards have another address there."""
        there = {"address": "192.0.2.7:31763"}
        self.links.append(WatchLink("127.0.0.1", self.port, token, (place or PLACE) | there))
        return self.links[-1]

    def until(self, condition, timeout_s: float = 3.0) -> None:
        """Wait."""
        end_s = CLOCK.now() + timeout_s
        while not condition():
            assert CLOCK.now() < end_s, self.said
            wait(0.005)


def wait(seconds: float) -> None:
    CLOCK.sleep_until(CLOCK.now() + seconds)


def beating(link: WatchLink, seconds: float) -> None:
    """The working loop, for a while."""
    end_s = CLOCK.now() + seconds
    while CLOCK.now() < end_s:
        link.beat()
        wait(0.02)


@pytest.fixture
def scene() -> Iterator[Scene]:
    made = Scene()
    yield made
    for link in made.links:
        link.close()
    made.watch.stop()


@pytest.mark.alone
def test_a_program_that_falls_silent_while_energised_is_made_safe_within_a_second(scene):
    link = scene.link()
    link.energised(on=True)
    beating(link, 0.5)
    assert scene.boards.safe_s == []
    silent_s = CLOCK.now()
    scene.until(lambda: scene.boards.safe_s)  # its other thread still sends signs
    assert 0.4 < scene.boards.safe_s[0] - silent_s < 0.9
    scene.until(lambda: link._lost)
    with pytest.raises(DeviceError, match=r"has ended this run .the program is silent"):
        link.energised(on=True)


@pytest.mark.alone
def test_a_connection_that_ends_while_energised_is_made_safe_within_a_second(scene):
    link = scene.link()
    link.energised(on=True)
    link._line.shutdown(socket.SHUT_RDWR)
    gone_s = CLOCK.now()
    scene.until(lambda: scene.boards.safe_s)
    assert scene.boards.safe_s[0] - gone_s < 0.5


@pytest.mark.slow
def test_a_program_that_finishes_leaves_the_boards_alone_and_the_next_one_is_watched(scene):
    for _ in range(2):
        link = scene.link()
        link.new_run()
        link.energised(on=True)
        beating(link, 0.1)
        link.energised(on=False)
        wait(0.8)  # at 0 V nobody need beat
        link.energised(on=True)
        link.energised(on=False)
        link.close()
        scene.until(lambda: not scene.watch.is_watching)
    assert scene.boards.safe_s == []
    assert sum("has finished" in text for text in scene.said) == 2


@pytest.mark.slow
def test_a_link_that_is_closed_before_0_V_was_confirmed_leaves_it_to_the_watch(scene):
    link = scene.link()
    link.energised(on=True)
    link.close()
    scene.until(lambda: scene.boards.safe_s)


def _nobody_hears(_text: str) -> None:
    raise BrokenPipeError(errno.EPIPE, os.strerror(errno.EPIPE))


@pytest.mark.slow
def test_a_watch_whose_reader_is_gone_or_whose_log_is_full_watches_all_the_same():
    scene = Scene(tell=_nobody_hears)
    scene.boards.refusals = 1
    link = scene.link()
    try:
        link.energised(on=True)
        beating(link, 0.3)
        link.close()
        scene.until(lambda: scene.boards.safe_s, timeout_s=10.0)
    finally:
        scene.watch.stop()


@pytest.mark.slow
def test_boards_that_refuse_are_tried_until_they_do_not(scene):
    scene.boards.refusals = 3
    link = scene.link()
    link.energised(on=True)
    link.close()
    scene.until(lambda: scene.boards.safe_s)
    assert "NOT KNOWN TO BE SAFE" in scene.said[1]
    scene.until(lambda: "the output is safe" in scene.said[-1])


def test_whoever_lacks_the_token_or_drives_another_output_is_refused(scene):
    with pytest.raises(NotProvenError, match="the token is another one"):
        scene.link(b"f" * 32)
    with pytest.raises(NotProvenError, match=r"output_channel = 'PCI6703/ao1', the watch's has"):
        scene.link(place=PLACE | {"output_channel": "PCI6703/ao1"})
    scene.link()
    with pytest.raises(NotProvenError, match="it watches over another program"):
        scene.link()


def test_a_watch_that_lacks_the_token_is_not_taken_for_one(scene):
    listener = socket.create_server(("127.0.0.1", 0))

    def pretend() -> None:
        with listener, listener.accept()[0] as line:
            line.sendall(b'{"labrig_watch": 1, "nonce": "00"}\n')
            line.recv(4096)
            line.sendall(b'{"ok": true, "proof": "00"}\n')

    thread = threading.Thread(target=pretend)
    thread.start()
    with pytest.raises(NotProvenError, match="does not have the token"):
        WatchLink("127.0.0.1", listener.getsockname()[1], TOKEN, PLACE)
    thread.join()


@pytest.mark.slow
def test_silent_connections_and_floods_keep_nobody_from_being_watched(scene):
    link = scene.link()
    link.energised(on=True)
    with socket.create_connection(("127.0.0.1", scene.port)) as one:
        one.sendall(b"\0" * 10_000)
    idle = [socket.create_connection(("127.0.0.1", scene.port)) for _ in range(100)]
    beating(link, 0.5)
    assert scene.boards.safe_s == []
    link.energised(on=False)
    for line in idle:
        line.close()


@pytest.mark.slow
def test_a_greeting_that_comes_byte_by_byte_is_cut_off(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.watch.server._GREETING_S", 0.3)
    scene = Scene()
    with socket.create_connection(("127.0.0.1", scene.port)) as line:
        read_line(line)
        began_s = CLOCK.now()
        with contextlib.suppress(OSError):  # where it has been cut off
            while CLOCK.now() < began_s + 3.0:
                line.send(b"x")
                wait(0.1)
        assert CLOCK.now() - began_s < 1.5
    scene.watch.stop()


def test_a_frame_that_was_changed_or_sent_again_ends_the_connection():
    ours, theirs = socket.socketpair()
    with ours, theirs:
        sent, heard = Frames(ours, TOKEN, "x"), Frames(theirs, TOKEN, "x")
        sent.send(b".", "text")
        assert heard.read() == (b".", "text")
        again = Frames(ours, TOKEN, "x")  # its numbers begin anew
        again.send(b".", "text")
        assert heard.read() is None
    ours, theirs = socket.socketpair()
    with ours, theirs:
        Frames(ours, TOKEN, "y").send(b".")
        assert Frames(theirs, TOKEN, "x").read() is None


def test_a_frame_that_comes_in_pieces_is_read_across_a_time_out():
    ours, theirs = socket.socketpair()
    with ours, theirs:
        copy, far = socket.socketpair()
        with copy, far:
            Frames(copy, TOKEN, "x").send(b".", "whole")
            data = far.recv(4096)
        theirs.settimeout(0.05)
        heard = Frames(theirs, TOKEN, "x")
        ours.sendall(data[:10])
        with pytest.raises(TimeoutError):
            heard.read()
        ours.sendall(data[10:])
        assert heard.read() == (b".", "whole")


@pytest.mark.parametrize("text", [None, "short\n"])
def test_a_token_that_is_none_is_said_so(tmp_path: Path, text: str | None):
    if text is not None:
        (tmp_path / "watch.token").write_text(text)
    with pytest.raises(DeviceError, match=r"the watch's token .*watch\.token"):
        read_token(tmp_path / "watch.token")


def test_a_beat_to_a_watch_that_is_gone_stops_the_run(scene):
    link = scene.link()
    link.energised(on=True)
    scene.watch.stop()
    link._line.shutdown(socket.SHUT_RDWR)
    scene.until(lambda: link._lost)
    with pytest.raises(DeviceError, match="the run must stop"):
        beating(link, 2.0)
