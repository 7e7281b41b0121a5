"""Triggers from outside: start, start again, and samples from before a reference trigger."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
import pytest
from nidaqmx import DaqError
from nidaqmx.constants import AcquisitionType, Edge, ReadRelativeTo, SyncType
from nidaqmx.errors import RpcError

DEVICES = {"X": "PCIe-6363", "Y": "PCIe-6363"}


class Ramp:
    """Inputs show a hundredth of the clock's time, as volts."""

    def write(self, device: str, channel: str, volts: float, when: float) -> None:
        pass

    def read(self, device: str, channel: str, times: np.ndarray) -> np.ndarray:
        return times / 100


@pytest.fixture
def rig(make_ni: Any) -> Any:
    """Two boards with rising edges at X/PFI0 every second, and at X/PFI8 every 0.4 s."""
    edges = {"X/PFI0": 1.0, "X/PFI8": 2.5}
    return make_ni(tcp=False, bench=Ramp(), devices=DEVICES, edges_hz=edges, seed=None)


def sampled(rig: Any, rate_hz: float = 1000.0, samples: int = 100, channel: str = "X/ai0") -> Any:
    task = rig.input(channel)
    task.timing.cfg_samp_clk_timing(rate_hz, samps_per_chan=samples)
    return task


def times(volts: Any) -> np.ndarray:
    return np.asarray(volts) * 100


def refused(code: int) -> Any:
    return pytest.raises(DaqError, match=f"Status Code: {code}")


@pytest.mark.parametrize(("edge", "starts_s"), [(Edge.RISING, 1.0), (Edge.FALLING, 0.5)])
def test_an_edge_from_outside_starts_a_task(rig: Any, edge: Edge, starts_s: float) -> None:
    task = sampled(rig)
    task.triggers.start_trigger.cfg_dig_edge_start_trig("/X/PFI0", trigger_edge=edge)
    task.start()
    found = times(task.read(100))
    assert found == pytest.approx(starts_s + np.arange(100) / 1000, abs=0.04)


def test_a_terminal_without_a_signal_never_starts_a_task(rig: Any) -> None:
    task = sampled(rig)
    task.triggers.start_trigger.cfg_dig_edge_start_trig("/X/PFI5")
    with refused(-200284):
        task.read(100, timeout=3.0)


def test_what_shares_a_start_begins_with_the_edge_that_is_to_come(rig: Any) -> None:
    first, second = sampled(rig), sampled(rig, channel="Y/ai0")
    first.triggers.start_trigger.cfg_dig_edge_start_trig("/X/PFI0")
    second.triggers.start_trigger.cfg_dig_edge_start_trig("/X/ai/StartTrigger")
    first.start()
    second.start()  # after the first, which waits for its edge
    assert times(second.read(100))[0] == pytest.approx(times(first.read(100))[0], abs=1e-6)


def test_a_finite_task_starts_again_at_each_edge(rig: Any) -> None:
    task = sampled(rig, samples=600)
    task.triggers.start_trigger.cfg_dig_edge_start_trig("/X/PFI8")
    task.triggers.start_trigger.retriggerable = True
    task.start()
    found = times(task.read(1200)).reshape(2, 600)
    # The edge at 0.8 s comes while it acquires, and is ignored.
    assert found[:, 0] == pytest.approx([0.4, 1.2], abs=0.04)
    assert found[:, -1] == pytest.approx([0.999, 1.799], abs=0.04)
    assert not task.is_task_done()
    with refused(-200560):
        task.wait_until_done(timeout=2.0)
    task.stop()


def test_all_available_is_the_rest_of_one_trigger(rig: Any) -> None:
    task = sampled(rig)
    task.triggers.start_trigger.cfg_dig_edge_start_trig("/X/PFI8")
    task.triggers.start_trigger.retriggerable = True
    task.start()
    assert len(task.read(30)) == 30
    assert len(task.read(-1)) == 70
    assert len(task.read(-1)) == 100


def test_events_follow_each_trigger(rig: Any) -> None:
    task, counts, enough = sampled(rig), [], threading.Event()

    def callback(_task: object, _kind: int, count: int, _data: object) -> int:
        counts.append(round(times(task.read(count))[0], 1))
        if len(counts) == 3:
            enough.set()
        return 0

    task.triggers.start_trigger.cfg_dig_edge_start_trig("/X/PFI8")
    task.triggers.start_trigger.retriggerable = True
    task.register_every_n_samples_acquired_into_buffer_event(100, callback)
    task.start()
    rig.pass_time(2.0)
    assert enough.wait(10)
    task.stop()
    assert counts[:3] == [0.4, 0.8, 1.2]


