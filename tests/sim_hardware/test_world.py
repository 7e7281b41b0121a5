"""The simulated world as the boards, the camera and the person see it."""

from __future__ import annotations

import csv
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from drivers.interfaces import Clock, Prompt, ThreadHandle
from sim_hardware.operator import SimulatedOperator
from sim_hardware.simulated_rig import AnalogSide, OpticalSide
from sim_hardware.world import CellFault, World, WorldError, WorldSettings, load_world

QUIET = {
    "load_cell": {"noise_mN": 0.0, "drift_mN": 0.0, "hum_mN": 0.0, "offset_uV": 0.0},
    "scatter": {"eibm": 0.0, "stiffness": 0.0, "position_mm": 0.0},
    "amplifier": {"offset_mV": 0.0},
}
SENSITIVITY = 0.15296


class HandClock:
    """Stands still until it is moved."""

    def __init__(self, start_s: float = 5.0) -> None:
        self.time_s = start_s

    def now(self) -> float:
        return self.time_s

    def sleep_until(self, when: float) -> None:
        self.time_s = max(self.time_s, when)

    def start_thread(self, target: Callable[[], None], name: str) -> ThreadHandle:
        raise NotImplementedError


def settings_with(**tables: dict[str, object]) -> WorldSettings:
    content = load_world().model_dump()
    for name, table in tables.items():
        content[name] = {**content[name], **table}
    return WorldSettings.model_validate(content)


def quiet_world(**tables: dict[str, object]) -> tuple[World, HandClock]:
    clock = HandClock()
    merged = {name: {**table, **tables.pop(name, {})} for name, table in QUIET.items()}
    return World(settings_with(**merged, **tables), clock), clock


def put(world: World, clock: HandClock, sheet_V: float, wait_s: float = 3.0) -> float:
    """The force a while after a voltage was put on the sheet, in mN."""
    world.write("board", "ao0", sheet_V / 10, clock.now())
    clock.time_s += wait_s
    return world.true_force_N(clock.now()) * 1e3


def samples(world: World, channel: str, start_s: float, count: int) -> np.ndarray:
    return world.read("board", channel, start_s + np.arange(count) / 1000.0)


def test_the_world_is_a_bench_and_a_scene() -> None:
    world, _ = quiet_world()
    bench: AnalogSide = world
    scene: OpticalSide = world
    clock: Clock = HandClock()
    assert bench is scene
    assert clock.now() == 5.0


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_forces_have_the_order_signs_and_sizes_of_the_rig(seed: int) -> None:
    clock = HandClock()
    world = World(load_world(seed=seed), clock)
    for configuration, free_mm, low_mN, high_mN in (
        ("long", 15.0, -2.2, 3.2),
        ("short", 5.0, -5.2, 3.2),
    ):
        world.mount(configuration)
        forces = {}
        for position_mm in range(0, 31, 5):
            world.place(position_mm * 1e-3)
            world.moisten()
            forces[position_mm] = [put(world, clock, v) for v in (0.0, 2.0, -2.0)]
            put(world, clock, 0.0)
        table = np.array(list(forces.values()))
        assert np.all(table[:, 1] > table[:, 0])
        assert np.all(table[:, 0] > table[:, 2])
        assert np.all(np.diff(table, axis=0) < 0)
        assert low_mN < table.min() < 0.7 * low_mN
        assert 0.7 * high_mN < table.max() < high_mN
        at = np.interp(0.0, -table[:, 0], np.array(list(forces)))
        assert abs(at - free_mm) < 1.0


def test_the_sheet_bends_up_at_plus_2_V_and_down_at_minus_2_V() -> None:
    world, clock = quiet_world()
    tips = []
    for voltage in (2.0, 0.0, -2.0):
        put(world, clock, voltage, 20.0)
        tips.append(tip_mm(world, clock)[1])
    assert tips == pytest.approx([43, 20, -16], abs=1.0)


def tip_mm(world: World, clock: HandClock) -> np.ndarray:
    """The sheet's end as the renderer is given it."""
    return shapes_given(world, clock)[-1][-1] * 1e3


def shapes_given(world: World, clock: HandClock) -> list[np.ndarray]:
    given: list[list[np.ndarray]] = []

    class Renderer:
        def render(self, shapes: list[np.ndarray], *_: object, **__: object) -> np.ndarray:
            given.append(shapes)
            return np.zeros(world.frame_shape, dtype=np.uint8)

    before, world._renderer = world._renderer, Renderer()  # type: ignore[assignment]
    world.image(clock.now(), 0)
    world._renderer = before
    return given[0]


