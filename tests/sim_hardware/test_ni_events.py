"""Event streams: every N samples, and the end."""

from __future__ import annotations

import threading
from typing import Any

import pytest
from nidaqmx.constants import AcquisitionType
from nidaqmx.errors import DaqError

FINITE, CONTINUOUS = AcquisitionType.FINITE, AcquisitionType.CONTINUOUS


class Listener:
    """Remembers what it was told, and when; may do something each time."""

    def __init__(self, ni: Any, then: Any = lambda: None) -> None:
        self.told: list[tuple[float, int]] = []
        self._ni = ni
        self._then = then
        self._came = threading.Semaphore(0)

    def samples(self, _task: object, _kind: int, count: int, _data: object) -> int:
        self.told.append((self._ni.clock.now(), count))
        self._then()
        self._came.release()
        return 0

    def done(self, _task: object, status: int, _data: object) -> int:
        self.told.append((self._ni.clock.now(), status))
        self._came.release()
        return 0

    def wait(self, times: int) -> None:
        for _ in range(times):
            assert self._came.acquire(timeout=10), f"only {len(self.told)} events came"


def clocked(ni: Any, mode: AcquisitionType, samples: int = 1000, rate: float = 10_000) -> Any:
    task = ni.input("PCI6034E/ai0")
    task.timing.cfg_samp_clk_timing(rate, sample_mode=mode, samps_per_chan=samples)
    return task


@pytest.mark.alone
def test_a_finite_acquisition_tells_of_each_block_and_of_its_end(ni: Any) -> None:
    blocks, end = Listener(ni), Listener(ni)
    task = clocked(ni, FINITE)
    task.register_every_n_samples_acquired_into_buffer_event(100, blocks.samples)
    task.register_done_event(end.done)
    start_s = ni.clock.now()
    task.start()
    ni.pass_time(0.15)
    blocks.wait(10)
    end.wait(1)
    assert [count for _, count in blocks.told] == [100] * 10
    assert [status for _, status in end.told] == [0]
    for k, (when, _) in enumerate(blocks.told):
        assert -1e-9 <= when - start_s - (k + 1) * 0.01 + 1e-4 < (0.05 if ni.tcp else 1e-9)


@pytest.mark.slow
def test_it_does_so_again_at_each_start(ni: Any) -> None:
    blocks, end = Listener(ni), Listener(ni)
    task = ni.input()
    task.register_done_event(end.done)  # events may be registered before the clock is set
    task.register_every_n_samples_acquired_into_buffer_event(200, blocks.samples)
    task.timing.cfg_samp_clk_timing(10_000, samps_per_chan=1000)
    for _ in range(3):
        task.start()
        ni.pass_time(0.11)
        end.wait(1)
        blocks.wait(5)
        task.stop()
    assert (len(blocks.told), len(end.told)) == (15, 3)


def test_a_callback_may_read(ni: Any) -> None:
    task = clocked(ni, CONTINUOUS)
    task.in_stream.auto_start = False
    lengths: list[int] = []
    listener = Listener(ni, then=lambda: lengths.append(len(task.read(100))))
    task.register_every_n_samples_acquired_into_buffer_event(100, listener.samples)
    task.start()
    ni.pass_time(0.0555)
    listener.wait(5)
    task.stop()
    assert lengths[:5] == [100] * 5


def test_time_stands_still_while_a_callback_works(make_ni: Any) -> None:
    ni = make_ni(tcp=False)
    task = clocked(ni, CONTINUOUS)
    available: list[int] = []

    def look() -> None:
        threading.Event().wait(0.01)  # real time, while virtual time must not pass
        available.append(task.in_stream.avail_samp_per_chan)
        task.read(100)

    listener = Listener(ni, then=look)
    task.register_every_n_samples_acquired_into_buffer_event(100, listener.samples)
    task.start()
    ni.pass_time(0.1)
    task.stop()
    assert available == [100] * 10


def test_nothing_is_told_once_it_is_unregistered_or_stopped(ni: Any) -> None:
    listener = Listener(ni)
    task = clocked(ni, CONTINUOUS)
    task.register_every_n_samples_acquired_into_buffer_event(100, listener.samples)
    task.register_every_n_samples_acquired_into_buffer_event(100, None)
    task.start()
    ni.pass_time(0.03)
    task.stop()
    assert listener.told == []
    task.register_every_n_samples_acquired_into_buffer_event(100, listener.samples)
    task.start()
    task.stop()
    ni.pass_time(0.03)
    # over a connection on a busy computer 10 ms may pass before it stops, and be told
    before_it_stopped = list(listener.told)
    ni.pass_time(0.03)
    assert listener.told == before_it_stopped


@pytest.mark.slow
def test_the_end_of_a_task_that_overflows_is_told_with_the_error(ni: Any) -> None:
    listener = Listener(ni)
    task = clocked(ni, CONTINUOUS)
    task.in_stream.input_buf_size = 2000
    task.register_done_event(listener.done)
    start_s = ni.clock.now()
    task.start()
    ni.pass_time(0.03)
    task.read(200)  # puts it off
    ni.pass_time(0.2)
    listener.wait(1)
    ((when, status),) = listener.told
    assert status == -200279
    assert when - start_s >= 0.22


def test_a_stream_ends_when_its_task_is_cleared(ni: Any) -> None:
    before = threading.active_count()
    task = clocked(ni, CONTINUOUS)
    task.register_every_n_samples_acquired_into_buffer_event(100, lambda *_: 0)
    task.register_done_event(lambda *_: 0)
    handlers = [handler._thread for handler in task._event_handlers.values()]
    assert len(handlers) == 2
    task.close()
    assert not any(thread.is_alive() for thread in handlers)
    assert threading.active_count() <= before + 4  # the server's idle workers


@pytest.mark.parametrize(
    ("provoke", "code"),
    [
        (lambda t: t.register_every_n_samples_acquired_into_buffer_event(0, print), -200880),
        (lambda t: t.register_every_n_samples_acquired_into_buffer_event(10, print), -200966),
        (lambda t: t.register_every_n_samples_transferred_from_buffer_event(9, print), -200980),
        (lambda t: t.register_done_event(print), -200950),
        (lambda t: (t.start(), t.register_done_event(print)), -200960),
        (lambda t: (t.start(), t.register_done_event(None)), -200986),
    ],
)
def test_registrations_that_make_no_sense_are_refused(ni: Any, provoke: Any, code: int) -> None:
    task = clocked(ni, FINITE)
    task.register_done_event(lambda *_: 0)
    if code == -200966:
        task.register_every_n_samples_acquired_into_buffer_event(10, lambda *_: 0)
    with pytest.raises(DaqError) as fault:
        provoke(task)
    assert fault.value.error_code == code


def test_an_event_that_needs_a_buffer_is_refused_without_one(ni: Any) -> None:
    task = ni.input()
    task.register_every_n_samples_acquired_into_buffer_event(10, lambda *_: 0)
    with pytest.raises(DaqError) as fault:
        task.start()
    assert fault.value.error_code == -200848
    output = ni.output()
    with pytest.raises(DaqError) as fault:
        output.register_every_n_samples_acquired_into_buffer_event(10, lambda *_: 0)
    assert fault.value.error_code == -200981


@pytest.mark.slow
def test_ninety_open_streams_starve_nobody(make_ni: Any) -> None:
    ni = make_ni(tcp=True)
    tasks = [ni.task(f"listener {k}") for k in range(90)]
    for task in tasks:
        task.register_done_event(lambda *_: 0)
    ni.output().write(1.0)
    assert ni.input().read() == pytest.approx(1.0, abs=2e-3)