def test_a_generation_starts_again_too(make_ni: Any) -> None:
    written: list[tuple[float, float]] = []

    class Listener(Ramp):
        def write(self, device: str, channel: str, volts: float, when: float) -> None:
            written.append((round(when, 3), round(volts, 2)))

    rig = make_ni(tcp=False, bench=Listener(), devices=DEVICES, edges_hz={"X/PFI0": 1.0})
    task = rig.output("X/ao0")
    task.timing.cfg_samp_clk_timing(1000.0, samps_per_chan=2)
    task.triggers.start_trigger.cfg_dig_edge_start_trig("/X/PFI0")
    task.triggers.start_trigger.retriggerable = True
    task.write([1.0, 2.0])
    task.start()
    rig.pass_time(2.5)
    task.stop()
    assert written == [(1.0, 1.0), (1.001, 2.0), (2.0, 1.0), (2.001, 2.0)]


# ---------------------------------------------------------------------------- the reference trigger


def referenced(rig: Any, pretrigger: int = 50, **timing: Any) -> Any:
    task = sampled(rig, **timing)
    task.triggers.reference_trigger.cfg_dig_edge_ref_trig("/X/PFI8", pretrigger)
    return task


def test_a_reference_trigger_gives_samples_from_before_it(rig: Any) -> None:
    task = referenced(rig, pretrigger=30)
    task.start()
    found = times(task.read(-1))
    assert len(found) == 100
    assert found == pytest.approx(0.4 + (np.arange(100) - 30) / 1000, abs=0.04)
    assert task.is_task_done()
    with refused(-200278):
        task.read(1)


def test_the_first_sample_after_the_edge_is_the_first_posttrigger_sample(rig: Any) -> None:
    task = referenced(rig, pretrigger=10, rate_hz=100.0, samples=20)
    rig.pass_time(0.003)
    task.start()  # samples at 0.003 + k / 100
    found = times(task.read(20))
    assert found[10] == pytest.approx(0.403, abs=2e-2)
    assert np.diff(found) == pytest.approx(0.01, abs=3e-2)
    assert task.in_stream.total_samp_per_chan_acquired == 50


def test_a_trigger_before_all_pretrigger_samples_is_ignored(rig: Any) -> None:
    task = referenced(rig, pretrigger=500, samples=600)  # 0.5 s of them: the edge at 0.4 is ignored
    task.start()
    assert times(task.read(-1))[500] == pytest.approx(0.8, abs=0.04)


def test_reads_wait_for_the_whole_window(rig: Any) -> None:
    task = referenced(rig)
    task.start()
    rig.pass_time(0.42)  # the edge has come, the samples after it have not
    with refused(-200284):
        task.read(1, timeout=0.0)
    assert not task.is_task_done()
    task.wait_until_done(timeout=1.0)
    assert len(task.read(40)) == 40
    assert len(task.read(-1)) == 60


def test_what_goes_round_in_the_buffer_can_be_read_before_the_trigger(rig: Any) -> None:
    task = referenced(rig)
    task.start()
    rig.pass_time(0.2)
    task.in_stream.relative_to = ReadRelativeTo.MOST_RECENT_SAMPLE
    task.in_stream.offset = -10
    assert times(task.read(10))[0] == pytest.approx(0.19, abs=0.04)
    task.in_stream.relative_to, task.in_stream.offset = ReadRelativeTo.FIRST_SAMPLE, 0
    with refused(-200279):  # 100 samples are kept
        task.read(10)
    task.in_stream.relative_to = ReadRelativeTo.REFERENCE_TRIGGER
    with refused(-200281):
        task.read(10)


def test_reads_can_be_relative_to_the_trigger(rig: Any) -> None:
    task = referenced(rig)
    task.start()
    task.wait_until_done(timeout=2.0)
    task.in_stream.relative_to = ReadRelativeTo.REFERENCE_TRIGGER
    assert times(task.read(10))[0] == pytest.approx(0.4, abs=0.04)
    task.in_stream.relative_to = ReadRelativeTo.FIRST_PRETRIGGER_SAMPLE
    assert times(task.read(10))[0] == pytest.approx(0.35, abs=0.04)


def test_without_a_reference_trigger_nothing_is_relative_to_it(rig: Any) -> None:
    task = sampled(rig)
    task.in_stream.relative_to = ReadRelativeTo.FIRST_PRETRIGGER_SAMPLE
    task.start()
    with refused(-200282):
        task.read(10)


def test_start_and_reference_triggers_go_together(rig: Any) -> None:
    task = referenced(rig)
    task.triggers.start_trigger.cfg_dig_edge_start_trig("/X/PFI0")
    task.start()
    found = times(task.read(-1))  # it starts at 1 s; the next edge of the other is at 1.2 s
    assert found[50] == pytest.approx(1.2, abs=0.04)