def test_the_force_follows_the_exact_solution_of_the_short_sheet() -> None:
    # k* constant along the sheet, contact on the elongation: case vi of the reference tables.
    short = load_world().configurations["short"]
    straighter = short.model_copy(update={"rest_curvature_per_m": 20.0})
    world, clock = quiet_world(configurations={"short": straighter.model_dump()})
    world.mount("short")
    B = straighter.stiffness_Nm2
    for position_mm, F_R2_over_B in ((0, 0.84667949043813508190), (5, -0.39914579011668547)):
        world.place(position_mm * 1e-3)
        clock.time_s += 1
        assert world.true_force_N(clock.now()) == pytest.approx(F_R2_over_B * B / 0.04**2, rel=1e-5)


def test_the_sheet_is_settled_at_the_sampling_point() -> None:
    world, clock = quiet_world(water={"first_pulse_deficit": 0.0})
    world.place(0.0)
    put(world, clock, -2.0)
    early = put(world, clock, 2.0, 0.5)
    late = put(world, clock, 2.0, 0.4)
    assert early == pytest.approx(late, abs=0.003 * abs(late))


def test_the_first_two_pulses_differ_and_the_others_do_not() -> None:
    world, clock = quiet_world()
    world.place(0.0)
    forces = [put(world, clock, 2.0 * (-1) ** k, 0.6) for k in range(8)]
    up, down = np.array(forces[::2]), np.array(forces[1::2])
    assert up[1] - up[0] > 0.02 * up[-1]
    assert abs(down[0] - down[-1]) > 0.003 * abs(down[-1])
    assert abs(up[1] - up[-1]) < 0.004 * up[-1]
    assert abs(down[1] - down[-1]) < 0.002 * abs(down[-1])


def test_drying_under_voltage_is_slow_and_undone_by_moistening() -> None:
    world, clock = quiet_world()
    world.place(0.015)  # where the rest curvature gives next to no force
    wet = put(world, clock, 2.0)
    put(world, clock, 2.0, 60.0)
    dry = world.true_force_N(clock.now()) * 1e3
    assert 0.004 < (wet - dry) / wet < 0.02
    world.moisten()
    assert put(world, clock, 2.0) == pytest.approx(wet, rel=5e-4)


def test_one_protocol_run_dries_the_sheet_by_far_less_than_the_scatter() -> None:
    world, clock = quiet_world()
    world.place(0.0)
    forces = [put(world, clock, 2.0 * (-1) ** k, 0.6) for k in range(22)]
    assert abs(forces[20] / forces[2] - 1) < 0.005


def test_moment_at_minus_2_V_is_less_by_the_given_ratio() -> None:
    settings = load_world()
    assert settings.eibm.settled(2.0) == pytest.approx(1.0)
    assert settings.eibm.settled(-2.0) == pytest.approx(-0.8)
    assert settings.eibm.settled(1.0) == pytest.approx(0.5, abs=0.03)
    assert settings.eibm.settled(0.0) == 0.0


def test_the_current_has_a_spike_and_a_floor() -> None:
    world, clock = quiet_world()
    put(world, clock, -2.0)
    start_s = clock.now()
    put(world, clock, 2.0)
    current_A = samples(world, "ai1", start_s, 1000)  # 1 ohm
    assert 0.15 < current_A[:5].max() < 0.25
    assert current_A[-100:].mean() == pytest.approx(0.01, rel=0.02)
    charge_C = np.sum(current_A[:400] - 0.01) / 1000
    # What the capacity takes, less what does not leak yet while the voltage rises.
    assert charge_C == pytest.approx(4.0 * 1.5e-3 - 4.0 / 200 * 0.03, rel=0.04)


def test_the_amplifier_has_gain_offset_and_rails() -> None:
    world, clock = quiet_world(amplifier={"offset_mV": 1.0})
    for board_V, sheet_V in ((0.0, 0.01), (0.2, 2.01), (-0.2, -1.99), (10.0, 14.0), (-10.0, -14.0)):
        put(world, clock, 10 * board_V)
        found = samples(world, "ai2", clock.now(), 2000).mean()
        assert found == pytest.approx(sheet_V, abs=3e-4)


