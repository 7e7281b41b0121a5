"""world.toml: the shipped worlds, overlays, and what is said of a wrong one."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import pytest

from sim_hardware.clock import VirtualClock
from sim_hardware.rig_boards import boards_of
from sim_hardware.world import World, WorldError, load_world


def test_the_shipped_worlds_load() -> None:
    world, paper = load_world(None), load_world(Path("paper_scatter.toml"))
    assert world.seed == 1
    assert load_world(None, seed=9).seed == 9
    assert (world.scatter.eibm, world.scatter.position_mm) == (0.01, 0.05)
    assert (paper.scatter.eibm, paper.scatter.stiffness) == (0.20, 0.10)
    assert paper.model_copy(update={"scatter": world.scatter}) == world


def test_the_sheets_are_those_of_the_paper() -> None:
    world = load_world()
    assert world.configurations["long"].stiffness_Nm2 == pytest.approx(1.27e-6, rel=0.01)
    assert world.configurations["short"].stiffness_Nm2 == pytest.approx(8.49e-7, rel=0.01)


def test_a_file_says_only_what_differs(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(
        "seed = 3\n[configurations.long]\nyoungs_modulus_MPa = 200\n[eibm]\ndecay_mm = 0"
    )
    world, shipped = load_world(path), load_world()
    assert world.seed == 3
    assert world.configurations["long"].youngs_modulus_MPa == 200
    assert world.configurations["long"].width_mm == shipped.configurations["long"].width_mm
    assert world.eibm.decay_mm == 0
    assert world.load_cell == shipped.load_cell


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[load_cell]\nnoise_mN = -0.5", ["load_cell.noise_mN = -0.5", "at least 0"]),
        ("[load_cell]\nnoise = 1", ["load_cell.noise = 1", "not a key"]),
        ("[arc]\nradius_mm = 'wide'", ["arc.radius_mm = 'wide'", "number"]),
        ("[arc]\nradius_mm = nan", ["arc.radius_mm", "finite"]),
        ("seed = -1", ["seed = -1", "at least 0"]),
        ("seed = 1.5", ["seed = 1.5", "integer"]),
        ("arc = 3", ["arc", "3"]),
        ("[camera]\nexposure_s = 0.1", ["camera", "exposure_s is longer"]),
        ("[camera]\npixels = 5", ["camera.pixels = 5", "not a key"]),
        ("[configurations.wide]\nwidth_mm = 30", ["configurations.wide.free_length_mm", "missing"]),
        ("[clamp]\ntilt_rad = 2.0", ["clamp.tilt_rad = 2.0", "at most 1.5"]),
        ("[[bumps]]\nof = 'eibm'\nat_mm = 3.0\nwidth_mm = 1.0", ["bumps.0.amount", "missing"]),
        (
            "[[bumps]]\nof = 'stiffness'\nat_mm = 3.0\nwidth_mm = 1.0\namount = -1.0",
            ["bumps.0", "amount = -1.0 of a stiffness must be above -1"],
        ),
        ("[creep]\nshare = 0.6", ["creep.share = 0.6", "at most 0.5"]),
        ("seed = = 1", ["not valid TOML", "line 1"]),
    ],
)
def test_a_wrong_world_is_refused_in_words(tmp_path: Path, text: str, words: list[str]) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(text)
    with pytest.raises(WorldError) as caught:
        load_world(path)
    message = str(caught.value)
    assert "\n" not in message
    for word in ["wrong.toml", *words]:
        assert word in message


def test_a_long_key_or_value_is_cut_in_the_message(tmp_path: Path) -> None:
    path = tmp_path / "wrong.toml"
    for text in (f"{'x' * 100_000} = 1", f"seed = '{'x' * 100_000}'"):
        path.write_text(text)
        with pytest.raises(WorldError) as caught:
            load_world(path)
        assert len(str(caught.value)) < 1000


def test_a_file_that_is_not_there_is_named_with_the_shipped_ones(tmp_path: Path) -> None:
    with pytest.raises(WorldError, match=r"nowhere\.toml: no such file.*paper_scatter\.toml"):
        load_world(tmp_path / "nowhere.toml")
    with pytest.raises(WorldError, match="no such file"):
        load_world(tmp_path / "no_folder" / "paper_scatter.toml")


def test_a_shipped_world_is_meant_by_its_name_unless_the_folder_has_its_own(tmp_path: Path) -> None:
    path = tmp_path / "paper_scatter.toml"
    assert load_world(path) == load_world(Path("paper_scatter.toml"))
    path.write_text("seed = 5")
    assert load_world(path) == load_world(None, seed=5)


def test_every_key_of_the_shipped_world_is_explained() -> None:
    text = files("sim_hardware.world").joinpath("world.toml").read_text(encoding="utf-8")
    page = (
        Path(__file__).parents[2].joinpath("docs", "howto", "world.md").read_text(encoding="utf-8")
    )
    for line in text.splitlines():
        key = line.split("=")[0].strip()
        if "=" in line and line[:1] not in ("#", "["):
            assert f"`{key}`" in page, key


def test_a_files_boards_replace_the_shipped_ones_and_its_wiring_is_laid_over(
    tmp_path: Path,
) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('[boards]\nUSB6211 = "USB-6211"\n[wiring]\ndrive = "USB6211/ao1"\n')
    world = load_world(path)
    assert world.boards == {"USB6211": "USB-6211"}
    assert (world.wiring.drive, world.wiring.force) == ("USB6211/ao1", "ai0")
    assert world.wiring.signal_at("USB6211", "ao1") == "drive"
    assert world.wiring.signal_at("usb6211", "ao1") == "drive"
    assert world.wiring.signal_at("USB6211", "ao0") is None
    assert world.wiring.signal_at("whatever", "ai0") == "force"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[boards]\n", ["boards", "at least 1"]),
        ("[boards]\nDev1 = 6211", ["boards.Dev1 = 6211", "string"]),
        ('[wiring]\ndrive = "ai0"', ["wiring.drive = 'ai0'"]),
        ('[wiring]\nforce = "Dev1 ai0"', ["wiring.force = 'Dev1 ai0'"]),
        ('[wiring]\nforce = "ai1"', ["wiring", "a terminal each"]),
        ('[wiring]\nfocre = "ai1"', ["wiring.focre", "not a key"]),
    ],
)
def test_wrong_boards_and_wiring_are_refused_in_words(
    tmp_path: Path, text: str, words: list[str]
) -> None:
    test_a_wrong_world_is_refused_in_words(tmp_path, text, words)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('[boards]\nDev1 = "USB-6212"', r"\[boards\] Dev1: .*'USB-6212'.*'USB-6211'"),
        ('[boards]\n"a,b" = "USB-6211"', r"'a,b' is not a device's name"),
        ('[wiring]\nforce = "Dev1/ai0"', r"\[wiring\] force = 'Dev1/ai0': none of the boards"),
        ('[wiring]\ndrive = "PCI6034E/ao0"', r"\[wiring\] drive = 'PCI6034E/ao0': none"),
    ],
)
def test_boards_that_are_not_simulated_and_terminals_that_are_not_there_are_refused(
    tmp_path: Path, text: str, said: str
) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(text)
    clock = VirtualClock()
    with pytest.raises(WorldError, match=said):
        boards_of(World(load_world(path), clock), clock)