@pytest.mark.parametrize(
    ("change", "code"),
    [
        ("continuous", -200358),
        ("on demand", -200907),
        ("too many", -200077),
        ("one", -200077),
        ("no terminal", -200254),
    ],
)
def test_a_reference_trigger_that_makes_no_sense_is_refused(
    rig: Any, change: str, code: int
) -> None:
    task = rig.input("X/ai0")
    place, pretrigger = "/X/PFI8", {"too many": 99, "one": 1}.get(change, 50)
    if change == "no terminal":
        place = "/X/PFI99"
    if change != "on demand":
        mode = {"continuous": AcquisitionType.CONTINUOUS}.get(change, AcquisitionType.FINITE)
        task.timing.cfg_samp_clk_timing(1000.0, sample_mode=mode, samps_per_chan=100)
    task.triggers.reference_trigger.cfg_dig_edge_ref_trig(place, pretrigger)
    with refused(code):
        task.start()


def test_a_reference_trigger_can_be_asked_for_and_taken_away(rig: Any) -> None:
    task = referenced(rig, pretrigger=30)
    trigger = task.triggers.reference_trigger
    assert (trigger.dig_edge_src, trigger.pretrig_samples) == ("/X/PFI8", 30)
    trigger.pretrig_samples, trigger.dig_edge_edge = 40, Edge.FALLING
    assert times(task.read(-1))[40] == pytest.approx(0.2, abs=0.04)
    trigger.disable_ref_trig()
    assert trigger.trig_type.name == "NONE"
    assert times(task.read(-1))[0] == pytest.approx(rig.clock.now() - 0.1, abs=0.05)


def test_an_output_has_no_reference_trigger(rig: Any) -> None:
    task = rig.output("X/ao0")
    task.timing.cfg_samp_clk_timing(1000.0, samps_per_chan=10)
    task.triggers.reference_trigger.cfg_dig_edge_ref_trig("/X/PFI8", 5)
    with refused(-200197):
        task.write(np.zeros(10))


def test_a_reference_trigger_on_another_task_is_not_simulated(rig: Any) -> None:
    task = sampled(rig)
    task.triggers.reference_trigger.cfg_dig_edge_ref_trig("/X/ao/StartTrigger", 50)
    with pytest.raises(RpcError, match="UNIMPLEMENTED"):
        task.start()


# --------------------------------------------------------------- chassis of PXI and CompactDAQ


def test_boards_of_a_PXI_chassis_share_its_clock_and_a_start(make_ni: Any) -> None:
    slots = {"PXI1Slot3": "PXIe-6363", "PXI1Slot7": "PXIe-6363"}
    rig = make_ni(tcp=False, bench=Ramp(), devices=slots, seed=None, clock_error_ppm=50.0)
    tasks = [sampled(rig, channel=f"/{name}/ai0") for name in slots]
    for task, role in zip(tasks, (SyncType.MASTER, SyncType.SLAVE), strict=True):
        task.timing.ref_clk_src, task.timing.ref_clk_rate = "PXIe_Clk100", 100e6
        task.triggers.sync_type = role
        assert (task.timing.ref_clk_src, task.triggers.sync_type) == ("PXIe_Clk100", role)
    tasks[1].triggers.start_trigger.cfg_dig_edge_start_trig("/PXI1Slot3/ai/StartTrigger")
    for task in reversed(tasks):
        task.start()
    first, second = (times(task.read(100)) for task in tasks)
    assert second == pytest.approx(first, abs=1e-9)


def test_a_board_without_that_chassis_has_no_such_clock(rig: Any) -> None:
    task = sampled(rig)
    task.timing.ref_clk_src = "PXIe_Clk100"
    with refused(-200254):
        task.start()


def test_a_module_belongs_to_its_chassis(make_ni: Any) -> None:
    rig = make_ni(
        tcp=False, bench=Ramp(), devices={"cDAQ1": "cDAQ-9174", "cDAQ1Mod2": "NI 9215"}, seed=None
    )
    chassis, module = (rig.system.devices[name] for name in ("cDAQ1", "cDAQ1Mod2"))
    assert [each.name for each in chassis.chassis_module_devices] == ["cDAQ1Mod2"]
    assert (module.compact_daq_chassis_device.name, module.compact_daq_slot_num) == ("cDAQ1", 2)
    assert list(chassis.ai_physical_chans) == []
    first, second = sampled(rig, channel="cDAQ1Mod2/ai0"), sampled(rig, channel="cDAQ1Mod2/ai0:3")
    assert first.triggers.start_trigger.term == "/cDAQ1/ai/StartTrigger"
    assert np.shape(second.read(100)) == (4, 100)


@pytest.mark.parametrize("others", [{}, {"cDAQ1": "USB-6211"}])
def test_a_module_without_its_chassis_is_one_sentence(make_ni: Any, others: dict[str, str]) -> None:
    with pytest.raises(ValueError, match="cDAQ1Mod1 is a module in slot 1 of the chassis cDAQ1"):
        make_ni(tcp=False, devices={**others, "cDAQ1Mod1": "NI 9215"})


@pytest.mark.parametrize("edges", [{"X/ai0": 1.0}, {"Z/PFI0": 1.0}, {"X/PFI0": 0.0}])
def test_edges_that_make_no_sense_are_one_sentence(make_ni: Any, edges: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="PFI"):
        make_ni(tcp=False, devices=DEVICES, edges_hz=edges)
