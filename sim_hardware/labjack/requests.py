"""Modbus TCP requests: read registers (3, 4), write them (6, 16), LabJack's feedback (76)."""

from __future__ import annotations

import struct

from sim_hardware.labjack import refusal
from sim_hardware.labjack.device import SimulatedLabJack
from sim_hardware.labjack.refusal import RefusedError

HEAD = struct.Struct(">HHHB")  # transaction, protocol 0, length, unit
STREAM_DATA = 4500
LONGEST = 1040  # bytes of a packet


def answer(device: SimulatedLabJack, request: bytes) -> bytes:
    """Return the answer to a whole request."""
    number, _, _, unit = HEAD.unpack_from(request)
    pdu = request[HEAD.size :]
    device.heard()
    try:
        reply = bytes([pdu[0]]) + _reply(device, pdu)
    except RefusedError as refused:
        device.note(refused.detail)
        reply = bytes([pdu[0] | 0x80, refused.code])
    except (struct.error, IndexError):
        device.note(refusal.WRONG_SIZE)
        reply = bytes([pdu[0] | 0x80, refusal.ILLEGAL_VALUE])
    if device.faults.garbage:
        number ^= 0x5A5A
    return HEAD.pack(number, 0, len(reply) + 1, unit) + reply


def asks_for_stream(request: bytes) -> bool:
    """Whether a request reads the stream's data."""
    pdu = request[HEAD.size :]
    return len(pdu) >= 3 and pdu[0] in (3, 4) and struct.unpack_from(">H", pdu, 1)[0] == STREAM_DATA


def _reply(device: SimulatedLabJack, pdu: bytes) -> bytes:
    function = pdu[0]
    if function in (3, 4):
        address, registers = struct.unpack(">HH", pdu[1:])
        if not 0 < registers <= 127:
            raise RefusedError(refusal.ILLEGAL_VALUE, refusal.WRONG_SIZE)
        data = device.read(address, registers)
        return bytes([len(data)]) + data
    if function == 6:
        address = struct.unpack(">H", pdu[1:3])[0]
        device.write(address, pdu[3:5])
        return pdu[1:5]
    if function == 16:
        address, registers, size = struct.unpack(">HHB", pdu[1:6])
        if size != 2 * registers or len(pdu) != 6 + size:
            raise RefusedError(refusal.ILLEGAL_VALUE, refusal.WRONG_SIZE)
        device.write(address, pdu[6:])
        return pdu[1:5]
    if function == 76:
        return _feedback(device, pdu[1:])
    raise RefusedError(refusal.ILLEGAL_FUNCTION, 0)


def _feedback(device: SimulatedLabJack, frames: bytes) -> bytes:
    """Do the frames in their order; what is read is the answer."""
    found = b""
    while frames:
        kind, address, registers = struct.unpack_from(">BHB", frames)
        frames = frames[4:]
        if kind == 0:
            found += device.read(address, registers)
        elif kind == 1 and len(frames) >= 2 * registers:
            device.write(address, frames[: 2 * registers])
            frames = frames[2 * registers :]
        else:
            raise RefusedError(refusal.ILLEGAL_VALUE, refusal.WRONG_SIZE)
    if len(found) > LONGEST:
        raise RefusedError(refusal.ILLEGAL_VALUE, 2300)
    return found
