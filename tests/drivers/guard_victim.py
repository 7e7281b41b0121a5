"""A program that energises the sheet under guard and then comes to grief; run as a process.

Arguments: the guard's settings as JSON, and how it ends. It prints what it does, with the time.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from drivers import Guard, GuardSettings
from drivers.boards.ni.analog_input import InputChannel, NiSignalInput
from drivers.boards.ni.analog_output import NiVoltageOutput
from drivers.boards.ni.connection import NiConnection
from drivers.boards.ni.rescue import OutputPlace
from drivers.interfaces import DeviceError, RealClock


def say(*words: object) -> None:
    print(*words, f"{CLOCK.now():.6f}", flush=True)


CLOCK = RealClock()
SETTINGS = GuardSettings.from_json(sys.argv[1])
ENDING = sys.argv[2]


def main() -> None:
    place = OutputPlace(**SETTINGS.place)
    connection = NiConnection(place.address)
    connection.open()
    output = NiVoltageOutput(connection, CLOCK, place.output_channel, 0.25)
    output.open()
    inputs = [
        InputChannel("force", "PCI6034E/ai0", 0.05, "differential"),
        InputChannel("drive", place.drive_channel, 4.0),
    ]
    signals = NiSignalInput(connection, CLOCK, inputs, 1000.0)
    signals.open()
    guard = Guard.start(SETTINGS)
    say("guard", guard.pid)
    signals.start()
    guard.energised(True)
    output.write(0.2)
    say("energised")
    began = CLOCK.now()
    while True:
        CLOCK.sleep_until(CLOCK.now() + 0.01)
        lived = CLOCK.now() - began
        if ENDING == "finish" and lived > 0.5:
            output.close()
            guard.energised(False)
            signals.close()
            guard.disarm()
            say("finished")
            return
        if ENDING == "exit" and lived > 0.2:
            say("exiting")
            os._exit(1)
        if ENDING == "fork" and lived > 0.2:
            if os.fork() == 0:
                CLOCK.sleep_until(CLOCK.now() + 20.0)
                os._exit(0)
            say("forked")
            began = CLOCK.now() + 1e9
        if ENDING == "hang" and lived > 0.2:
            say("hanging")
            CLOCK.sleep_until(CLOCK.now() + 1.2)
            try:
                output.write(0.2)
                say("wrote")
            except DeviceError as fault:
                say("refused", type(fault).__name__)
            CLOCK.sleep_until(CLOCK.now() + 60.0)
        if ENDING == "hang_at_zero" and lived > 0.2:
            output.write(0.0)
            guard.energised(False)
            guard.new_run()
            say("hanging")
            CLOCK.sleep_until(CLOCK.now() + 60.0)
        signals.read_available()
        try:
            guard.beat()
        except DeviceError as fault:
            say("warned", str(fault).replace(" ", "_"))
            output_state(output)
            return


def output_state(output: NiVoltageOutput) -> None:
    """The guard is gone: what a run does then."""
    try:
        output.write(0.0)
        output.close()
        say("zeroed")
    except DeviceError as fault:
        say("refused", type(fault).__name__)


if __name__ == "__main__":
    main()
