"""What is known of a job so far, and mailboxes for its subscribers.

The same on both sides of a job connection: the job keeps a stream for panels, a panel keeps one for
pages. No subscriber holds up a publisher: a mailbox has a bound, and one slot for each kind of
message of which only the newest counts. A subscriber that falls behind gets the whole story again.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from labrig.panel.live.strip_chart import StripChart, joined, newest_of_each

Message = dict[str, Any]
Picture = tuple[Message, bytes]  # header, and whatever the picture is packed as

MOST_WAITING = 2000  # messages; more than a minute of any run
MOST_STORY = 200_000  # beyond this the oldest single voltages are left out
CURVE, MOTION, ESTIMATES = "curve", "motion", "estimates"
_OF_JOB = (CURVE, MOTION, ESTIMATES)  # newest messages that go with a story


@dataclass(frozen=True, kw_only=True)
class Mail:
    """What a follower is given: in this order, each part perhaps empty."""

    story: list[Message] | None = None  # forget everything, this is what happened so far
    messages: list[Message] = field(default_factory=list)
    strip: StripChart | None = None
    newest: list[Message] = field(default_factory=list)  # of each kind only the last one


class Mailbox:
    """Hold messages of an `EventStream` for one client; `wake` is called when one arrives."""

    def __init__(self, wake: Callable[[], None], most: int = MOST_WAITING) -> None:
        self._wake = wake
        self._most = most
        self._lock = threading.Lock()
        self._story: list[Message] | None = None
        self._messages: list[Message] = []
        self._strips: list[StripChart] = []
        self._newest: dict[str, Message] = {}
        self._picture: Picture | None = None
        self.behind = False  # was full: its stream must send the whole story again

    def put(self, message: Message) -> None:
        """In order, after all others."""
        with self._lock:
            if len(self._messages) >= self._most:
                self.behind = True
                self._messages.clear()
            if not self.behind:
                self._messages.append(message)
        self._wake()

    def put_newest(self, message: Message) -> None:
        """In the place of the last one of its type."""
        with self._lock:
            self._newest[message["type"]] = message
        self._wake()

    def put_strip(self, strip: StripChart) -> None:
        """Behind the strips that wait; what is too much to wait is left out at the front."""
        with self._lock:
            self._strips = joined([*self._strips, strip])
        self._wake()

    def put_picture(self, picture: Picture) -> None:
        """In the place of the last one."""
        with self._lock:
            self._picture = picture
        self._wake()

    def begin(
        self,
        story: list[Message],
        strips: list[StripChart],
        newest: list[Message],
        picture: Picture | None,
    ) -> None:
        """Replace everything that waits."""
        with self._lock:
            self.behind = False
            self._story, self._messages = story, []
            self._strips, self._picture = list(strips), picture
            self._newest = {message["type"]: message for message in newest}
        self._wake()

    def take(self) -> Mail | None:
        """All that waits but the image; None when nothing does."""
        with self._lock:
            found = Mail(
                story=self._story,
                messages=self._messages,
                strip=self._strips.pop(0) if self._strips else None,
                newest=list(self._newest.values()),
            )
            self._story, self._messages, self._newest = None, [], {}
        return None if found == Mail() else found

    def take_picture(self) -> Picture | None:
        """Return the newest image if it has not been taken yet; never before its story."""
        with self._lock:
            if self._story is not None:
                return None
            picture, self._picture = self._picture, None
            return picture


class EventStream:
    """Publishers call `publish...`, subscribers join with a mailbox, each from any thread."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._story: deque[Message] = deque()
        self._strips: list[StripChart] = []
        self._newest: dict[str, Message] = {}
        self._picture: Picture | None = None
        self._pictures = 0  # so far
        self._boxes: list[Mailbox] = []

    def join(self, box: Mailbox) -> None:
        """Put the story so far into the mailbox, and then each new message."""
        with self._lock:
            self._boxes.append(box)
            self._retell(box)

    def leave(self, box: Mailbox) -> None:
        """Nothing more goes into it."""
        with self._lock:
            if box in self._boxes:
                self._boxes.remove(box)

    def publish(self, message: Message) -> None:
        """Publish one message to all subscribers."""
        with self._lock:
            self._story.append(message)
            if len(self._story) > MOST_STORY:
                self._shorten()
            for box in self._boxes:
                box.put(message)
                if box.behind:
                    self._retell(box)

    def publish_newest(self, message: Message) -> None:
        """Publish a message of which only the last one of its type counts."""
        with self._lock:
            self._newest[message["type"]] = message
            for box in self._boxes:
                box.put_newest(message)

    def publish_strip(self, strip: StripChart) -> None:
        """Signals."""
        with self._lock:
            self._strips = newest_of_each(joined([*self._strips, strip]))
            for box in self._boxes:
                box.put_strip(strip)

    def publish_picture(self, picture: Picture) -> None:
        """Publish an image in the place of the last one. Its header gets a number, `image`."""
        with self._lock:
            self._pictures += 1
            self._picture = picture = ({**picture[0], "image": self._pictures}, picture[1])
            for box in self._boxes:
                box.put_picture(picture)

    def publish_story(self, messages: list[Message]) -> None:
        """Replace the story: another job, or the same one found again."""
        with self._lock:
            self._story = deque(messages)
            self._strips, self._picture = [], None
            for kind in _OF_JOB:  # what else is newest is not the job's
                self._newest.pop(kind, None)
            for box in self._boxes:
                self._retell(box)

    def messages(self) -> list[Message]:
        """Return the story so far."""
        with self._lock:
            return list(self._story)

    def _retell(self, box: Mailbox) -> None:
        strips = [strip.as_fresh() for strip in self._strips]
        box.begin(list(self._story), strips, list(self._newest.values()), self._picture)

    def _shorten(self) -> None:
        """Drop old single voltages; keep what a page shows in numbers."""
        half = MOST_STORY // 2
        old = [m for i, m in enumerate(self._story) if i >= half or m["type"] != "voltage"]
        self._story = deque(old[-MOST_STORY:])
