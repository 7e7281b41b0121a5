"""A task's life: states, reservations, attaching by name, what a reset leaves."""

from __future__ import annotations

from typing import Any

import pytest
from nidaqmx.constants import AcquisitionType, TaskMode
from nidaqmx.errors import DaqError, RpcError
from nidaqmx.grpc_session_options import SessionInitializationBehavior as Behavior

RESERVED = -50103


def refused(code: int) -> Any:
    """Expects a DaqError with this code."""
    return pytest.raises(DaqError, match=f"{code}")


def test_a_task_without_a_name_gets_one(ni: Any) -> None:
    first, second = ni.task(), ni.task()
    assert first.name != second.name
    assert "unnamed" in first.name


def test_a_task_tells_its_channels_and_devices(ni: Any) -> None:
    task = ni.input("PCI6034E/ai0:2")
    task.ai_channels.add_ai_voltage_chan("PCI6034E/ai7", "force")
    assert task.channel_names == [*(f"PCI6034E/ai{i}" for i in range(3)), "force"]
    assert task.number_of_channels == 4
    assert [device.name for device in task.devices] == ["PCI6034E"]
    assert task.ai_channels["force"].physical_channel.name == "PCI6034E/ai7"


def test_several_channels_are_named_by_number(ni: Any) -> None:
    task = ni.task()
    task.ai_channels.add_ai_voltage_chan("PCI6034E/ai0:1", "cell")
    assert task.channel_names == ["cell0", "cell1"]


def test_a_range_of_channels_may_run_backwards(ni: Any) -> None:
    assert ni.input("PCI6034E/ai2:0").channel_names == [f"PCI6034E/ai{i}" for i in (2, 1, 0)]


def test_one_board_has_one_input_task_at_a_time(ni: Any) -> None:
    first, second = ni.input("PCI6034E/ai0"), ni.input("PCI6034E/ai5")
    first.start()
    with refused(RESERVED):
        second.start()
    with refused(RESERVED):
        second.read()
    first.stop()
    second.start()


def test_outputs_are_reserved_one_by_one(ni: Any) -> None:
    first, second = ni.output("PCI6703/ao0"), ni.output("PCI6703/ao1")
    first.start()
    second.start()
    other = ni.output("PCI6703/ao0")
    with refused(RESERVED):
        other.write(1.0)
    first.close()
    other.write(1.0)


def test_a_committed_task_keeps_its_board_between_runs(ni: Any) -> None:
    first, second = ni.input(), ni.input()
    first.control(TaskMode.TASK_COMMIT)
    first.start()
    first.stop()
    with refused(RESERVED):
        second.start()
    first.control(TaskMode.TASK_UNRESERVE)
    second.start()


def test_an_abort_lets_go_of_the_board(ni: Any) -> None:
    first, second = ni.input(), ni.input()
    first.control(TaskMode.TASK_RESERVE)
    first.control(TaskMode.TASK_ABORT)
    second.control(TaskMode.TASK_START)
    assert not second.in_stream.avail_samp_per_chan


def test_a_write_that_starts_the_task_ends_it_too(ni: Any) -> None:
    first, second = ni.output(), ni.output()
    first.write(1.0, auto_start=True)
    second.write(2.0, auto_start=True)
    assert ni.input().read() == pytest.approx(2.0, abs=2e-3)


@pytest.mark.slow
def test_a_second_client_attaches_without_a_word(ni: Any) -> None:
    first = ni.task("labrig-output")
    first.ao_channels.add_ao_voltage_chan("PCI6703/ao0")
    first.start()
    first.write(2.0)
    ni.channel = ni.new_channel()  # another process
    second = ni.task("labrig-output")
    assert second.channel_names == ["PCI6703/ao0"]
    second.write(0.0)
    assert abs(ni.input().read()) < 2e-3


def test_leaving_a_task_one_has_attached_to_leaves_it_running(ni: Any) -> None:
    first = ni.input()
    first.start()
    with ni.task(first.name):
        pass
    assert first.read() == pytest.approx(0.0, abs=2e-3)


def test_a_name_may_be_asked_for_as_new_or_as_there(ni: Any) -> None:
    with pytest.raises(RpcError) as fault:
        ni.task("a", initialization_behavior=Behavior.ATTACH_TO_SERVER_SESSION)
    assert fault.value.rpc_code.name == "FAILED_PRECONDITION"
    ni.task("a", initialization_behavior=Behavior.INITIALIZE_SERVER_SESSION)
    with pytest.raises(RpcError) as fault:
        ni.task("a", initialization_behavior=Behavior.INITIALIZE_SERVER_SESSION)
    assert fault.value.rpc_code.name == "ALREADY_EXISTS"
    ni.task("a", initialization_behavior=Behavior.ATTACH_TO_SERVER_SESSION)