def test_a_voltage_acts_from_its_moment_on_and_not_before() -> None:
    world, clock = quiet_world()
    world.write("b", "ao0", 0.2, clock.now() + 0.01005)
    volts = world.read("b", "ai2", clock.now() + np.array([0.0, 0.01, 0.0101, 0.0115]))
    assert volts[:2] == pytest.approx([0, 0], abs=0.01)
    assert 0.5 < volts[2] < 1.5
    assert volts[3] == pytest.approx(2.0, abs=0.01)


RARE = {
    "eibm": {"relaxation": 0.3, "relaxation_spread": 3.0, "breathing": 0.1},
    "water": {"drying_form": "exp", "stiffening_per_min": 1.0, "spread_order": 2},
    "load_cell": {"warming_mN": 1.0, "warming_form": "exp", "beat_mN": 0.1, "pickup_mN": 0.1},
    "rolls": {"friction": 0.1, "meniscus_mN": 0.2, "meniscus_dries_s": 5.0},
    "creep": {"share": 0.2, "time_s": 1.0, "spread": 3.0},
}


def play(cut: Callable[[int], list[int]], settings: WorldSettings) -> list[np.ndarray]:
    """A second of three channels around edges and a move, read in pieces."""
    clock = HandClock()
    world = World(settings, clock)
    world.place(0.003)
    start_s = clock.now()
    events = {250: lambda t: world.write("b", "ao0", 0.2, t), 700: lambda t: world.place(0.01)}
    result: list[list[np.ndarray]] = [[], [], []]
    done = 0
    for piece in cut(1000):
        while done < piece:
            until = min([piece, *(e for e in events if e > done)])
            clock.time_s = start_s + until / 1000 - 0.0004
            times = start_s + np.arange(done, until) / 1000
            for k, channel in enumerate(("ai0", "ai1", "ai2")):
                result[k].append(world.read("b", channel, times))
            done = until
            if done in events:
                events[done](clock.time_s)
    return [np.concatenate(parts) for parts in result]


@pytest.mark.slow
@pytest.mark.parametrize("tables", [{}, RARE], ids=["shipped", "rare"])
def test_signals_do_not_depend_on_how_the_reads_are_cut(
    tables: dict[str, dict[str, object]],
) -> None:
    settings = settings_with(**tables)
    whole = play(lambda n: [n], settings)
    ones = play(lambda n: list(range(1, n + 1)), settings)
    odd = play(lambda n: [*range(7, n, 37), n], settings)
    for a, b, c in zip(whole, ones, odd, strict=True):
        assert np.array_equal(a, b)
        assert np.array_equal(a, c)
    assert len(np.unique(whole[0])) == 1000  # and there is noise on it


def test_the_same_calls_give_the_same_bits_and_another_seed_others() -> None:
    def run(seed: int) -> tuple[np.ndarray, np.ndarray]:
        clock = HandClock(0.0)
        world = World(load_world(seed=seed), clock)
        world.place(0.005)
        put(world, clock, 2.0, 0.5)
        return samples(world, "ai0", clock.now(), 300), world.image(clock.now(), 3)

    first, again, other = run(4), run(4), run(5)
    assert np.array_equal(first[0], again[0])
    assert np.array_equal(first[1], again[1])
    assert not np.array_equal(first[0], other[0])
    assert not np.array_equal(first[1], other[1])


@pytest.mark.slow
def test_a_new_set_up_scatters_as_stated() -> None:
    clock = HandClock()
    world = World(settings_with(**{**QUIET, "scatter": {}}), clock)
    forces = []
    for _ in range(60):
        world.place(0.0)
        clock.time_s += 0.1
        forces.append(world.true_force_N(clock.now()) * 1e3)
    # 1 % of 0.84 mN for B and 0.05 mm of 0.06 mN/mm for the position
    assert np.std(forces) == pytest.approx(np.hypot(0.0084, 0.003), rel=0.35)
    before = world.true_force_N(clock.now())
    world.remount()
    assert world.position_m == 0.0
    assert world.true_force_N(clock.now()) != before


def test_readings_have_a_realistic_noise() -> None:
    clock = HandClock()
    world = World(load_world(), clock)
    world.place(0.0)
    clock.time_s += 0.01
    force_mN = samples(world, "ai0", clock.now(), 60_000) / SENSITIVITY * 1e3
    assert np.std(np.diff(force_mN)) / np.sqrt(2) == pytest.approx(0.1, rel=0.05)
    readings = force_mN.reshape(-1, 600)[:, 400:].mean(axis=1)
    assert 0.02 < np.std(readings) < 0.05


