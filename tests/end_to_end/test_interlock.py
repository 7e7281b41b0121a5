"""The interlock: a relay in the amplifier's supply that only a working loop keeps closed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sim_hardware.clock import VirtualClock
from sim_hardware.world import World, load_world
from tests.end_to_end.faulty_rig import FaultyRig, spied_writes

LINE = "PCI6703/port0/line0"
WORLD = '[interlock]\nline = "port0/line0"\n'
WIRED = (("[load_cell]", f'[interlock]\nline = "{LINE}"\n[load_cell]'),)
HOLD_S, LAG_S = 0.3, 0.02


@pytest.fixture
def rig(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> FaultyRig:
    return FaultyRig(tmp_path, capsys, spied_writes(monkeypatch))


def sheet_V(world: World, clock: VirtualClock, after_s: float) -> float:
    clock.sleep_until(clock.now() + after_s)
    return float(np.mean(world.read("", "ai2", clock.now() + np.linspace(0, 1e-3, 5))))


@pytest.mark.slow
def test_the_relay_opens_0_3_s_after_the_last_edge_and_closes_with_the_next(
    tmp_path: Path,
) -> None:
    (tmp_path / "world.toml").write_text(WORLD)
    clock = VirtualClock()
    world = World(load_world(tmp_path / "world.toml"), clock)
    world.write("PCI6703", "ao0", 0.2, clock.now())
    assert sheet_V(world, clock, 0.1) == pytest.approx(0.0, abs=0.05)  # no edge yet
    world.edge(LINE, clock.now())
    assert sheet_V(world, clock, LAG_S) == pytest.approx(2.0, abs=0.05)
    for _ in range(20):
        assert sheet_V(world, clock, 0.25) == pytest.approx(2.0, abs=0.05)
        world.edge(LINE, clock.now())
    assert sheet_V(world, clock, HOLD_S - LAG_S) == pytest.approx(2.0, abs=0.05)
    assert sheet_V(world, clock, 2 * LAG_S) == pytest.approx(0.0, abs=0.05)
    assert sheet_V(world, clock, 100.0) == pytest.approx(0.0, abs=0.05)
    world.edge("PCI6703/port0/line1", clock.now())  # another line
    assert sheet_V(world, clock, LAG_S) == pytest.approx(0.0, abs=0.05)
    world.edge(LINE, clock.now())
    assert sheet_V(world, clock, LAG_S) == pytest.approx(2.0, abs=0.05)


def test_a_world_without_an_interlock_needs_no_edges() -> None:
    clock = VirtualClock()
    world = World(load_world(None), clock)
    world.write("PCI6703", "ao0", 0.2, clock.now())
    assert sheet_V(world, clock, 10.0) == pytest.approx(2.0, abs=0.05)


@pytest.mark.slow
def test_a_run_keeps_its_interlock_closed(rig: FaultyRig, monkeypatch: pytest.MonkeyPatch) -> None:
    real, edges_s = World.edge, []

    def edge(self: World, line: str, when: float, *, high: bool) -> None:
        edges_s.append(when)
        real(self, line, when, high=high)

    monkeypatch.setattr(World, "edge", edge)
    left = rig.run(WORLD, WIRED)
    assert (left.code, left.readings, left.invalid) == (0, 5, [])
    assert len(edges_s) > 50
    assert max(np.diff(edges_s)) < 0.06


@pytest.mark.slow
def test_a_run_that_does_not_know_of_the_interlock_has_no_valid_reading_under_voltage(
    rig: FaultyRig,
) -> None:
    left = rig.run(WORLD)
    assert left.code == 0
    assert len(left.invalid) == 4
    assert all("the drive reads back" in why for why in left.invalid)


@pytest.mark.slow
def test_an_interlock_that_cannot_be_toggled_ends_the_run_before_a_voltage(rig: FaultyRig) -> None:
    left = rig.run(
        WORLD, (("[load_cell]", '[interlock]\nline = "PCI6703/port0/line99"\n[load_cell]'),)
    )
    assert left.code == 3
    assert "line99" in left.said
    assert left.highest_V == 0.0


@pytest.mark.slow
def test_a_line_that_is_none_is_refused(rig: FaultyRig) -> None:
    left = rig.run(WORLD, (("[load_cell]", '[interlock]\nline = "PCI6703/ao1"\n[load_cell]'),))
    assert left.code == 2
    assert "must be a digital line, such as PCI6703/port0/line0" in left.said
