"""Images on their way to pages: each is acknowledged before the next is sent."""

from __future__ import annotations

import asyncio
import json
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from drivers.interfaces import Frame, RealClock
from labrig.panel.core.sockets import Post, receive_messages, together
from labrig.panel.live.event_stream import EventStream
from labrig.panel.live.frames import exposure_time, raw_picture
from labrig.panel.live.packing import unpack

PATIENCE_S = 5.0


class FakeSocket:
    """A page's socket; `slow` makes each send take as long as the page likes."""

    def __init__(self):
        self.texts, self.images, self.closed = [], [], None
        self.open = asyncio.Event()
        self.open.set()
        self.incoming = asyncio.Queue()

    async def send_text(self, text):
        await self.open.wait()
        self.texts.append(json.loads(text))

    async def send_bytes(self, packed):
        await self.open.wait()
        self.images.append(unpack(packed)[0])

    async def receive(self):
        return {"type": "websocket.receive", "text": await self.incoming.get()}

    async def close(self, code, _reason):
        self.closed = code

    def say(self, **message):
        self.incoming.put_nowait(json.dumps(message))

    def seen(self):
        """Acknowledge the last image."""
        self.say(do="seen", image=self.images[-1]["image"])


class Served:
    """A page with its socket served until the block ends."""

    def __init__(self, stream):
        self.socket = FakeSocket()
        self.post = Post(self.socket, stream)

    async def __aenter__(self):
        async def nothing(_message):
            pass

        listening = receive_messages(self.socket, self.post, nothing)
        self.task = asyncio.ensure_future(together(self.post.deliver(), listening))
        return self.socket

    async def __aexit__(self, *_):
        self.task.cancel()
        await asyncio.gather(self.task, return_exceptions=True)
        self.post.close()


def run(coroutine):
    """Run it in a thread: a test of the browser in the same process has a loop of its own."""
    with ThreadPoolExecutor(1) as pool:
        pool.submit(asyncio.run, coroutine).result()


def shown(stream, frame):
    stream.publish_picture(({"type": "picture", "frame": frame}, b"pixels"))


async def until(condition):
    end_s = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end_s, "it did not come about"
        await asyncio.sleep(0.002)


async def settled():
    """For whatever must not happen."""
    await asyncio.sleep(0.1)


def numbers(socket):
    return [image["frame"] for image in socket.images]


@pytest.mark.parametrize("steps", range(6))
def test_a_page_that_goes_while_something_is_sent_leaves_nothing_that_waits(steps):
    async def page():
        stream = EventStream()
        served = Served(stream)
        async with asyncio.timeout(PATIENCE_S):
            async with served as socket:
                socket.open.clear()
                shown(stream, 1)
                await settled()
                socket.open.set()
                for _ in range(steps):
                    await asyncio.sleep(0)

    run(page())


def test_a_page_that_acknowledges_nothing_gets_one_image():
    async def page():
        stream = EventStream()
        async with Served(stream) as socket:
            for frame in range(20):
                shown(stream, frame)
                await until(lambda: socket.images)
            await settled()
            assert numbers(socket) == [0]

    run(page())


def test_after_an_acknowledgement_the_newest_image_is_sent_and_none_before_it():
    async def page():
        stream = EventStream()
        async with Served(stream) as socket:
            for count in (1, 2, 3):
                for frame in range(10 * count - 10, 10 * count):
                    shown(stream, frame)
                if count > 1:
                    socket.seen()
                await until(lambda count=count: len(socket.images) == count)
            assert numbers(socket) == [9, 19, 29]

    run(page())


def test_no_image_is_sent_twice():
    async def page():
        stream = EventStream()
        async with Served(stream) as socket:
            shown(stream, 1)
            await until(lambda: socket.images)
            socket.seen()
            socket.seen()
            await settled()
            assert numbers(socket) == [1]
            shown(stream, 2)
            await until(lambda: len(socket.images) == 2)

    run(page())


