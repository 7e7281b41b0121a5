"""`python -m sim_hardware serve`: a whole simulated rig on this computer, until a signal ends it.

Prints one line for each address, then `ready`. Exit codes: 0 ended by a signal or by its input, 2
bad arguments or a bad world, 3 a port is taken.
"""

from __future__ import annotations

import argparse
import signal
import sys
import threading
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, NoReturn

from drivers.interfaces import Clock, RealClock
from sim_hardware.ni import LoopbackWires, NiDeviceServer, PortTakenError

if TYPE_CHECKING:
    from sim_hardware.faults import FaultyRig

BAD_ARGUMENTS, PORT_TAKEN = 2, 3
_POLL_S = 0.2  # Windows wakes no thread for Ctrl-C: poll
LINGER_S = 6.0  # after its input's end: the guard of a run that was killed still writes 0 V


class ArgumentFaultError(Exception):
    """Arguments that make no sense; one sentence."""


def main(arguments: Sequence[str]) -> int:
    """Serve; returns the exit code."""
    try:
        options = _parser().parse_args(arguments)
        _check(options)
        with ExitStack() as stack:
            end = _end_signal(stack)
            if options.end_with_input:
                threading.Thread(target=_follow_input, args=(end,), daemon=True).start()
            for line in _start(options, RealClock(), stack):
                _say(line)
            _say("ready")
            while not end.wait(_POLL_S):
                pass
    except ArgumentFaultError as fault:
        return _complain(str(fault), BAD_ARGUMENTS)
    except PortTakenError as fault:
        return _complain(str(fault), PORT_TAKEN)
    return 0


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """One sentence instead of the whole usage."""
        raise ArgumentFaultError(
            f"{message}; `python -m sim_hardware serve --help` lists the options"
        )


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="python -m sim_hardware")
    commands = parser.add_subparsers(dest="command", required=True, metavar="serve")
    serve = commands.add_parser("serve", help="serve a simulated rig")
    add = serve.add_argument
    add(
        "--port",
        type=_port,
        default=0,
        help="of the boards: the NI gRPC Device Server, or the LabJack (0: a free one)",
    )
    add("--camera-port", type=_port, default=0, help="of the camera's stream (0: a free one)")
    add("--world", type=Path, help="TOML file of the world (default: the shipped one)")
    add("--seed", type=int, help="instead of the world's")
    add("--configuration", help="of the sheet to mount, such as long or short")
    add("--record", type=Path, metavar="FILE.csv", help="write what really happens")
    add(
        "--wire",
        type=_wire,
        action="append",
        metavar="OUTPUT:INPUT",
        help="no world: a wire, such as ao0:ai0 (repeatable)",
    )
    add(
        "--boards",
        default="ni",
        metavar="FAMILY",
        help="the family of boards that the world has, such as labjack (default: ni)",
    )
    add(
        "--device",
        type=_device,
        action="append",
        metavar="NAME=MODEL",
        help="a board, such as PCI6703=PCI-6703 (repeatable; replaces the default boards)",
    )
    add(
        "--test-signals",
        action="store_true",
        help="with --wire: inputs without a wire show what NI's own simulated devices do, "
        "a sine between the channel's limits; lines that nobody writes count",
    )
    add(
        "--edges",
        type=_edges,
        action="append",
        metavar="TERMINAL=HZ",
        help="with --wire: a square wave at a terminal, such as Dev1/PFI0=2, that triggers wait "
        "for (repeatable)",
    )
    add(
        "--serial",
        action="append",
        metavar="KIND",
        help="a serial device, such as zaber (repeatable; default: all)",
    )
    add("--driver-version", default="26.0", help="that the server reports (default: 26.0)")
    add(
        "--strict-ownership",
        action="store_true",
        help="tasks belong to a connection and end with it, as with a local driver",
    )
    add(
        "--end-with-input",
        action="store_true",
        help=f"end {LINGER_S:g} s after standard input ends, as it does with its parent process",
    )
    return parser


def _port(text: str) -> int:
    if not text.isdecimal() or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"'{text}' is not a port (0 to 65535)")
    return int(text)


def _pair(text: str, separator: str, wanted: str) -> tuple[str, str]:
    left, found, right = text.partition(separator)
    if not (left and found and right):
        raise argparse.ArgumentTypeError(f"'{text}' is not {wanted}")
    return left, right


def _wire(text: str) -> tuple[str, str]:
    return _pair(text, ":", "OUTPUT:INPUT, such as ao0:ai0")


def _device(text: str) -> tuple[str, str]:
    return _pair(text, "=", "NAME=MODEL, such as PCI6703=PCI-6703")


def _edges(text: str) -> tuple[str, float]:
    wanted = "TERMINAL=HZ, such as Dev1/PFI0=2"
    name, rate = _pair(text, "=", wanted)
    try:
        return name, float(rate)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not {wanted}") from None