def test_the_load_cell_reads_the_force_with_its_sensitivity() -> None:
    world, clock = quiet_world()
    for load_N in (0.0, 0.02, -0.05):
        world.hang(load_N)
        clock.time_s += 0.01
        volts = samples(world, "ai0", clock.now(), 10)
        expected = SENSITIVITY * load_N * (1 + 0.0005 * abs(load_N) / 0.09807 - 0.05 / 98.07)
        assert volts == pytest.approx(np.full(10, expected), abs=2e-9)
    clock.time_s += 0.01
    world.place(None)
    assert world.true_force_N(clock.now()) == 0.0


def test_hysteresis_makes_a_loop_of_its_height() -> None:
    world, clock = quiet_world(load_cell={"hysteresis_mN": 0.02, "hysteresis_reach_mN": 0.5})
    found = {}
    for name, load_mN in (("up", 5.0), ("top", 10.0), ("down", 5.0)):
        world.hang(load_mN * 1e-3)
        clock.time_s += 0.01
        found[name] = samples(world, "ai0", clock.now(), 1)[0] / SENSITIVITY * 1e3
        clock.time_s += 0.01
    assert found["down"] - found["up"] == pytest.approx(0.04, abs=1e-6)


def test_a_sheet_that_sticks_in_the_rolls_passes_on_only_larger_changes() -> None:
    world, clock = quiet_world(rolls={"stick_mN": 0.5})
    for position_m, passed_on in ((0.025, 1.0), (0.03, 0.0)):
        world.place(position_m)
        put(world, clock, 0.0)
        before = samples(world, "ai0", clock.now(), 1)[0]
        change = put(world, clock, 0.4) - put(world, clock, 0.0, 0.0)
        after = samples(world, "ai0", clock.now(), 1)[0]
        assert abs(change) < 0.5
        assert (after - before) / SENSITIVITY * 1e3 == pytest.approx(
            passed_on * change, abs=1e-3
        ) or change == 0.0
        put(world, clock, 0.0)


def test_an_open_load_cell_wire_drifts_to_a_rail_and_comes_back_when_mended() -> None:
    world, clock = quiet_world()
    world.place(0.0)
    clock.time_s += 1
    before = samples(world, "ai0", clock.now(), 1)[0]
    world.break_load_cell(CellFault.OPEN)
    early = samples(world, "ai0", clock.now(), 1)[0]
    clock.time_s += 5
    assert early == pytest.approx(before, abs=0.05)
    assert samples(world, "ai0", clock.now(), 1)[0] > 10.0
    world.break_load_cell(CellFault.NO_EXCITATION)
    assert samples(world, "ai0", clock.now() + 0.001, 1)[0] == 0.0
    world.break_load_cell(CellFault.NONE)
    clock.time_s += 0.1
    assert samples(world, "ai0", clock.now(), 1)[0] == pytest.approx(before, rel=1e-3)


def test_a_sheet_driven_out_of_the_rolls_stays_out_until_it_is_placed_again() -> None:
    world, clock = quiet_world()
    world.place(0.03)
    assert put(world, clock, 0.0) < -0.5
    assert put(world, clock, -8.0) == 0.0
    assert put(world, clock, 0.0) == 0.0
    assert tip_mm(world, clock)[1] == pytest.approx(19.7, abs=0.2)
    world.place(0.03)
    assert put(world, clock, 0.0) < -0.5


def test_a_position_out_of_reach_reads_no_force() -> None:
    world, clock = quiet_world()
    world.place(0.06)
    assert put(world, clock, 0.0) == 0.0
    assert put(world, clock, 2.0) == 0.0


def test_friction_makes_the_force_depend_on_the_approach() -> None:
    world, clock = quiet_world(rolls={"friction": 0.2})
    smooth, _ = quiet_world()
    forces = {}
    for approach in ("up", "down"):
        world.place(0.028, approach)  # type: ignore[arg-type]
        clock.time_s += 0.1
        forces[approach] = world.true_force_N(clock.now())
    smooth.place(0.028)
    smooth_N = smooth.true_force_N(6.0)
    assert abs(forces["up"] - forces["down"]) > 0.02 * abs(smooth_N)
    assert (forces["up"] + forces["down"]) / 2 == pytest.approx(smooth_N, rel=0.02)


