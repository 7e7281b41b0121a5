"""LabJack T4, T7 and T8 through the driver: contract, signals, ownership, and every bad answer."""

from __future__ import annotations

import contextlib
import dataclasses
import socket
import threading
import time

import numpy as np
import pytest

from drivers.boards.conformance import (
    connection_faults,
    family_faults,
    interlock_faults,
    output_faults,
    rescue_faults,
    signal_faults,
)
from drivers.boards.labjack.errors import OutputTakenError
from drivers.boards.labjack.settings import LabJackSettings
from drivers.boards.labjack.wire import SocketTransport
from drivers.interfaces import (
    DeviceError,
    DeviceNotFoundError,
    DeviceTimeoutError,
    LostSamplesError,
)
from tests.drivers.labjack_rig import FAMILY, LIMIT_V, MODELS, LabJackRig, over_tcp, virtual

EVERY = pytest.mark.parametrize("product_type", MODELS)


def opened(rig: LabJackRig, limit_V: float = LIMIT_V):
    """Connection, output and inputs, all open."""
    boards = rig.boards()
    boards.open()
    output, signals = boards.voltage_output(limit_V), boards.signal_input(rig.inputs())
    output.open()
    signals.open()
    return boards, output, signals


# -------------------------------------------------------------------------------------- contract


@EVERY
def test_every_model_keeps_the_contract(product_type):
    rig = virtual(product_type)
    assert family_faults(FAMILY, rig.settings, rig.clock) == []
    assert connection_faults(rig.boards(), rig.clock) == []
    boards = rig.boards()
    boards.open()
    assert output_faults(boards.voltage_output(LIMIT_V), LIMIT_V, rig.clock) == []
    assert signal_faults(boards.signal_input(rig.inputs()), rig.clock) == []
    other = rig.boards()  # without an output there is no mark to keep
    other.open()
    assert interlock_faults(other.interlock("EIO0"), rig.clock) == []


@pytest.mark.slow
@EVERY
def test_over_tcp_too_and_its_rescue(product_type):
    with over_tcp(product_type) as rig:
        boards, output, signals = opened(rig)
        assert signal_faults(boards.signal_input(rig.inputs()), rig.clock) == []
        signals.close()
        output.write(0.2)
        assert rig.read_back_V() == pytest.approx(0.2, abs=0.03)
        rescue = FAMILY.rescue(rig.place(), rig.clock)
        assert rescue_faults(rescue, rig.clock, rig.read_back_V) == []
        boards.close()


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"drive": "DAC0"}, "gives no negative voltage"),
        ({"stage_gain": 0.0}, "would put out nothing"),
    ],
)
def test_settings_that_cannot_drive_both_signs_are_refused(settings, said):
    with pytest.raises(ValueError, match=said):
        LabJackSettings(**settings)


# --------------------------------------------------------------------------------------- signals


@EVERY
def test_what_is_written_is_read_back_within_the_converters_steps(product_type):
    rig = virtual(product_type)
    _, output, signals = opened(rig)
    for volts in (0.2, -0.2, 0.0):
        output.write(volts)
        rig.wait(0.01)
        drive_V = signals.measure(0.05)[2]
        assert drive_V.mean() == pytest.approx(volts, abs=0.02)


def test_the_true_rate_is_that_of_the_devices_clock():
    rig = virtual(sample_rate_hz=3000.0)
    boards = rig.boards()
    boards.open()
    signals = boards.signal_input(rig.inputs())
    signals.open()
    assert signals.rate_hz == pytest.approx(1e7 / 3333, rel=1e-6)
    assert list(signals.ranges_V) == [0.1, 1.0, 10.0]
    assert signals.measure(0.1).shape == (3, 301)


def test_an_edge_is_at_the_sample_that_its_time_says():
    rig = virtual()
    _, output, signals = opened(rig)
    sample_clock = signals.start()
    rig.wait(0.1)
    done = output.write(0.2)
    rig.wait(0.1)
    drive_V = signals.read_available().volts[2]
    signals.stop()
    first = int(np.argmax(drive_V > 0.1))
    assert first - 1 <= sample_clock.index_at(done.after_s) <= first


def test_samples_that_were_overwritten_are_lost_samples():
    rig = virtual()
    _, _, signals = opened(rig)
    signals.start()
    rig.wait(30.0)
    with pytest.raises(LostSamplesError, match="samples were overwritten before they were read"):
        signals.read_available()
    signals.stop()
    assert signals.measure(0.1).shape == (3, 100)


