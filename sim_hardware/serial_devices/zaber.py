"""A Zaber rotary stage that carries the load cell along the arc.

Modelled on an X-RSW60A-E03 with firmware 6: 64 microsteps a step, 0.000234375 degrees a microstep,
one axis. Speeds are set in microsteps/s times 1.6384, accelerations in microsteps/s^2 times
1.6384/10000, as the protocol's manual has it. Like the real one it does not know where it is after
power-up (warning WR) until it is homed, and rejects movements until then.
"""

from __future__ import annotations

from collections.abc import Callable

from drivers.interfaces import Clock
from sim_hardware.serial_devices.axis import MICROSTEP_RAD, Axis
from sim_hardware.serial_devices.contract import ArcWorld, SimulatedSerial
from sim_hardware.serial_devices.zaber_settings import SPEED_UNIT, Settings
from sim_hardware.serial_devices.zaber_text import ZaberCommand, message, number

# The gravest first; a reply shows the first that is up.
_WARNINGS = ("FS", "WR", "NI")


class RejectedError(Exception):
    """A command that the device refuses; the text is the reason it gives."""


class SimulatedZaberStage:
    """The stage as a line-protocol state machine.

    The angle 0, where it homes to, is `origin_m` on the arc. The world gets a new position when a
    movement has ended, at the next command or poll.
    """

    baudrate = 115200

    def __init__(
        self,
        world: ArcWorld,
        clock: Clock,
        *,
        origin_m: float = 0.0,
        power_up_angle_rad: float = 0.3,
        homed: bool = False,
    ) -> None:
        offset = 0.0 if homed else power_up_angle_rad / MICROSTEP_RAD
        self.axis = Axis(world, clock, origin_m, offset)
        if not homed:
            self.axis.warnings.add("WR")
        self.settings = Settings()
        self._received = ""
        self._commands: dict[str, Callable[[ZaberCommand], str]] = {
            "get": self._get,
            "set": self._set,
            "home": self._home,
            "move": self._move,
            "stop": self._stop,
            "estop": self._estop,
            "warnings": self._list_warnings,
            "renumber": self._renumber,
            "tools": self._tools,
            "system": self._system,
        }

    def respond(self, data: bytes) -> bytes:
        """See `SerialDevice.respond`."""
        text = self._received + data.decode("ascii", "replace").replace("\r", "\n")
        *lines, self._received = text.split("\n")
        alert = self.poll()
        return alert + b"".join(self._answer(line) for line in lines)

    def poll(self) -> bytes:
        """Return the alert that a movement has ended, if alerts are on."""
        if not self.axis.settle() or not self.settings["comm.alert"]:
            return b""
        return self._say("!", f"1 IDLE {self._gravest()}")

    # ------------------------------------------------------------------------------- conversation

    def _answer(self, line: str) -> bytes:
        command = ZaberCommand.parse(line)
        if command is None or command.device not in (0, self.settings["comm.address"]):
            return b""
        try:
            flag, data = "OK", self._execute(command)
        except RejectedError as reason:
            flag, data = "RJ", str(reason)
        if command.identifier == "--":
            return b""
        identifier = f"{command.identifier} " if command.identifier is not None else ""
        state = "BUSY" if self.axis.moving else "IDLE"
        return self._say("@", f"{command.axis} {identifier}{flag} {state} {self._gravest()} {data}")

    def _say(self, kind: str, rest: str) -> bytes:
        body = f"{self.settings['comm.address']:02d} {rest}"
        return message(kind, body, checked=bool(self.settings["comm.checksum"]))

    def _execute(self, command: ZaberCommand) -> str:
        if command.axis not in (0, 1):
            raise RejectedError("BADAXIS")
        if not command.words:
            return "0"
        handler = self._commands.get(command.words[0])
        if handler is None:
            raise RejectedError("BADCOMMAND")
        return handler(command)

    def _gravest(self) -> str:
        return next((flag for flag in _WARNINGS if flag in self.axis.warnings), "--")

    # ----------------------------------------------------------------------------------- settings

    def _get(self, command: ZaberCommand) -> str:
        name = self._setting_name(command, 2)
        if name == "pos":
            return str(round(self.axis.counted))
        return f"{self.settings[name]:.10g}"

    def _set(self, command: ZaberCommand) -> str:
        name = self._setting_name(command, 3)
        value = _whole(command, 2)
        if name == "pos":
            self.axis.count_from(value)
            self.axis.warnings.discard("WR")
            return "0"
        try:
            self.settings.write(name, value)
        except KeyError:
            raise RejectedError("BADCOMMAND") from None
        except ValueError:
            raise RejectedError("BADDATA") from None
        return "0"

    def _setting_name(self, command: ZaberCommand, words: int) -> str:
        name = command.words[1] if len(command.words) == words else ""
        try:
            device_only = name != "pos" and self.settings.is_device_only(name)
        except KeyError:
            raise RejectedError("BADCOMMAND") from None
        if device_only and command.axis != 0:
            raise RejectedError("DEVICEONLY")
        return name

    def _renumber(self, command: ZaberCommand) -> str:
        _device_only(command)
        try:
            self.settings.write("comm.address", _whole(command, 1) if command.words[1:] else 1)
        except ValueError:
            raise RejectedError("BADDATA") from None
        return "0"

    def _list_warnings(self, command: ZaberCommand) -> str:
        up = [flag for flag in _WARNINGS if flag in self.axis.warnings]
        if command.words[1:] == ("clear",):
            self.axis.warnings &= {"WR"}  # only homing helps against that
        elif command.words[1:]:
            raise RejectedError("BADCOMMAND")
        return " ".join([f"{len(up):02d}", *up])

    def _tools(self, command: ZaberCommand) -> str:
        _device_only(command)
        if command.words[1:2] != ("echo",):
            raise RejectedError("BADCOMMAND")
        return " ".join(command.words[2:]) or "0"

    def _system(self, command: ZaberCommand) -> str:
        _device_only(command)
        if command.words[1:] != ("reset",):
            raise RejectedError("BADCOMMAND")
        self.axis.count_from(0)
        self.axis.warnings = {"WR"}
        self.settings = Settings()
        return "0"

    # ----------------------------------------------------------------------------------- movement

    def _home(self, command: ZaberCommand) -> str:
        if command.words[1:]:
            raise RejectedError("BADCOMMAND")
        self.axis.home(self.settings.homing_speed, self.settings.acceleration)
        return "0"

    def _move(self, command: ZaberCommand) -> str:
        mode = command.words[1] if len(command.words) > 1 else ""
        if mode in ("min", "max") and len(command.words) == 2:
            value = 0
        elif mode in ("abs", "rel", "vel"):
            value = _whole(command, 2)
        else:
            raise RejectedError("BADCOMMAND")
        if "WR" in self.axis.warnings:
            raise RejectedError("BADDATA")
        low, high = self.settings["limit.min"], self.settings["limit.max"]
        if mode == "vel":
            if value == 0:
                return self._stop(command)
            self._go(high if value > 0 else low, abs(value) / SPEED_UNIT)
            return "0"
        here = round(self.axis.counted)
        target = {"min": low, "max": high, "abs": value, "rel": here + value}[mode]
        if not low <= target <= high:
            raise RejectedError("BADDATA")
        self._go(target, self.settings.speed)
        return "0"

    def _go(self, target: float, speed: float) -> None:
        self.axis.go(target, speed, self.settings.acceleration)

    def _stop(self, _command: ZaberCommand) -> str:
        self.axis.brake(self.settings.acceleration)
        return "0"

    def _estop(self, _command: ZaberCommand) -> str:
        self.axis.halt()
        return "0"


def _whole(command: ZaberCommand, index: int) -> int:
    """Return a command's word as a whole number."""
    if len(command.words) != index + 1:
        raise RejectedError("BADDATA")
    value = number(command.words[index])
    if value is None:
        raise RejectedError("BADDATA")
    return value


def _device_only(command: ZaberCommand) -> None:
    if command.axis != 0:
        raise RejectedError("DEVICEONLY")


# It has been homed: an unhomed one refuses to move.
SERIAL_DEVICE = SimulatedSerial(
    "stage", lambda world, clock, _seed: SimulatedZaberStage(world, clock, homed=True)
)