def test_a_yielding_load_cell_takes_force_away() -> None:
    stiff, clock = quiet_world()
    soft, soft_clock = quiet_world(load_cell={"compliance_mm_per_mN": 0.5})
    forces = []
    for world, at in ((stiff, clock), (soft, soft_clock)):
        world.place(0.0)
        forces.append(put(world, at, 2.0))
    # The sheet's own stiffness there is about 0.06 mN/mm.
    assert forces[1] / forces[0] == pytest.approx(1 / (1 + 0.5 * 0.06), abs=0.01)


def test_relaxation_takes_its_share_of_the_moment_back() -> None:
    world, clock = quiet_world(
        eibm={"relaxation": 0.1, "relaxation_s": 1.0}, water={"first_pulse_deficit": 0.0}
    )
    world.place(0.0143)
    early, late = put(world, clock, 2.0, 0.5), put(world, clock, 2.0, 9.0)
    assert late / early == pytest.approx((1 - 0.1) / (1 - 0.1 * 0.35), abs=0.02)


def test_a_delayed_camera_shows_the_past() -> None:
    now, clock = quiet_world()
    late, late_clock = quiet_world()
    late = World(late.settings.model_copy(update={"frame_delay_s": 0.5}), late_clock)
    for world, at in ((now, clock), (late, late_clock)):
        put(world, at, 2.0, 0.4)
    assert tip_mm(late, late_clock)[1] < tip_mm(now, clock)[1] - 10


@pytest.mark.parametrize("configuration", ["long", "short"])
def test_every_shape_of_the_experiment_lies_inside_the_image(configuration: str) -> None:
    world, clock = quiet_world()
    world.mount(configuration)
    camera = world.settings.camera
    u0, v0 = camera.origin_px
    rolls_px = camera.px_per_mm * 2.5
    for position_mm in (None, 0, 5, 10, 15, 20, 25, 30):
        world.place(None if position_mm is None else position_mm * 1e-3)
        for voltage in (-2.0, 0.0, 2.0):
            put(world, clock, voltage)
            shape = np.concatenate(shapes_given(world, clock)) * 1e3 * camera.px_per_mm
            u, v = u0 + shape[:, 0], v0 - shape[:, 1]
            assert u.min() >= 0
            assert u.max() < camera.image_size[0] - rolls_px
            assert v.min() > rolls_px
            assert v.max() < camera.image_size[1] - rolls_px


def test_an_image_shows_the_sheet_where_it_is() -> None:
    world, clock = quiet_world()
    put(world, clock, 0.0)
    image = world.image(clock.now(), 0).astype(float)
    assert image.shape == world.frame_shape
    shape = shapes_given(world, clock)[0] * 1e3
    camera = world.settings.camera
    column = 250
    x_mm = (column - camera.origin_px[0]) / camera.px_per_mm
    y_mm = np.interp(x_mm, shape[:, 0], shape[:, 1])
    row = camera.origin_px[1] - camera.px_per_mm * y_mm
    near = slice(round(row) - 6, round(row) + 7)
    light = np.clip(image[near, column] - 60, 0, None)
    assert np.sum(light * np.arange(near.start, near.stop)) / light.sum() == pytest.approx(
        row, abs=0.3
    )