# ------------------------------------------------------------------------------------- ownership


def test_an_output_that_another_program_drives_is_refused():
    rig = virtual()
    opened(rig)
    boards = rig.boards()
    boards.open()
    with pytest.raises(OutputTakenError, match="`labrig safe` writes 0 V and frees it"):
        boards.voltage_output(LIMIT_V).open()


@pytest.mark.slow
def test_a_program_that_wakes_after_the_output_was_made_safe_writes_no_voltage():
    with over_tcp() as rig:
        _, output, signals = opened(rig)
        output.write(0.2)
        rescue = FAMILY.rescue(rig.place(), rig.clock)
        rescue.open()
        assert rescue.make_safe(1.0, lambda: None).is_safe
        rescue.close()
        rig.wait(0.15)
        highest = [0.0]
        write = rig.bench.write
        rig.bench.write = lambda d, c, volts, when: (  # type: ignore[method-assign]
            highest.append(abs(volts)),
            write(d, c, volts, when),
        )
        with pytest.raises(OutputTakenError, match="start the run again"):
            output.write(0.2)
        assert max(highest) < 0.01
        with pytest.raises(DeviceError, match="is not open"):
            output.write(0.2)
        signals.close()


def test_a_write_that_was_under_way_is_taken_back_at_once():
    rig = virtual()
    _, output, _ = opened(rig)
    output.write(0.2)
    rig.device.write(46178, bytes(4))  # the guard's, a moment before our next write
    with pytest.raises(OutputTakenError):
        output.write(0.2)
    assert abs(rig.output_V()) < 0.01


# ------------------------------------------------------------------------------------ bad answers


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"serial": 470000001}, "has the serial number 470012345, rig.toml says 470000001"),
        ({"model": "T8"}, "is a T7, rig.toml says T8"),
    ],
)
def test_another_device_than_the_one_meant_is_refused(settings, said):
    with pytest.raises(DeviceNotFoundError, match=said):
        virtual(**settings).boards().open()


def test_an_input_that_the_model_lacks_is_named():
    rig = virtual(current="AIN3")
    boards = rig.boards()
    boards.open()
    with pytest.raises(DeviceNotFoundError, match="take an even one, AIN0 to AIN12"):
        boards.signal_input(rig.inputs()).open()


def test_an_ltick_dac_that_is_not_there_is_named():
    boards = virtual(drive="TDAC4").boards()
    boards.open()
    with pytest.raises(DeviceError, match=r"LJTick-DAC does not answer.*LabJack error 2764"):
        boards.voltage_output(LIMIT_V).open()


def test_a_stage_that_does_not_reach_the_limit_is_refused():
    rig = virtual("T7 DAC0", stage_gain=0.05)
    boards = rig.boards()
    boards.open()
    with pytest.raises(DeviceError, match="DAC0 cannot give what"):
        boards.voltage_output(LIMIT_V).open()


@pytest.mark.parametrize(
    ("fault", "kind", "said"),
    [
        ({"unavailable": True}, DeviceNotFoundError, "no connection to the LabJack at"),
        ({"hang": True}, DeviceTimeoutError, "did not answer in the time this can take"),
        ({"garbage": True}, DeviceError, "gave an answer that makes no sense"),
        ({"refuse_outputs": True}, DeviceError, "refuses it: the device has failed"),
    ],
)
def test_a_write_that_fails_says_why_in_one_sentence(fault, kind, said):
    rig = virtual()
    _, output, _ = opened(rig)
    output.write(0.2)
    for name, value in fault.items():
        setattr(rig.device.faults, name, value)
    began_s = rig.clock.now()
    with pytest.raises(kind, match=said) as caught:
        output.write(0.1)
    assert rig.clock.now() - began_s <= 1.0
    assert "\n" not in str(caught.value)
    for name in fault:
        setattr(rig.device.faults, name, False)
    output.write(0.0)  # on a connection of its own where the old one is lost
    assert abs(rig.output_V()) < 0.01


@pytest.mark.slow
def test_a_cable_that_was_pulled_is_no_connection_and_then_a_new_one():
    with over_tcp() as rig:
        _, output, signals = opened(rig)
        output.write(0.2)
        rig.server.cut()
        with pytest.raises(DeviceNotFoundError, match="no connection to the LabJack"):
            output.write(0.1)
        output.write(0.0)
        signals.close()


