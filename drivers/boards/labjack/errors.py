"""What a LabJack's refusals mean, as `DeviceError`s."""

from __future__ import annotations

from drivers.interfaces import DeviceError


class OutputTakenError(DeviceError):
    """Somebody else has taken the output, or has made it safe: the guard, or `labrig safe`."""


# Codes of LabJack's published list that labrig can cause; others keep their number.
_MEANINGS = {
    2370: "the input has no such range",
    2373: "the inputs are no pair; take an even input and the next one",
    2501: "the line is set to analog",
    2605: "a stream runs already; `labrig safe` stops it when its program is gone",
    2607: "one of the inputs cannot be streamed",
    2608: "the sample rate is too great for so many inputs at these ranges",
    2615: "the stream's buffer has a size that is not possible",
    2620: "no stream runs",
    2671: "the watchdog runs; it must be stopped first",
    2762: "there is no such output",
    2764: "the LJTick-DAC does not answer; check that it sits where [labjack] drive says",
}
_CODES = {
    1: "it does not know this request",
    2: "there is no such register",
    3: "the value is not possible",
    4: "the device has failed",
    6: "the device is busy",
}


def refused(doing: str, where: str, code: int, detail: int) -> DeviceError:
    """Return the error for a Modbus exception; `detail`: LabJack's own code, 0: none."""
    why = _MEANINGS.get(detail) or _CODES.get(code, "it gives no reason")
    number = f"LabJack error {detail}" if detail else f"Modbus exception {code}"
    return DeviceError(f"{doing} failed: {where} refuses it: {why} ({number})")