def test_the_record_holds_every_change_and_the_force_while_driven(tmp_path: Path) -> None:
    world, clock = quiet_world()
    world.record_to(tmp_path / "record.csv")
    first = (tmp_path / "record.csv").read_text().splitlines()
    assert first[0] == "time_s,drive_V,force_mN,position_mm"
    assert len(first) == 2
    world.place(0.005)
    start_s = clock.now()
    put(world, clock, 2.0, 1.0)
    put(world, clock, 0.0, 5.0)
    written = (tmp_path / "record.csv").read_text()
    world.close()
    world.close()
    with (tmp_path / "record.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert (tmp_path / "record.csv").read_text().startswith(written)
    times = [float(row["time_s"]) for row in rows]
    assert times == sorted(times)
    drives = [float(row["drive_V"]) for row in rows]
    changes = [(times[k], drives[k]) for k in range(1, len(rows)) if drives[k] != drives[k - 1]]
    assert changes == [(start_s, 2.0), (start_s + 1.0, 0.0)]
    driven = [row for row in rows if row["drive_V"] == "2"]
    assert 90 <= len(driven) <= 102
    for row in driven[1:]:
        true_mN = world.true_force_N(float(row["time_s"])) * 1e3
        assert float(row["force_mN"]) == pytest.approx(true_mN, abs=2e-3)
    assert [row["position_mm"] for row in rows[:2]] == ["", "5.0000"]
    assert len(rows) < 130


def test_a_record_that_cannot_be_written_is_refused_in_words(tmp_path: Path) -> None:
    world, _ = quiet_world()
    with pytest.raises(WorldError, match=r"nowhere.*cannot be written"):
        world.record_to(tmp_path / "nowhere" / "record.csv")


def test_the_person_does_what_is_asked() -> None:
    world, clock = quiet_world()
    person = SimulatedOperator(world)
    assert person.ask(Prompt(kind="mount", text="", configuration="short"))
    assert world.configuration == "short"
    assert person.ask(Prompt(kind="move", text="", position_m=0.01))
    assert world.position_m == 0.01
    assert person.ask(Prompt(kind="remount", text=""))
    assert world.position_m == 0.01
    assert person.ask(Prompt(kind="free", text=""))
    assert world.position_m is None
    assert person.ask(Prompt(kind="dead_weight", text="", load_N=0.02))
    assert world.true_force_N(clock.now()) == 0.02
    assert person.ask(Prompt(kind="dead_weight", text=""))
    assert world.true_force_N(clock.now()) == 0.0
    assert person.ask(Prompt(kind="moisten", text=""))
    assert person.ask(Prompt(kind="confirm", text=""))
    with pytest.raises(ValueError, match="juggle"):
        person.ask(Prompt(kind="juggle", text=""))


def test_a_rig_turned_over_is_a_world_whose_weight_pulls_the_other_way() -> None:
    clock, quiet = HandClock(), settings_with(**QUIET)
    up, down, over = (
        World(quiet.model_copy(update={"gravity_N_per_m": load}), clock)
        for load in (0.01, -0.01, 0.01)
    )
    for _ in range(2):  # one that is turned over already stays so
        assert SimulatedOperator(over).ask(Prompt(kind="turn_over", text=""))
    shapes = [world.true_shape(clock.now()) for world in (up, down, over)]
    assert np.max(np.abs(shapes[0] - shapes[1])) > 1e-4
    np.testing.assert_array_equal(shapes[2], shapes[1])
    for world in (up, down, over):
        world.mount("long")
        world.place(0.01)
    forces = [world.true_force_N(clock.now()) for world in (up, down, over)]
    assert forces[2] == forces[1] != forces[0]


def test_a_sheet_that_the_world_does_not_have_cannot_be_mounted() -> None:
    world, _ = quiet_world()
    with pytest.raises(WorldError, match=r"no configuration wide.*long, short"):
        world.mount("wide")


def test_several_threads_may_use_the_world_at_once() -> None:
    world, clock = quiet_world()
    world.place(0.0)
    clock.time_s += 10
    finished: list[int] = []

    def use(work: Callable[[int], object]) -> None:
        for k in range(40):
            work(k)
        finished.append(1)

    start_s = clock.now()
    jobs: list[Callable[[int], object]] = [
        lambda k: world.write("b", "ao0", 0.2 * (-1) ** k, start_s + k * 0.05),
        lambda k: world.read("b", "ai0", start_s + k * 0.05 + np.arange(50) / 1000),
        lambda k: world.read("b", "ai2", start_s + k * 0.05 + np.arange(50) / 1000),
        lambda k: world.image(start_s + k * 0.05, k) if k % 8 == 0 else None,
        lambda k: world.place(0.001 * (k % 10)) if k % 8 == 0 else None,
    ]
    threads = [threading.Thread(target=use, args=(job,)) for job in jobs]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert len(finished) == len(jobs)


def test_an_input_that_nothing_is_wired_to_reads_zero() -> None:
    world, clock = quiet_world()
    assert np.array_equal(samples(world, "ai7", clock.now(), 3), np.zeros(3))
    world.write("b", "ao1", 5.0, clock.now())
    assert samples(world, "ai2", clock.now() + 1, 100).mean() == pytest.approx(0.0, abs=1e-3)


@pytest.mark.slow
def test_what_was_long_ago_is_forgotten_but_the_world_goes_on() -> None:
    world, clock = quiet_world()
    world.place(0.0)
    for _ in range(8):
        put(world, clock, 2.0, 150.0)
        world.moisten()
        force = put(world, clock, 0.0, 20.0)
    assert force == pytest.approx(0.8428, rel=0.01)
    assert world._history._rows._rows.nbytes < 150e6
