import socket
import threading
import time
from ctypes.util import find_library

import grpc
import pytest
from nidaqmx._stubs import nidaqmx_pb2 as messages

from drivers.boards.ni import deadlines as ni_deadlines
from drivers.boards.ni.connection import NiConnection
from drivers.boards.ni.deadlines import QUICK_S, SLOW_S, deadline_s
from drivers.interfaces import DeviceError, DeviceNotFoundError, DeviceTimeoutError


@pytest.mark.parametrize(
    ("name", "request_", "expected"),
    [
        ("ReadAnalogF64", messages.ReadAnalogF64Request(timeout=7.5), QUICK_S + 7.5),
        ("WaitUntilTaskDone", messages.WaitUntilTaskDoneRequest(time_to_wait=3.0), QUICK_S + 3.0),
        ("WriteAnalogScalarF64", messages.WriteAnalogScalarF64Request(timeout=-1.0), QUICK_S),
        ("StartTask", messages.StartTaskRequest(), SLOW_S),
        ("GetTaskAttributeString", messages.GetTaskAttributeStringRequest(), QUICK_S),
    ],
)
def test_a_deadline_is_what_the_request_may_take_plus_the_servers_share(name, request_, expected):
    assert deadline_s(f"/nidaqmx_grpc.NiDAQmx/{name}", request_) == expected


@pytest.mark.parametrize("address", ["rig", "rig:", "rig:0", "rig:70000", "http://rig:1", ""])
def test_an_address_that_is_none_is_refused(address):
    with pytest.raises(DeviceNotFoundError, match=r"host:port"):
        NiConnection(address)


def test_a_port_where_nobody_listens_is_said_so_at_once():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    began = time.perf_counter()
    with pytest.raises(DeviceNotFoundError, match=f"no connection to .* 127.0.0.1:{port}"):
        NiConnection(f"127.0.0.1:{port}").open()
    assert time.perf_counter() - began < 2.0


@pytest.mark.slow
def test_a_server_that_accepts_and_never_answers_does_not_hang_us(monkeypatch):
    monkeypatch.setattr(ni_deadlines, "QUICK_S", 0.3)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        kept = []
        threading.Thread(target=lambda: kept.append(silent.accept()), daemon=True).start()
        began = time.perf_counter()
        with pytest.raises((DeviceTimeoutError, DeviceNotFoundError)):
            NiConnection(f"127.0.0.1:{silent.getsockname()[1]}").open()
        assert time.perf_counter() - began < 1.5
        for connection, _ in kept:
            connection.close()


@pytest.mark.skipif(find_library("nidaqmx") is not None, reason="this computer has the driver")
def test_without_a_driver_the_local_address_tells_what_to_install():
    with pytest.raises(DeviceNotFoundError, match=r"install it from ni\.com"):
        NiConnection("local").open()


def test_a_connection_that_is_not_open_is_said_so():
    with pytest.raises(DeviceError, match="not open"):
        NiConnection("rig:31763").devices()


def test_a_server_that_let_a_call_run_out_of_time_gets_less_until_it_answers():
    given = []

    class Call:
        def __init__(self, code):
            self._code = code

        def add_done_callback(self, call):
            call(self)

        def code(self):
            return self._code

    answers = iter([grpc.StatusCode.DEADLINE_EXCEEDED] * 2 + [grpc.StatusCode.OK] * 2)

    def continuation(details, _request):
        given.append(details.timeout)
        return Call(next(answers))

    interceptor = ni_deadlines.DeadlineInterceptor()
    details = ni_deadlines._CallDetails(
        method="/nidaqmx_grpc.NiDAQmx/CreateTask",
        timeout=None,
        metadata=None,
        credentials=None,
        wait_for_ready=None,
        compression=None,
    )
    for _ in range(4):
        interceptor.intercept_unary_unary(continuation, details, object())
    hurried = ni_deadlines.HURRIED_SLOW_S
    assert given == [SLOW_S, hurried, hurried, SLOW_S]