def test_a_foreign_acknowledgement_brings_no_image():
    async def page():
        stream = EventStream()
        async with Served(stream) as socket:
            shown(stream, 1)
            await until(lambda: socket.images)
            for image in (None, "1", socket.images[0]["image"] + 1, -1, [1], {}):
                socket.say(do="seen", image=image)
            shown(stream, 2)
            await settled()
            assert numbers(socket) == [1]

    run(page())


def test_a_slow_page_delays_no_other():
    async def pages():
        stream = EventStream()
        async with Served(stream) as slow, Served(stream) as quick:
            slow.open.clear()  # it takes nothing at all
            for frame in range(30):
                shown(stream, frame)
                await until(lambda frame=frame: numbers(quick)[-1:] == [frame])
                quick.seen()
            assert numbers(quick) == list(range(30))
            assert numbers(slow) == []
            slow.open.set()
            await until(lambda: slow.images)
            slow.seen()
            await until(lambda: len(slow.images) == 2)
            assert numbers(slow)[-1] == 29  # of what it missed only the newest

    run(pages())


def test_messages_do_not_wait_for_an_acknowledgement():
    async def page():
        stream = EventStream()
        async with Served(stream) as socket:
            shown(stream, 1)
            await until(lambda: socket.images)
            stream.publish({"type": "output", "state": "safe"})
            await until(lambda: socket.texts[-1]["type"] == "output")

    run(page())


def test_an_image_comes_after_the_story_that_it_belongs_to():
    async def page():
        stream = EventStream()
        async with Served(stream) as socket:
            await until(lambda: socket.texts)
            socket.open.clear()
            stream.publish_story([{"type": "started"}])
            shown(stream, 1)
            await settled()
            order = []
            socket.send_text = lambda text: note(order, json.loads(text)["type"])
            socket.send_bytes = lambda packed: note(order, unpack(packed)[0]["type"])
            socket.open.set()
            stream.publish_story([{"type": "started"}])
            shown(stream, 2)
            await until(lambda: "picture" in order)
            assert order.index("story") < order.index("picture")

    async def note(order, what):
        order.append(what)

    run(page())


@pytest.mark.slow
def test_acknowledgements_are_never_too_often_but_other_messages_are():
    async def page():
        stream = EventStream()
        async with Served(stream) as socket:
            for frame in range(100):
                shown(stream, frame)
                await until(lambda frame=frame: numbers(socket)[-1:] == [frame])
                socket.seen()
            await settled()
            assert socket.closed is None
            for _ in range(100):
                socket.say(do="seen", image=0)  # nobody has waited for them
            await until(lambda: socket.closed == 1008)

    run(page())


def test_a_pong_tells_the_servers_time():
    async def page():
        async with Served(EventStream()) as socket:
            before_s = time.time()
            socket.say(do="ping", at=12.5)
            await until(lambda: any(text["type"] == "pong" for text in socket.texts))
            pong = next(text for text in socket.texts if text["type"] == "pong")
            assert pong["at"] == 12.5
            assert before_s <= pong["wall_s"] <= time.time()

    run(page())


def test_an_image_carries_the_time_of_its_exposure_by_the_servers_clock():
    clock = RealClock()
    taken_s = clock.now() - 0.25
    frame = Frame(number=3, time_s=taken_s, device_time_s=None, image=np.zeros((4, 6), np.uint8))
    exposed_s = exposure_time(clock, frame.time_s)
    assert exposed_s == pytest.approx(time.time() - 0.25, abs=0.05)
    header, _ = raw_picture(frame, 1.0, None, None, exposed_s=exposed_s)
    assert header["exposed_s"] == exposed_s


def test_on_a_virtual_clock_the_exposure_has_no_time_of_day():
    class Virtual:
        def now(self):
            return 5.0

    assert exposure_time(Virtual(), 4.0) is None