def test_a_calibration_that_makes_no_sense_is_refused():
    rig = virtual()
    model = dataclasses.replace(rig.device.model, flash_at=rig.device.model.flash_at - 4)
    rig.device.model = model
    boards = rig.boards()
    boards.open()
    with pytest.raises(DeviceError, match=r"its calibration of AIN0 .* makes no sense"):
        boards.signal_input(rig.inputs()).open()


# --------------------------------------------------------------------------------------- watchdog


def watched(rig: LabJackRig, line: str | None = "EIO0"):
    """Output and watchdog, open, the sheet energised."""
    boards = rig.boards()
    boards.open()
    output = boards.voltage_output(LIMIT_V)
    output.open()
    watchdog = boards.interlock(line)
    watchdog.open()
    output.write(0.2)
    return output, watchdog


EIO0 = 8


def test_the_line_is_high_while_the_loop_lives_and_low_a_second_after():
    rig = virtual()
    _, watchdog = watched(rig)
    assert not rig.device.level(EIO0)
    for _ in range(40):
        watchdog.beat()
        rig.wait(0.05)
        rig.device.advance()
        assert rig.device.level(EIO0)
    rig.wait(0.9)
    rig.device.advance()
    assert rig.device.level(EIO0)
    rig.wait(0.1)
    rig.device.advance()
    assert not rig.device.level(EIO0)


def test_another_programs_requests_do_not_feed_it():
    rig = virtual()
    _, watchdog = watched(rig)
    watchdog.beat()
    other = rig.boards()
    for _ in range(12):
        rig.wait(0.1)
        other.open()  # a request
    assert not rig.device.level(EIO0)


def test_dac0_behind_a_stage_goes_to_the_value_that_means_0_V():
    rig = virtual("T7 DAC0")
    output, watchdog = watched(rig, None)
    assert FAMILY.own_watchdog(rig.settings, None).startswith("the LabJack's watchdog sets DAC0")
    watchdog.beat()
    assert rig.output_V() == pytest.approx(0.2, abs=0.01)
    rig.wait(1.01)
    rig.device.advance()
    assert abs(rig.output_V()) < 0.005
    output.close()
    watchdog.close()


def test_an_ltick_dac_without_a_line_has_no_watchdog():
    assert FAMILY.own_watchdog(LabJackSettings(), None) == ""


def test_the_next_run_writes_only_what_differs_into_flash():
    rig = virtual()
    _, watchdog = watched(rig)
    watchdog.close()
    assert not rig.device.level(EIO0)
    assert not rig.device.watchdog.enabled
    writes = []
    values = rig.device.watchdog.values

    class Counted(dict):
        def __setitem__(self, key, value):
            writes.append(key)
            super().__setitem__(key, value)

    rig.device.watchdog.values = Counted(values)
    watchdog.open()
    assert sorted(set(writes)) == [61600, 61612]  # on, off, and the key


def test_a_beat_after_the_output_was_made_safe_leaves_the_line_low():
    rig = virtual()
    _, watchdog = watched(rig)
    watchdog.beat()
    rig.device.write(46178, bytes(4))
    rig.wait(0.1)
    with pytest.raises(OutputTakenError):
        watchdog.beat()
    assert not rig.device.level(EIO0)


def test_a_request_behind_one_that_is_not_answered_ends_by_itself():
    rig = virtual()
    _, output, signals = opened(rig)
    rig.device.faults.hang = True
    said = []

    def write():
        with pytest.raises(DeviceTimeoutError):
            output.write(0.0)
        said.append(rig.clock.now())

    began_s = rig.clock.now()
    thread = rig.clock.start_thread(write, "writing 0 V")
    rig.clock.sleep_until(began_s + 0.1)
    with pytest.raises(DeviceTimeoutError):
        signals.measure(0.01)
    thread.join()
    assert max(said[0], rig.clock.now()) < began_s + 5.0


@pytest.mark.slow
def test_an_answer_that_comes_byte_by_byte_is_given_up_in_time():
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def dribble() -> None:
            line, _ = listener.accept()
            with line, contextlib.suppress(OSError):
                line.recv(100)
                for byte in bytes(6) * 20:
                    line.send(bytes([byte or 1]))
                    time.sleep(0.1)  # noqa: TID251 - a device in real time

        threading.Thread(target=dribble, daemon=True).start()
        host, port = listener.getsockname()
        transport = SocketTransport(host, port)
        began_s = time.monotonic()
        with pytest.raises(TimeoutError):
            transport.exchange(b"anything", 0.3)
        assert time.monotonic() - began_s < 1.0
        transport.close()
