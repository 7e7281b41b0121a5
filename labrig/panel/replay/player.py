"""Plays a recording into a stream, in a thread of its own."""

from __future__ import annotations

import threading
import time
from pathlib import Path

from labrig.errors import LabrigError
from labrig.panel.live.event_stream import EventStream, Message
from labrig.panel.live.frame_pipeline import FramePipeline
from labrig.panel.replay.recording import Recording

TICK_S = 0.05
STATE_EVERY_S = 0.25
SLOWEST, FASTEST = 0.1, 1000.0
GAP_S = 1.0  # of waiting that is shown, where gaps are left out


class Player:
    """At the beginning it stands at the first reading and does not play."""

    def __init__(self, path: Path, name: str, model: Path | None) -> None:
        """Open a session. Raises BadInputError when it cannot be replayed."""
        self.stream = EventStream()
        self._recording = Recording(path, name)
        self._frame_pipeline = FramePipeline(self.stream)
        self._frame_pipeline.set_setup(self._recording.setup)
        self._frame_pipeline.choose_model(model)
        self._changed = threading.Condition()
        self._at_s = self._recording.first_s
        self._seek: float | None = self._at_s
        self._playing = False
        self._speed = 1.0
        self._skip = True
        self._closed = False
        self._thread = threading.Thread(target=self._play, name="replay", daemon=True)
        self._thread.start()

    def first(self) -> Message:
        """Return the first `replay` message, with the marks of the slider."""
        return {**self._state(), "marks": self._recording.marks()}

    def do(self, command: Message) -> None:
        """Follow a page's command; one that makes no sense is ignored."""
        what, speed, at_s = command.get("do"), command.get("speed"), command.get("at_s")
        with self._changed:
            if what in {"play", "pause"}:
                self._playing = what == "play"
                if self._playing and self._at_s >= self._recording.duration_s:
                    self._seek = 0.0
            elif what == "speed" and isinstance(speed, int | float):
                self._speed = min(max(float(speed), SLOWEST), FASTEST)
            elif what == "seek" and isinstance(at_s, int | float):
                self._seek = min(max(float(at_s), 0.0), self._recording.duration_s)
            elif what == "gaps":
                self._skip = bool(command.get("skip"))
            else:
                return
            self._changed.notify()
        self.stream.publish_newest(self._state())

    def close(self) -> None:
        """End it."""
        with self._changed:
            self._closed = True
            self._changed.notify()
        self._thread.join(5.0)
        self._frame_pipeline.close()
        self._recording.close()

    # --------------------------------------------------------------------------------- its thread

    def _play(self) -> None:
        then_s = stated_s = time.monotonic()
        while True:
            with self._changed:
                if not self._closed and self._seek is None:
                    self._changed.wait(TICK_S if self._playing else None)
                if self._closed:
                    return
                seek, self._seek = self._seek, None
            now_s = time.monotonic()
            passed_s, then_s = now_s - then_s, now_s
            try:
                if seek is not None:
                    self._jump(seek)
                elif self._playing:
                    self._advance(min(passed_s, 10 * TICK_S) * self._speed)
            except (
                LabrigError,
                OSError,
                KeyError,
                ValueError,
            ) as error:  # a damaged part of the file
                self._playing = False
                text = f"the replay ends here: {error}"
                self.stream.publish(
                    {"type": "warning", "time_s": self._at_s, "text": text, "log": text}
                )
            if seek is not None or now_s - stated_s >= STATE_EVERY_S or not self._playing:
                stated_s = now_s
                self.stream.publish_newest(self._state())

    def _jump(self, at_s: float) -> None:
        recording = self._recording
        self._at_s = at_s
        self.stream.publish_story(recording.story(at_s))
        strip = recording.strip(0.0, at_s, fresh=True)
        if strip is not None:
            self.stream.publish_strip(strip)
        self._show(-1.0, at_s)

    def _advance(self, step_s: float) -> None:
        recording, before_s = self._recording, self._at_s
        at_s = min(before_s + step_s, recording.duration_s)
        if self._skip:
            following_s = recording.next_s(before_s)
            if following_s is not None and following_s > before_s + GAP_S:
                at_s = max(at_s, following_s - GAP_S / 2)
        self._at_s = at_s
        for message in recording.between(before_s, at_s):
            self.stream.publish(message)
        strip = recording.strip(before_s, at_s, fresh=False)
        if strip is not None:
            self.stream.publish_strip(strip)
        self._show(before_s, at_s)
        if at_s >= recording.duration_s:
            self._playing = False

    def _show(self, after_s: float, to_s: float) -> None:
        picture = self._recording.picture(after_s, to_s)
        if picture is not None:
            self._frame_pipeline.put(picture)
        stored = self._recording.stored_curve(after_s, to_s)
        if stored is not None:  # at once; what is found in the image again may follow
            self.stream.publish_newest(stored)

    def _state(self) -> Message:
        return {
            "type": "replay",
            "session": self._recording.name,
            "duration_s": self._recording.duration_s,
            "at_s": self._at_s,
            "playing": self._playing,
            "speed": self._speed,
            "skip": self._skip,
        }
