import grpc
import pytest
from nidaqmx.errors import DaqError, DaqNotFoundError, RpcError

from drivers.boards.ni.errors import DeviceReservedError, TaskGoneError, ni_errors
from drivers.interfaces import (
    DeviceError,
    DeviceNotFoundError,
    DeviceTimeoutError,
    LimitError,
    LostSamplesError,
)

WHERE = "the NI gRPC Device Server at rig:31763"


def raised(fault: Exception, devices=("PCI6703", "PCI6034E")) -> DeviceError:
    with pytest.raises(DeviceError) as caught, ni_errors("opening X", WHERE, lambda: devices):
        raise fault
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith("opening X failed: ")
    return caught.value


@pytest.mark.parametrize(
    ("code", "family", "says"),
    [
        (-200220, DeviceNotFoundError, "devices found: PCI6703, PCI6034E"),
        (-200170, DeviceNotFoundError, "no such channel"),
        (-50103, DeviceReservedError, "labrig safe"),
        (-200088, TaskGoneError, "no longer exists"),
        (-200279, LostSamplesError, "overwritten"),
        (-200361, LostSamplesError, "memory overflowed"),
        (-200284, DeviceTimeoutError, "in time"),
        (-200561, LimitError, "nothing was written"),
        (-200077, DeviceError, "cannot do that"),
    ],
)
def test_a_status_code_becomes_its_family_and_a_sentence(code, family, says):
    error = raised(DaqError("NI's own words", code))
    assert type(error) is family
    assert says in str(error)
    assert str(code) in str(error)


def test_an_unknown_code_keeps_the_makers_words_on_one_line():
    error = raised(DaqError("Something odd\nhappened.\n\nTask Name: x", -299999))
    assert "Something odd happened." in str(error)
    assert "-299999" in str(error)


def test_no_devices_at_all_are_said_so():
    assert "devices found: none" in str(raised(DaqError("", -200220), devices=()))


def test_a_missing_driver_tells_what_to_install():
    error = raised(DaqNotFoundError("no lib"))
    assert isinstance(error, DeviceNotFoundError)
    assert "ni.com" in str(error)
    assert "host:port" in str(error)


@pytest.mark.parametrize(
    ("status", "family", "says"),
    [
        (grpc.StatusCode.UNAVAILABLE, DeviceNotFoundError, "no connection to"),
        (grpc.StatusCode.DEADLINE_EXCEEDED, DeviceTimeoutError, "did not answer"),
        (grpc.StatusCode.UNIMPLEMENTED, DeviceError, "upgrade"),
        (grpc.StatusCode.INTERNAL, DeviceError, "INTERNAL: why"),
    ],
)
def test_a_broken_connection_names_the_server(status, family, says):
    error = raised(RpcError(status, "why"))
    assert type(error) is family
    assert says in str(error)
    assert WHERE in str(error)


def test_a_closed_connection_is_said_so():
    assert "is closed" in str(raised(ValueError("Cannot invoke RPC on closed channel!")))


def test_other_faults_pass_unchanged():
    with pytest.raises(ValueError, match="mine"), ni_errors("x", WHERE):
        raise ValueError("mine")