def _check(options: argparse.Namespace) -> None:
    """Options that make no sense together."""
    if not options.wire:
        if options.test_signals:
            raise ArgumentFaultError("--test-signals is for boards without a world: with --wire")
        if options.edges:
            raise ArgumentFaultError("--edges is for boards without a world: with --wire")
        return
    if options.boards != "ni":
        raise ArgumentFaultError("--wire is for the boards of NI")
    for name in ("world", "configuration", "record", "camera_port", "serial"):
        if getattr(options, name):
            flag = "--" + name.replace("_", "-")
            raise ArgumentFaultError(
                f"{flag} has no meaning with --wire, which leaves out the world"
            )


def _start(options: argparse.Namespace, clock: Clock, stack: ExitStack) -> list[str]:
    """Start everything; each thing's end is on the stack. The lines to print."""
    if options.wire:
        server = _boards_without_world(options, clock)
        stack.callback(server.stop)
        return [f"grpc=127.0.0.1:{server.listen(options.port)}"]
    return _serve_world(options, clock, stack)


def _boards_without_world(options: argparse.Namespace, clock: Clock) -> NiDeviceServer:
    try:
        wires = LoopbackWires(options.wire)
        return NiDeviceServer(
            wires,
            clock,
            _devices(options),
            options.driver_version,
            strict_ownership=options.strict_ownership,
            seed=options.seed or 0,
            is_wired=wires.is_wired if options.test_signals else None,
            edges_hz=dict(options.edges or ()),
        )
    except ValueError as fault:
        raise ArgumentFaultError(str(fault)) from fault


def _devices(options: argparse.Namespace) -> dict[str, str] | None:
    return dict(options.device) if options.device else None


def _serve_world(options: argparse.Namespace, clock: Clock, stack: ExitStack) -> list[str]:
    from sim_hardware.camera import CameraServer
    from sim_hardware.families import FOLDER, BoardOptions
    from sim_hardware.faults import FaultyRig
    from sim_hardware.plugins import UnknownPartError
    from sim_hardware.world import World, WorldError, load_world

    try:
        settings = load_world(options.world, seed=options.seed)
        world = World(settings, clock)
        stack.callback(world.close)
        if options.configuration:
            world.mount(options.configuration)
        if options.record:
            world.record_to(options.record)
        family = FOLDER.get(options.boards)
        wanted = BoardOptions(
            devices=_devices(options) or {},
            driver_version=options.driver_version,
            strict_ownership=options.strict_ownership,
        )
        boards = family.make(world, clock, wanted)
    except (WorldError, UnknownPartError) as fault:
        raise ArgumentFaultError(str(fault)) from fault
    except OSError as fault:
        raise ArgumentFaultError(f"--record {options.record} cannot be written: {fault}") from fault
    faulty = FaultyRig(clock=clock, world=world, boards=boards)
    stack.callback(boards.stop)
    try:
        lines = [f"{family.served_as}=127.0.0.1:{boards.listen(options.port)}"]
    except WorldError as fault:
        raise ArgumentFaultError(str(fault)) from fault
    try:
        camera = CameraServer(world, clock, options.camera_port, faults=faulty.camera)
    except OSError as fault:
        raise PortTakenError(
            f"port {options.camera_port} cannot be taken for the camera: something else listens "
            "on it; choose another"
        ) from fault
    stack.callback(camera.stop)
    faulty.begin()
    return [*lines, f"camera={camera.url}", *_serve_serial(faulty, options.serial, stack)]


def _serve_serial(rig: FaultyRig, names: Sequence[str] | None, stack: ExitStack) -> list[str]:
    """Serve the serial devices, where the system has pseudo-terminals; all where none is named."""
    from sim_hardware.plugins import UnknownPartError
    from sim_hardware.serial_devices import FOLDER, PtyPort

    lines = []
    try:
        kinds = [FOLDER.get(name) for name in names or FOLDER.parts()]
    except UnknownPartError as fault:
        raise ArgumentFaultError(f"--serial: {fault}") from fault
    for kind in kinds:
        try:
            device = kind.make(rig.world, rig.clock, rig.world.settings.seed)
            port = PtyPort(device, rig.serial)
        except OSError as fault:
            sys.stderr.write(f"no {kind.role}: {fault}\n")
            continue
        stack.callback(port.stop)
        lines.append(f"{kind.role}={port.path}")
    return lines


def _end_signal(stack: ExitStack) -> threading.Event:
    """Set by SIGTERM and Ctrl-C, from now on."""
    end = threading.Event()

    def stop(_number: int, _frame: FrameType | None) -> None:
        end.set()

    for number in (signal.SIGTERM, signal.SIGINT):
        stack.callback(signal.signal, number, signal.signal(number, stop))
    return end


def _follow_input(end: threading.Event) -> None:
    """Set `end` a while after the input's end: who started this process holds its other end."""
    sys.stdin.read()
    end.wait(LINGER_S)
    end.set()


def _say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def _complain(text: str, code: int) -> int:
    sys.stderr.write(f"sim_hardware: {text}\n")
    return code
