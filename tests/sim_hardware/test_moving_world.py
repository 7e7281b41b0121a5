"""A moving world as the boards, the camera and the operator see it."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from drivers.interfaces import ThreadHandle
from sim_hardware.world import Train, Visit, World, WorldError, load_world, timed_session
from sim_hardware.world.settings import WorldSettings

SENSITIVITY = 0.15296
QUIET = {
    "load_cell": {
        "noise_mN": 0.0, "drift_mN": 0.0, "hum_mN": 0.0, "offset_uV": 0.0, "hysteresis_mN": 0.0
    },
    "scatter": {"eibm": 0.0, "stiffness": 0.0, "position_mm": 0.0},
    "amplifier": {"offset_mV": 0.0},
    "electrical": {"current_noise_mV": 0.0, "readback_noise_mV": 0.0},
}  # fmt: skip


class HandClock:
    def __init__(self) -> None:
        self.time_s = 5.0

    def now(self) -> float:
        return self.time_s

    def sleep_until(self, when: float) -> None:
        self.time_s = max(self.time_s, when)

    def start_thread(self, *_: object) -> ThreadHandle:
        raise NotImplementedError


def moving(**tables: dict[str, object]) -> WorldSettings:
    content = load_world(Path("moving.toml")).model_dump()
    for name in {*QUIET, *tables}:
        content[name] = {**content[name], **QUIET.get(name, {}), **tables.get(name, {})}
    return WorldSettings.model_validate(content)


def quiet(**tables: dict[str, object]) -> tuple[World, HandClock]:
    clock = HandClock()
    return World(moving(**tables), clock), clock


def sampled(world: World, channel: str, start_s: float, length_s: float) -> np.ndarray:
    return world.read("b", channel, start_s + np.arange(round(length_s * 1e3)) / 1e3)


def tip_mm(world: World, when: float) -> np.ndarray:
    return world.true_shape(when)[-1] * 1e3


@pytest.fixture(autouse=True)
def _no_shipped_file_here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_the_shipped_moving_world_loads_and_differs_by_what_it_says() -> None:
    world, at_rest = load_world(Path("moving.toml")), load_world()
    assert world.moving
    assert not at_rest.moving
    assert world.mass == at_rest.mass
    assert world.load_cell.drift_mN > 0
    assert world.load_cell.hum_mN > 0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[mass]\ndensity_kg_per_m3 = 0.0", ["mass.density_kg_per_m3 = 0.0", "above 0"]),
        ("[mass]\nend_kg = -1.0", ["mass.end_kg = -1.0", "at least 0"]),
        ("[loss]\nshares = [-0.1]\ntimes_s = [1.0]", ["loss.shares.0 = -0.1", "above 0"]),
        ("[loss]\nshares = [0.1]\ntimes_s = []", ["loss", "each share needs its time"]),
        ("[electrodes]\nbulk_ohm_m = 0.0", ["electrodes.bulk_ohm_m = 0.0", "above 0"]),
        ("[water]\nfluid = 'oil'", ["water.fluid = 'oil'", "'none', 'air' or 'water'"]),
        ("[load_cell]\ndamping = 1.5", ["load_cell.damping = 1.5", "below 1"]),
        ("moving = true\n[rolls]\nfriction = 0.1", ["does not know rolls.friction = 0.1"]),
        ("moving = true\n[creep]\nshare = 0.1", ["does not know creep.share = 0.1", "moving ="]),
    ],
)
def test_a_wrong_moving_world_is_refused_in_words(
    tmp_path: Path, text: str, words: list[str]
) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(text)
    with pytest.raises(WorldError) as caught:
        load_world(path)
    for word in ["wrong.toml", *words]:
        assert word in str(caught.value)


def test_the_force_goes_to_that_of_the_world_at_rest() -> None:
    """At 0 V, where both have the same sheet, to the error of 64 links."""
    for name, position_m in (("long", 0.0), ("long", 0.025), ("short", 0.005)):
        forces = []
        for is_moving in (True, False):
            content = {**moving().model_dump(), "moving": is_moving}
            world = World(WorldSettings.model_validate(content), HandClock())
            world.mount(name)
            world.place(position_m)
            forces.append(world.true_force_N(world._clock.now()))
        assert forces[0] == pytest.approx(forces[1], abs=3e-7)


def test_the_current_has_its_spike_at_the_edge_and_the_force_follows_later() -> None:
    world, clock = quiet()
    world.place(0.0)
    world.write("b", "ao0", 0.2, 5.0)
    clock.time_s = 6.0
    current_mA = sampled(world, "ai1", 5.0, 1.0) * 1e3  # 1 ohm
    force_mN = sampled(world, "ai0", 5.0, 1.0) / SENSITIVITY * 1e3
    assert np.argmax(current_mA) in (1, 2)
    assert current_mA.max() == pytest.approx(2 * 22.4, abs=0.5)
    assert current_mA[999] == pytest.approx(12.4, abs=0.5)
    assert 0 < force_mN[10] - force_mN[0] < 0.05
    assert 1.0 < force_mN[900] - force_mN[0] < 3.0


def test_a_free_sheet_still_swings_half_a_second_after_an_edge_and_rests_after_some() -> None:
    world, clock = quiet()
    world.write("b", "ao0", 0.2, 5.0)
    clock.time_s = 5.4
    world.write("b", "ao0", 0.0, 5.4)
    clock.time_s = 40.0
    at_rest = tip_mm(world, 40.0)
    away = [np.hypot(*(tip_mm(world, t) - at_rest)) for t in (5.4, 5.9, 8.4)]
    assert away[0] > 10
    assert 1 < away[1] < 15
    assert away[2] < 0.5


def test_the_shape_of_an_exposure_is_blurred_while_the_sheet_moves() -> None:
    world, clock = quiet()
    given: list[list[np.ndarray]] = []

    class Renderer:
        def render(self, shapes: list[np.ndarray], *_: object, **__: object) -> np.ndarray:
            given.append(shapes)
            return np.zeros(world.frame_shape, dtype=np.uint8)

    world._renderer = Renderer()  # type: ignore[assignment]
    world.write("b", "ao0", 0.2, 5.0)
    clock.time_s = 5.1
    world.image(5.1, 0)
    ends = np.array([shape[-1] for shape in given[0]])
    assert len(ends) == 9
    assert np.allclose(np.diff(ends, axis=0), np.diff(ends, axis=0).mean(axis=0), atol=2e-5)
    true = [tip_mm(world, 5.1 - 5e-3), tip_mm(world, 5.1)]
    assert np.allclose(ends[[0, -1]] * 1e3, true, atol=1e-4)
    assert np.hypot(*(ends[-1] - ends[0])) > 5e-4
    world.write("b", "ao0", 0.0, 5.1)
    clock.time_s = 60.0
    world.image(60.0, 1)
    assert len(given[1]) == 1


def test_a_sheet_that_the_rolls_let_go_springs_back() -> None:
    world, clock = quiet()
    free = tip_mm(world, 5.0)
    world.place(-0.01)
    held = tip_mm(world, 5.0)
    clock.time_s = 6.0
    world.place(None)
    assert np.allclose(tip_mm(world, 6.0), held, atol=0.05)
    swing = np.array([tip_mm(world, t)[1] for t in 6.0 + np.arange(0, 1, 0.02)])
    assert swing.max() > free[1] + 3
    clock.time_s = 40.0
    assert np.allclose(tip_mm(world, 40.0), free, atol=1e-3)
    assert world.true_force_N(40.0) == 0.0


def test_the_stage_carries_the_sheet_along_without_a_jump() -> None:
    world, clock = quiet()
    world.place(0.005)
    before = world.true_force_N(5.0)
    world.place(0.010)
    clock.time_s = 5.4
    shown = sampled(world, "ai0", 5.0, 0.4) / SENSITIVITY
    steps = np.abs(np.diff(shown))
    assert shown[0] == pytest.approx(before, abs=1e-8)
    assert steps.max() < 2e-5
    clock.time_s = 20.0
    other, later = quiet()
    other.place(0.010)
    assert world.true_force_N(20.0) == pytest.approx(other.true_force_N(later.now()), abs=1e-8)


def test_the_load_cell_rings_at_its_resonance() -> None:
    world, clock = quiet(load_cell={"resonance_hz": 80.0, "damping": 0.02})
    world.place(0.0)
    world.hang(0.01)
    clock.time_s = 6.0
    shown_mN = sampled(world, "ai0", 5.0, 1.0) / SENSITIVITY * 1e3
    rest = shown_mN[-1]
    crossings = np.flatnonzero(np.diff(np.sign(shown_mN[:200] - rest)))
    assert 1e3 / (2 * np.mean(np.diff(crossings))) == pytest.approx(80, rel=0.03)
    overshoot = shown_mN[:20].max() - rest
    assert overshoot == pytest.approx(10 * np.exp(-np.pi * 0.02), rel=0.05)


def test_signals_do_not_depend_on_how_reads_are_cut() -> None:
    found = []
    for parts in (1, 7):
        world, clock = quiet()
        world.place(0.01)
        world.write("b", "ao0", 0.2, 5.0)
        clock.time_s = 5.0 + 0.2003
        times = 5.0 + np.arange(2000) / 1e4
        pieces = np.array_split(times, parts)
        found.append([np.concatenate([world.read("b", c, t) for t in pieces])
                      for c in ("ai0", "ai1", "ai2")])  # fmt: skip
    assert np.array_equal(found[0], found[1])


def test_noise_has_drift_and_hum() -> None:
    clock = HandClock()
    world = World(load_world(Path("moving.toml")), clock)
    clock.time_s = 45.0
    force_mN = sampled(world, "ai0", 5.0, 40.0) / SENSITIVITY * 1e3
    spectrum = np.abs(np.fft.rfft(force_mN)) / force_mN.size * 2
    hum = spectrum[(50 * 40)]
    assert hum == pytest.approx(0.03, abs=0.005)
    means = force_mN.reshape(-1, 2000).mean(axis=1)
    assert means.std() > 3 * 0.1 / np.sqrt(2000)


def test_a_sheet_that_is_pulled_out_of_the_rolls_is_free_from_then_on() -> None:
    world, clock = quiet(load_cell={"travel_mm_per_s": 200.0})
    world.place(0.02)
    world.place(0.06)
    clock.time_s = 7.0
    assert world.true_force_N(7.0) == 0.0
    assert np.isfinite(world.true_shape(7.0)).all()


def test_a_timed_session_runs_in_a_moving_world() -> None:
    train = Train(zero_readings=2, discarded=2, kept=2)
    visits = [Visit(configuration="long", position_m=p) for p in (0.0, None)]
    held, free = timed_session(moving(), visits, train=train)
    forces = {v: [r.force_N for r in held.readings if r.voltage_V == v] for v in (2.0, -2.0)}
    assert np.mean(forces[2.0]) - np.mean(forces[-2.0]) > 2e-3
    ends = {r.voltage_V: r.curve_m[-1] for r in free.readings}
    assert np.hypot(*(ends[2.0] - ends[-2.0])) > 0.02


def test_a_step_takes_a_small_part_of_the_time_that_it_stands_for() -> None:
    world, clock = quiet()
    world.place(0.0)
    world.write("b", "ao0", 0.2, 5.0)
    begin = time.process_time()
    clock.time_s = 9.0
    world.true_force_N(9.0)
    assert time.process_time() - begin < 4.0 / 4
