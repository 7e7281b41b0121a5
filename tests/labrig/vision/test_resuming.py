"""A batch that was stopped continues, and its results are those of one that was not."""

from __future__ import annotations

import json
from dataclasses import fields

import cv2
import numpy as np
import pytest

from labrig.cli.main import run
from labrig.vision import BatchOptions, NeutralCurve, extract_curves, neutral_curve
from labrig.vision.batch.resuming import KeptCurves
from labrig.vision.curve.background_lines import BackgroundLine
from labrig.vision.image.review import REVIEW_FILE
from tests.cases import few

pytestmark = pytest.mark.slow  # images are measured


class Counting:
    """The built-in extractor, which counts its images and is stopped at one of them."""

    def __init__(self, stopped_at: int | None = None) -> None:
        self.count = 0
        self.stopped_at = stopped_at

    def __call__(self, image, optics, strip, *, start=None):
        if self.count == self.stopped_at:
            raise KeyboardInterrupt
        self.count += 1
        return neutral_curve(image, optics, strip, start=start)


@pytest.fixture
def folder(tmp_path, plain):
    """A film of three frames, two images and a damaged one."""
    pictures = tmp_path / "pictures"
    pictures.mkdir()
    header = b"YUV4MPEG2 W640 H480 F25:1 Ip A1:1 Cmono\n"
    noise = np.random.default_rng(0)
    noisy = (plain.image + noise.normal(0, 2, (3, 480, 640))).clip(0, 255).astype(np.uint8)
    film = b"".join(b"FRAME\n" + frame.tobytes() for frame in noisy)
    (pictures / "film.y4m").write_bytes(header + film)
    for name, image in (("a", plain.image), ("z", np.dstack([plain.image // 2] * 2 + [noisy[0]]))):
        cv2.imwrite(str(pictures / f"{name}.png"), image)
    (pictures / "m.png").write_bytes(b"not a picture")
    (pictures / "optics.json").write_text(json.dumps(plain.optics))
    (pictures / "sheet.toml").write_text("free_length_mm = 50\nthickness_mm = 0.21\n")
    return pictures


def batch(folder, output, find=None, **more):
    find = find or Counting()
    options = BatchOptions(find=find, is_built_in=True, **more)
    return extract_curves([folder], output, options), find.count


def results(output):
    return {path.name: path.read_bytes() for path in output.iterdir() if path.is_file()}


@pytest.mark.parametrize("stopped_at", few([2, 0, 4]))
def test_a_batch_that_was_stopped_continues_as_if_it_had_not_been(folder, tmp_path, stopped_at):
    batch(folder, tmp_path / "whole")
    out = tmp_path / "out"
    with pytest.raises(KeyboardInterrupt):
        batch(folder, out, Counting(stopped_at))
    result, count = batch(folder, out)
    assert count == 5 - stopped_at
    assert result.kept == stopped_at
    assert results(out) == results(tmp_path / "whole")


def test_in_python_the_curves_of_a_batch_that_was_stopped_lack_nothing(folder, tmp_path):
    first, _ = batch(folder, tmp_path / "out")
    again, count = batch(folder, tmp_path / "out")
    assert count == 0
    for name, curve in first.curves.items():
        for field in fields(NeutralCurve):
            was, now = getattr(curve, field.name), getattr(again.curves[name], field.name)
            assert type(was) is type(now) or isinstance(was, float), (name, field.name)
            np.testing.assert_array_equal(was, now, err_msg=f"{name}.{field.name}")


def test_a_curve_with_wires_and_a_refusal_with_its_place_are_kept_whole(tmp_path):
    wire = BackgroundLine(np.array([[1.5, 2.0], [3.0, 4.0]]), np.array([True, False]), 0.7)
    kept = KeptCurves(tmp_path)
    for name, curve in (
        ("found", NeutralCurve(ok=True, wires=(wire, wire), warnings=("one", "two"))),
        ("refused", NeutralCurve(ok=False, why="no.", refused_at_px=(3.5, 4.5))),
    ):
        kept.keep(name, curve, "1f")
        assert kept.curve(name, "2e") is None
        kept.keep(name, curve, "1f")
        read = KeptCurves(tmp_path).curve(name, "1f")
        assert read is not None
        assert (read.ok, read.warnings) == (curve.ok, curve.warnings)
        assert (read.why, read.refused_at_px) == (curve.why, curve.refused_at_px)
        assert [one.half_px for one in read.wires] == [one.half_px for one in curve.wires]
        for one, other in zip(read.wires, curve.wires, strict=True):
            np.testing.assert_array_equal(one.path, other.path)
            np.testing.assert_array_equal(one.seen, other.seen)


def change_picture(folder):
    image = cv2.imread(str(folder / "a.png"), cv2.IMREAD_UNCHANGED)
    image[0, 0] ^= 1
    cv2.imwrite(str(folder / "a.png"), image)


def change_optics(folder):
    known = json.loads((folder / "optics.json").read_text())
    (folder / "a.optics.json").write_text(json.dumps(known | {"px_per_mm": 8.001}))


def change_sheet(folder):
    (folder / "a.sheet.toml").write_text("free_length_mm = 50\nthickness_mm = 0.22\n")


@pytest.mark.parametrize("change", few([change_picture, change_optics, change_sheet], first=2))
def test_what_was_made_of_something_else_is_measured_again(folder, tmp_path, change):
    batch(folder, tmp_path / "out")
    change(folder)
    result, count = batch(folder, tmp_path / "out")
    assert (count, result.kept) == (1, 4)
    batch(folder, tmp_path / "whole")
    assert results(tmp_path / "out") == results(tmp_path / "whole")
    assert batch(folder, tmp_path / "out")[1] == 0


@pytest.mark.parametrize("option", few([{"channel": "red"}, {"facts": {"tip_px": (500.0, 250.0)}}]))
def test_with_another_option_all_is_measured_again(folder, tmp_path, option):
    batch(folder, tmp_path / "out")
    result, count = batch(folder, tmp_path / "out", **option)
    assert (count, result.kept) == (5, 0)
    assert batch(folder, tmp_path / "out")[1] == 5  # and with those of before, once more


def test_with_another_version_of_labrig_all_is_measured_again(folder, tmp_path, monkeypatch):
    batch(folder, tmp_path / "out")
    monkeypatch.setattr("labrig.vision.batch.resuming._labrig", lambda: "another")
    assert batch(folder, tmp_path / "out")[1] == 5


def test_an_extractor_that_is_not_labrigs_own_measures_all_again(folder, tmp_path):
    for _ in range(2):
        find = Counting()
        result = extract_curves([folder], tmp_path / "out", BatchOptions(find=find))
        assert (find.count, result.kept) == (5, 0)
    assert not (tmp_path / "out" / "resume").exists()


def test_where_checks_of_others_look_at_curves_all_is_measured_again(folder, tmp_path, monkeypatch):
    batch(folder, tmp_path / "out")
    monkeypatch.setattr("labrig.vision.batch.curves.origins", lambda: {"check": "mylab 0.3"})
    assert batch(folder, tmp_path / "out")[1] == 5


def test_a_frame_that_is_refused_by_hand_has_the_film_measured_again(folder, tmp_path):
    out = tmp_path / "out"
    batch(folder, out)
    decided = {"film_000001": {"decision": "refused"}, "a": {"decision": "refused"}}
    (folder / REVIEW_FILE).write_text(json.dumps({"pictures": decided}))
    assert batch(folder, out)[1] == 2  # what is refused is not looked at
    batch(folder, tmp_path / "whole")
    assert results(out) == results(tmp_path / "whole")
    (folder / REVIEW_FILE).unlink()
    assert batch(folder, out)[1] == 4
    batch(folder, tmp_path / "whole")
    assert results(out) == results(tmp_path / "whole")


def test_results_that_were_removed_or_damaged_are_there_again(folder, tmp_path):
    out = tmp_path / "out"
    batch(folder, out)
    before = results(out)
    (out / "a.json").unlink()
    (out / "a_curve.png").unlink()
    kept = out / "resume" / "z.npz"
    kept.write_bytes(kept.read_bytes()[:-1000])
    (out / "resume" / "film_000001.npz").unlink()
    assert batch(folder, out)[1] == 2
    assert results(out) == before


def test_the_command_says_how_many_images_it_did_not_measure_again(folder, tmp_path, capsys):
    asked = ["curves", "--batch", str(folder), "-o", str(tmp_path / "out")]
    assert run(asked) == 0
    assert "6 images, 1 without a curve; wrote" in capsys.readouterr().out
    assert run(asked) == 0
    assert "6 images, 1 without a curve, 5 as measured before; wrote" in capsys.readouterr().out
    assert run([*asked, "--channel", "green"]) == 0
    assert "before" not in capsys.readouterr().out
