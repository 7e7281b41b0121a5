"""Calls about a device, a status code or the whole server."""

from __future__ import annotations

import session_pb2
from nidaqmx._stubs import nidaqmx_pb2 as pb

from sim_hardware.ni.errors import error_string
from sim_hardware.ni.rpc import Call, Message
from sim_hardware.ni.tasks.engine import Engine


def reset_device(engine: Engine, request: Message, _call: Call) -> Message:
    """Abort the tasks on a board; its outputs keep their voltage."""
    engine.reset_device(request.device_name)
    return pb.ResetDeviceResponse()


def self_test_device(engine: Engine, request: Message, _call: Call) -> Message:
    """Every simulated board passes."""
    engine.devices.find(request.device_name)
    return pb.SelfTestDeviceResponse()


def get_error_string(_engine: Engine, request: Message, _call: Call) -> Message:
    """Return the text of a status code."""
    return pb.GetErrorStringResponse(error_string=error_string(request.error_code))


def enumerate_devices(engine: Engine, _request: Message, _call: Call) -> Message:
    """List the boards, as the server's own service does."""
    devices = [
        session_pb2.DeviceProperties(
            name=device.name,
            model=device.board.product_type,
            vendor="National Instruments",
            serial_number=f"{device.serial_number:08X}",
            product_id=device.board.product_number or 0,
        )
        for device in engine.devices
    ]
    return session_pb2.EnumerateDevicesResponse(devices=devices)


def reset_server(engine: Engine, _request: Message, _call: Call) -> Message:
    """Clear every task of every client; outputs keep their voltage."""
    for task in engine.sessions.all():
        engine.clear(task)
    return session_pb2.ResetServerResponse(is_server_reset=True)


HANDLERS = {
    "ResetDevice": reset_device,
    "SelfTestDevice": self_test_device,
    "GetErrorString": get_error_string,
}
SESSION_HANDLERS = {"EnumerateDevices": enumerate_devices, "ResetServer": reset_server}