def test_a_cleared_task_is_gone_and_its_output_stays(ni: Any) -> None:
    task = ni.output()
    task.start()
    task.write(3.0)
    attached = ni.task(task.name)
    task.close()
    with refused(-200088):
        attached.write(0.0)
    assert ni.input().read() == pytest.approx(3.0, abs=2e-3)


@pytest.mark.slow
def test_a_reset_frees_the_channel_and_leaves_the_voltage(ni: Any) -> None:
    task = ni.output()
    task.start()
    task.write(3.0)
    ni.system.devices["PCI6703"].reset_device()
    with refused(-200846):
        task.write(0.0, auto_start=False)
    assert ni.input().read() == pytest.approx(3.0, abs=2e-3)
    other = ni.output()
    other.start()
    other.write(0.0)
    assert abs(ni.input().read()) < 2e-3


def test_a_stopped_output_keeps_its_voltage(ni: Any) -> None:
    task = ni.output()
    task.start()
    task.write(-4.0)
    task.stop()
    assert ni.input().read() == pytest.approx(-4.0, abs=2e-3)


def test_a_finite_acquisition_is_done_when_its_samples_have_come(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(1000, samps_per_chan=100)
    assert task.is_task_done()
    task.start()
    assert not task.is_task_done()
    task.wait_until_done(timeout=5)
    assert task.is_task_done()
    assert task.in_stream.avail_samp_per_chan == 100
    task.stop()


@pytest.mark.slow
def test_waiting_for_the_end_of_a_continuous_acquisition_times_out(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(1000, sample_mode=AcquisitionType.CONTINUOUS)
    task.start()
    before_s = ni.clock.now()
    with refused(-200560):
        task.wait_until_done(timeout=0.2)
    assert 0.2 <= ni.clock.now() - before_s < 1.0


def test_a_read_starts_a_finite_task_and_ends_it_with_its_last_sample(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(10_000, samps_per_chan=100)
    task.read(60)
    assert task.in_stream.curr_read_pos == 60
    task.read(40)
    assert task.is_task_done()
    assert len(task.read(100)) == 100  # a new acquisition


def test_nothing_comes_after_the_end_of_a_finite_acquisition(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(10_000, samps_per_chan=100)
    task.start()
    task.read(100)
    with refused(-200278):
        task.read(1)


def test_a_running_task_is_not_changed(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(1000)
    task.start()
    with refused(-200557):
        task.timing.samp_clk_rate = 2000
    with refused(-200557):
        task.ai_channels[0].ai_max = 1.0
    with refused(-200479):
        task.ai_channels.add_ai_voltage_chan("PCI6034E/ai1")
    with refused(-200479):
        task.start()
    task.stop()
    task.timing.samp_clk_rate = 2000
    assert task.timing.samp_clk_rate == 2000


def test_settings_can_be_taken_back(ni: Any) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(5000, samps_per_chan=77)
    del task.timing.samp_quant_samp_per_chan
    assert task.timing.samp_quant_samp_per_chan == 1000
    task.in_stream.input_buf_size = 12
    del task.in_stream.input_buf_size
    assert task.in_stream.input_buf_size == 1000
    task.in_stream.auto_start = False
    del task.in_stream.auto_start
    assert task.in_stream.auto_start
    del task.ai_channels[0].ai_max
    assert task.ai_channels[0].ai_max == 10.0  # ai_min still asks for -10 V


@pytest.mark.parametrize(
    ("rate", "buffer"), [(50, 1000), (1000, 10_000), (50_000, 100_000), (100, 1000)]
)
def test_the_driver_chooses_a_buffer_by_the_rate(ni: Any, rate: float, buffer: int) -> None:
    task = ni.input()
    task.timing.cfg_samp_clk_timing(rate, sample_mode=AcquisitionType.CONTINUOUS)
    assert task.in_stream.input_buf_size == buffer
    assert task.in_stream.input_onbrd_buf_size == 512


def test_another_thread_may_stop_a_task_that_is_being_read(make_ni: Any) -> None:
    rig = make_ni(tcp=False)
    task = rig.input()
    task.timing.cfg_samp_clk_timing(1000, sample_mode=AcquisitionType.CONTINUOUS)
    task.start()

    def stop() -> None:
        rig.clock.sleep_until(0.5)
        task.stop()

    stopping = rig.clock.start_thread(stop, "stop")
    with refused(-200278):
        task.read(5000)
    assert 0.5 <= rig.clock.now() < 0.6
    assert stopping.join()
