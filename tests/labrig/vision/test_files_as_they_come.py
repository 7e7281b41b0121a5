"""Photographs, stacks and videos as cameras and programs write them, and the tables of them."""

import csv
import json
import math
import os
import struct
import subprocess
import sys
from dataclasses import replace

import cv2
import numpy as np
import pytest
from PIL import Image, ImageOps

from labrig.cli.main import run
from labrig.errors import BadInputError, LabrigWarning
from labrig.vision import (
    BatchOptions,
    NeutralCurve,
    Optics,
    StripGeometry,
    extract_curves,
    neutral_curve,
    read_image,
)
from labrig.vision.batch.curves import curves_of
from labrig.vision.calibration.drawing import write_drawing
from labrig.vision.image.image import read_grey_image
from labrig.vision.image.library_messages import without_lines_of_libraries
from labrig.vision.image.names import PictureLabel
from labrig.vision.image.reading import pictures_in
from labrig.vision.image.tables import (
    mean_curvature_per_m,
    tip_angle_rad,
    write_points,
    write_summary,
)
from tests.cases import few

IMAGE_WIDTH = 256  # TIFF: the tag of the number of columns
SIDEWAYS = 6  # EXIF: to be turned clockwise by a quarter


def marked(rows=30, columns=50):
    """Return an image with its upper left bright."""
    image = np.zeros((rows, columns), np.uint8)
    image[:10, :10] = 200
    return image


def saved_sideways(image, path):
    """Write a picture as a camera does that was held upright: turned, with a note in its EXIF."""
    exif = Image.Exif()
    exif[0x0112] = SIDEWAYS
    turned = Image.fromarray(np.rot90(image).copy())
    turned.save(path, exif=exif, **({"quality": 98} if path.suffix == ".jpg" else {}))


def arc(curvature_per_m=40.0, length_m=0.05, elongation_m=0.0, points=101):
    """Return an arc of a circle as a curve, with a straight rest; its middle was bridged."""
    s = np.linspace(0, length_m + elongation_m, points)
    k = np.where(s <= length_m, curvature_per_m, 0.0)
    phi = curvature_per_m * np.minimum(s, length_m)
    step = np.diff(s)
    middle = 0.5 * (phi[1:] + phi[:-1])
    seen = np.ones(points, dtype=bool)
    seen[40:60] = False
    return NeutralCurve(
        ok=True,
        s_m=s,
        x_m=np.append(0, np.cumsum(np.cos(middle) * step)),
        y_m=np.append(0, np.cumsum(np.sin(middle) * step)),
        curvature_per_m=k,
        sigma_m=np.full(points, 2e-5),
        curvature_sigma_per_m=np.full(points, 0.7),
        points_px=np.zeros((points, 2)),
        seen=seen,
        covered=0.8,
        free_length_m=length_m,
        warnings=("the tip is near the image's border",),
    )


def answer(image, optics, strip, *, start=None):
    """Return the arc for a bright image, and a refusal for a dark one."""
    return arc() if image.mean() > 10 else NeutralCurve(ok=False, why="the image is dark.")


def table(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "optics.json").write_text('{"px_per_mm": 8, "clamp_px": [5, 5]}')
    (tmp_path / "sheet.toml").write_text("free_length_mm = 50\n")
    return tmp_path


def test_a_path_may_be_text(tmp_path):
    cv2.imwrite(str(tmp_path / "strip.png"), marked())
    assert np.array_equal(read_image(str(tmp_path / "strip.png")), marked())


@pytest.mark.parametrize("suffix", [".jpg", ".png", ".webp"])
def test_a_photograph_is_turned_as_its_exif_states(tmp_path, suffix):
    path = tmp_path / f"held_upright{suffix}"
    saved_sideways(marked(), path)
    image = read_image(path)
    assert image.shape[:2] == (30, 50)
    assert image[2:8, 2:8].mean() > 150
    assert image[-8:, -8:].mean() < 50


@pytest.mark.slow
def test_a_turned_photograph_and_one_of_16_bit_and_one_of_floats_give_the_same_curve(
    tmp_path, plain, scenes
):
    (tmp_path / "optics.json").write_text(json.dumps(plain.optics))
    (tmp_path / "sheet.toml").write_text("free_length_mm = 50\nthickness_mm = 0.21\n")
    saved_sideways(plain.image, tmp_path / "turned.png")
    cv2.imwrite(str(tmp_path / "deep.tif"), plain.image.astype(np.uint16) * 257)
    cv2.imwrite(str(tmp_path / "unit.tiff"), plain.image.astype(np.float32) / 255)
    result = extract_curves([tmp_path], tmp_path / "out", BatchOptions(overlays=False))
    assert list(result.curves) == ["deep", "turned", "unit"]
    assert result.failed == {}
    for curve in result.curves.values():
        assert scenes.rmse_px(curve.points_px, plain.truth_px) < 0.05
    same = result.curves["turned"].points_px
    np.testing.assert_allclose(result.curves["unit"].points_px, same, atol=1e-3)


def test_floats_that_are_levels_stay_as_they_are(folder):
    given = []

    def find(image, optics, strip, *, start=None):
        given.append((image.dtype, float(image.max())))
        return arc()

    for name, most in (("levels", 180.0), ("unit", 0.5)):
        cv2.imwrite(str(folder / f"{name}.tif"), np.full((30, 50), most, np.float32))
    list(curves_of([folder], BatchOptions(find=find)))
    assert given == [(np.float32, 180.0), (np.float32, 127.5)]


def test_in_python_floats_from_0_to_1_are_told():
    image = (marked(200, 300) + 30) / 255
    optics = Optics(px_per_mm=8.0, clamp_px=(80.0, 100.0))
    why = neutral_curve(image, optics, StripGeometry(free_length_m=0.02)).why
    assert "multiply floats from 0 to 1 by 255, or check lens cap" in why


def test_in_python_an_image_may_have_its_bytes_the_other_way_round():
    """As FITS files and some TIFF have them; it was said to have neither 8 nor 16 bits."""
    image = (marked(200, 300) + 30).astype(np.uint16) * 256
    optics = Optics(px_per_mm=8.0, clamp_px=(80.0, 100.0))
    strip = StripGeometry(free_length_m=0.02)
    whys = [neutral_curve(one, optics, strip).why for one in (image, image.astype(">u2"))]
    assert whys[0] == whys[1]
    assert "values" not in whys[1]
    turned = read_grey_image(image.astype(">u2"), optics)
    np.testing.assert_array_equal(turned.grey, read_grey_image(image, optics).grey)


def test_each_page_of_a_tiff_is_an_image(folder):
    pages = [marked() + 30, marked() * 0, marked() + 30]
    cv2.imwritemulti(str(folder / "stack.tif"), pages)
    result = extract_curves([folder], folder / "out", BatchOptions(find=answer))
    assert list(result.curves) == ["stack:1", "stack:2", "stack:3"]
    assert list(result.failed) == ["stack:2"]
    written = sorted(p.name for p in (folder / "out").glob("*.json"))
    assert written == ["stack_page0001.json", "stack_page0002.json", "stack_page0003.json"]
    second = json.loads((folder / "out" / "stack_page0002.json").read_text())
    assert (second["image"], second["frame"]) == ("stack:2", 2)
    thirds = curves_of([folder / "stack.tif"], BatchOptions(find=answer, every=2))
    assert [label.name for label, _, _ in thirds] == ["stack:1", "stack:3"]


def test_pages_of_16_bit_keep_their_depth(tmp_path):
    pages = [np.full((20, 30), level, np.uint16) for level in (300, 40000)]
    cv2.imwritemulti(str(tmp_path / "deep.tif"), pages)
    found = list(pictures_in(tmp_path / "deep.tif"))
    assert [int(picture.image.max()) for picture in found] == [300, 40000]


def test_pages_of_a_large_tiff_with_big_endians_are_read_too(tmp_path):
    tifffile = pytest.importorskip("tifffile")
    shades = np.stack([np.full((30, 50), level, np.uint8) for level in (60, 90)])
    tifffile.imwrite(tmp_path / "big.tif", shades, bigtiff=True, byteorder=">", metadata=None)
    found = list(pictures_in(tmp_path / "big.tif"))
    assert [int(picture.image.max()) for picture in found] == [60, 90]


def test_a_page_that_is_damaged_costs_that_page_only(folder):
    path = folder / "stack.tif"
    shades = [np.full((30, 50), level, np.uint8) for level in (60, 90, 120)]
    cv2.imwritemulti(str(path), shades)
    data = bytearray(path.read_bytes())
    columns = _entry_of_page(data, 2, IMAGE_WIDTH)
    data[columns + 8 : columns + 12] = b"\0\0\0\0"
    path.write_bytes(data)
    result = extract_curves([path], folder / "out", BatchOptions(find=answer))
    assert {name: curve.ok for name, curve in result.curves.items()} == {
        "stack:1": True,
        "stack:2": False,
        "stack:3": True,
    }
    assert "page 2 is damaged" in result.failed["stack:2"]


def test_pages_that_run_in_a_circle_are_read_once(tmp_path):
    path = tmp_path / "circle.tif"
    cv2.imwritemulti(str(path), [np.full((30, 50), level, np.uint8) for level in (60, 90)])
    data = bytearray(path.read_bytes())
    place = int.from_bytes(data[4:8], "little")
    after = place + 2 + 12 * int.from_bytes(data[place : place + 2], "little")
    second = int.from_bytes(data[after : after + 4], "little")
    last = second + 2 + 12 * int.from_bytes(data[second : second + 2], "little")
    data[last : last + 4] = data[4:8]
    path.write_bytes(data)
    assert [picture.label.name for picture in pictures_in(path)] == ["circle:1", "circle:2"]


def _entry_of_page(data, page, tag):
    """Return where an entry of a page's directory is, of a small TIFF with little endians."""
    place = int.from_bytes(data[4:8], "little")
    for number in range(1, page + 1):
        entries = int.from_bytes(data[place : place + 2], "little")
        for entry in range(place + 2, place + 2 + 12 * entries, 12):
            if number == page and int.from_bytes(data[entry : entry + 2], "little") == tag:
                return entry
        after = place + 2 + 12 * entries
        place = int.from_bytes(data[after : after + 4], "little")
    raise AssertionError("no such page")


def film(path, frames=5, rate=25, shape="1:1", interlaced="p"):
    header = f"YUV4MPEG2 W64 H48 F{rate}:1 I{interlaced} A{shape} Cmono\n".encode()
    shades = (np.full((48, 64), 100 + 10 * n, np.uint8).tobytes() for n in range(frames))
    path.write_bytes(header + b"".join(b"FRAME\n" + shade for shade in shades))


def test_the_frames_of_a_video_have_their_times(folder):
    film(folder / "film.y4m")
    result = extract_curves([folder], folder / "out", BatchOptions(find=answer, overlays=False))
    assert list(result.curves) == [f"film_{n:06d}" for n in range(5)]
    lines = table(folder / "out" / "summary.csv")
    assert [line["frame"] for line in lines] == ["0", "1", "2", "3", "4"]
    assert [float(line["time_s"]) for line in lines] == pytest.approx([0, 0.04, 0.08, 0.12, 0.16])


def test_each_nth_frame_keeps_its_number_and_time(folder, capsys):
    film(folder / "film.y4m")
    made = ["--summary", str(folder / "s.csv"), "--every", "2", "--json"]
    assert run(["curves", str(folder / "film.y4m"), *made]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [(line["image"], line["time_s"]) for line in lines] == [
        ("film_000000", 0.0),
        ("film_000002", 0.08),
        ("film_000004", 0.16),
    ]
    assert [line["state"] for line in table(folder / "s.csv")] == ["refused"] * 3


@pytest.mark.parametrize("suffix", [".webm", ".m4v"])
def test_a_video_of_another_container_is_read_as_one(folder, suffix):
    film(folder / f"film{suffix}")  # what it is FFmpeg sees by its content
    assert len(list(pictures_in(folder / f"film{suffix}"))) == 5


def test_an_animated_gif_has_frames_with_times(folder):
    frames = [Image.fromarray(marked() + rise) for rise in (0, 20, 40)]
    frames[0].save(folder / "gif.gif", save_all=True, append_images=frames[1:], duration=80)
    read = list(pictures_in(folder / "gif.gif"))
    assert [picture.label.time_s for picture in read] == pytest.approx([0, 0.08, 0.16])
    assert [int(picture.image.min()) for picture in read] == pytest.approx([0, 20, 40], abs=3)


def tiff_of_4_bits(image):
    """Return a TIFF of 4 bits a pixel, which OpenCV does not read."""
    rows, columns = image.shape
    pixels = (image[:, ::2] << 4 | image[:, 1::2]).astype(np.uint8).tobytes()
    entries = [
        (256, columns), (257, rows), (258, 4), (259, 1), (262, 1), (273, 8), (277, 1),
        (278, rows), (279, len(pixels)),
    ]  # fmt: skip
    directory = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in entries)
    header = struct.pack("<2sHI", b"II", 42, 8 + len(pixels))
    return header + pixels + struct.pack("<H", len(entries)) + directory + bytes(4)


def test_a_tiff_of_4_bits_is_read(folder):
    image = marked() // 16
    (folder / "few.tif").write_bytes(tiff_of_4_bits(image))
    read = read_image(folder / "few.tif")
    assert np.array_equal(read, image * 17)  # from 0 to 255


def test_the_colours_of_a_tiff_that_opencv_does_not_read_are_in_its_order(folder, monkeypatch):
    colours = np.zeros((8, 8, 3), np.uint8)
    colours[..., 0] = 250  # red
    Image.fromarray(colours).save(folder / "red.tif")
    monkeypatch.setattr(cv2, "imdecode", lambda data, flags: None)
    assert read_image(folder / "red.tif")[0, 0].tolist() == [0, 0, 250]


def test_a_damaged_tiff_is_refused_in_our_sentence_alone(folder, recwarn):
    whole = tiff_of_4_bits(marked() // 16)
    (folder / "cut.tif").write_bytes(whole[:-70])
    with pytest.raises(BadInputError, match="not an image, or damaged"):
        read_image(folder / "cut.tif")
    assert not recwarn.list


def test_a_header_that_states_too_many_pixels_is_refused(folder):
    data = bytearray(cv2.imencode(".bmp", marked())[1].tobytes())
    data[18:26] = struct.pack("<ii", 2**20, 2**20)  # columns, rows
    (folder / "large.bmp").write_bytes(data)
    with pytest.raises(BadInputError, match="not an image, or damaged"):
        read_image(folder / "large.bmp")


def test_a_video_without_a_frame_has_a_row_that_says_so(folder):
    film(folder / "film.y4m", frames=0)
    result = extract_curves([folder], folder / "out", BatchOptions(find=answer))
    assert list(result.failed) == ["film"]
    assert table(folder / "out" / "summary.csv")[0]["state"] == "refused"


def test_points_say_what_was_seen_and_bridged_and_what_was_refused(tmp_path):
    labels = [PictureLabel(name=name, file_stem=name, frame=3, time_s=0.12) for name in "ab"]
    refused = NeutralCurve(ok=False, why="the strip was not found, anywhere.")
    write_points(tmp_path / "curves.csv", [(labels[0], arc()), (labels[1], refused)])
    rows = table(tmp_path / "curves.csv")
    states = [row["state"] for row in rows]
    assert states == ["seen"] * 40 + ["bridged"] * 20 + ["seen"] * 41 + ["refused"]
    assert float(rows[5]["curvature_sigma_per_m"]) == pytest.approx(0.7)
    assert (rows[5]["frame"], rows[5]["time_s"]) == ("3", "0.120000")
    assert rows[-1]["image"] == "b"
    assert rows[-1]["reason"] == "the strip was not found, anywhere."
    assert rows[-1]["x_mm"] == rows[-1]["point"] == ""


def test_a_summary_has_a_line_for_each_picture(folder):
    cv2.imwrite(str(folder / "bright.png"), marked() + 30)
    cv2.imwrite(str(folder / "dark.png"), marked() * 0)
    extract_curves([folder], folder / "out", BatchOptions(find=answer))
    bright, dark = table(folder / "out" / "summary.csv")
    assert (bright["image"], bright["state"], bright["reason"]) == ("bright", "found", "")
    assert float(bright["tip_x_mm"]) == pytest.approx(1e3 * math.sin(2) / 40, abs=0.01)
    assert float(bright["tip_y_mm"]) == pytest.approx(1e3 * (1 - math.cos(2)) / 40, abs=0.01)
    assert float(bright["tip_angle_deg"]) == pytest.approx(math.degrees(2), abs=0.01)
    assert float(bright["mean_curvature_per_m"]) == pytest.approx(40, abs=0.01)
    assert bright["warnings"] == "the tip is near the image's border"
    assert (dark["state"], dark["reason"]) == ("refused", "the image is dark.")
    assert dark["tip_x_mm"] == ""


def test_a_summary_has_the_length_and_thickness_that_were_measured(tmp_path):
    to_end = replace(arc(), end_sigma_m=4e-4, thickness_m=6e-4)
    label = PictureLabel(name="a", file_stem="a")
    write_summary(tmp_path / "summary.csv", [(label, to_end), (label, arc())])
    measured, stated = table(tmp_path / "summary.csv")
    names = ("length_mm", "length_sigma_mm", "thickness_mm")
    assert [measured[name] for name in names] == ["50.000000", "0.400000", "0.600000"]
    assert [stated[name] for name in names] == ["50.000000", "", ""]


def test_the_angle_of_a_tip_counts_whole_turns():
    assert tip_angle_rad(arc(curvature_per_m=160.0)) == pytest.approx(8.0, abs=1e-6)


def test_a_rigid_elongation_does_not_lower_the_mean_curvature():
    assert mean_curvature_per_m(arc(elongation_m=0.05)) == pytest.approx(40, rel=1e-3)


def test_the_picture_of_a_calibration_is_not_measured(folder):
    picture = folder / "strip.png"
    cv2.imwrite(str(picture), marked(200, 300) + 30)
    ruler = ["--ruler-px", "20,20,220,20", "--ruler-mm", "25", "--clamp-px", "80,100"]
    made = folder / "strip.optics.json"
    assert run(["calibrate", "camera", str(picture), *ruler, "-o", str(made)]) == 0
    drawing = cv2.imread(str(made.with_suffix(".png")))
    assert (drawing != cv2.imread(str(picture))).any()  # it has the grid on it
    for again in range(2):  # nor are the overlays of a batch into the same folder
        result = extract_curves([folder], folder, BatchOptions(find=answer))
        assert list(result.curves) == ["strip"], again
    assert (folder / "strip_curve.png").exists()


def test_a_photograph_named_as_an_overlay_is_measured(folder):
    cv2.imwrite(str(folder / "second_curve.png"), marked() + 30)
    assert list(extract_curves([folder], folder / "out", BatchOptions(find=answer)).curves) == [
        "second_curve"
    ]


def test_a_name_too_long_for_the_results_beside_it_is_refused_in_a_sentence(folder):
    path = folder / f"{'y' * 246}.png"
    try:
        cv2.imwrite(str(folder / "short.png"), marked() + 30)
        (folder / "short.png").rename(path)
    except OSError:
        pytest.skip("this disk has no such names")
    with pytest.raises(BadInputError, match=r"this name is too long for those of .*; shorten it"):
        extract_curves([folder], folder / "out", BatchOptions(find=answer))


def test_no_overlay_replaces_a_photograph(folder):
    for name in ("second", "second_curve"):
        cv2.imwrite(str(folder / f"{name}.png"), marked() + 30)
    before = (folder / "second_curve.png").read_bytes()
    with pytest.raises(BadInputError, match="would be written over"):
        extract_curves([folder], folder, BatchOptions(find=answer))
    assert (folder / "second_curve.png").read_bytes() == before
    assert len(extract_curves([folder], folder / "out", BatchOptions(find=answer)).curves) == 2


@pytest.mark.parametrize("pair", [("film.y4m", "film_000001.png"), ("a.tif", "a_page0002.png")])
def test_a_picture_named_as_a_frame_or_page_is_refused(folder, pair):
    for name in pair:
        (folder / name).write_bytes(b"")
    with pytest.raises(BadInputError, match="both would be written"):
        extract_curves([folder], folder / "out", BatchOptions(find=answer))
    (folder / pair[0]).unlink()
    extract_curves([folder], folder / "out", BatchOptions(find=answer))


def test_the_picture_of_a_calibration_replaces_no_photograph(folder, capsys):
    picture = folder / "strip.png"
    cv2.imwrite(str(picture), marked(200, 300) + 30)
    before = picture.read_bytes()
    ruler = ["--ruler-px", "20,20,220,20", "--ruler-mm", "25", "--clamp-px", "80,100"]
    made = ["-o", str(folder / "strip.json")]
    assert run(["calibrate", "camera", str(picture), *ruler, *made]) == 2
    assert "strip.png: this image would be overwritten" in capsys.readouterr().err
    assert picture.read_bytes() == before
    assert not (folder / "strip.json").exists()
    made = ["-o", str(folder / "strip.optics.json")]
    for _ in range(2):  # a drawing of its own is replaced
        assert run(["calibrate", "camera", str(picture), *ruler, *made]) == 0


def test_a_calibration_that_is_replaced_is_kept(folder, capsys):
    cv2.imwrite(str(folder / "strip.png"), marked(200, 300) + 30)
    (folder / "optics.json").write_text('{"px_per_mm": 8, "clamp_px": [80, 100], "mask_px": []}')
    ruler = ["--ruler-px", "20,20,220,20", "--ruler-mm", "25", "--clamp-px", "80,100"]
    asked = ["calibrate", "camera", str(folder / "strip.png"), *ruler]
    for clamp_too in ([], [], ["--along-px", "120,100"]):  # the second one changes nothing
        assert run([*asked, *clamp_too, "-o", str(folder / "optics.json")]) == 0
    first, second = sorted(folder.glob("optics.json.*.bak"), key=lambda kept: len(kept.name))
    assert "mask_px" in first.read_text()
    assert json.loads(second.read_text())["clamp_angle_known"] is False
    assert capsys.readouterr().out.count("the one before is") == 2


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("colours", [3, 1])
def test_what_is_transparent_is_white_as_viewers_show_it(tmp_path, dtype, colours):
    top = np.iinfo(dtype).max
    alpha = (marked() > 0).astype(dtype) * top
    if colours == 3:
        cv2.imwrite(str(tmp_path / "cut.png"), np.dstack([0 * alpha] * 3 + [alpha]))
    else:  # grey with alpha, which OpenCV does not write
        Image.fromarray(np.dstack([alpha * 0, alpha]).astype(np.uint8), "LA").save(
            tmp_path / "cut.png"
        )
        top = 255
    image = read_image(tmp_path / "cut.png")
    assert image.max() == top
    assert ((image == 0) == (np.dstack([alpha] * 3) > 0 if image.ndim == 3 else alpha > 0)).all()


@pytest.mark.parametrize("suffix", [".png", ".webp"])
@pytest.mark.parametrize("orientation", few([SIDEWAYS, 1, 2, 3, 4, 5, 7, 8]))
def test_what_is_transparent_is_turned_as_the_exif_states_and_white(tmp_path, suffix, orientation):
    colours = np.dstack([marked() // 2] * 3 + [np.where(marked() > 0, 255, 0)]).astype(np.uint8)
    exif = Image.Exif()
    exif[0x0112] = orientation
    saved = Image.fromarray(colours, "RGBA")
    saved.save(tmp_path / f"cut{suffix}", exif=exif, lossless=True)
    upright = np.asarray(ImageOps.exif_transpose(Image.open(tmp_path / f"cut{suffix}")))
    image = read_image(tmp_path / f"cut{suffix}")
    assert np.array_equal(image[..., 0], np.where(upright[..., 3] > 0, 100, 255))


@pytest.mark.parametrize("suffix", [".HEIC", ".heif"])
def test_a_photograph_in_heic_is_refused_with_what_to_do(folder, suffix):
    for name in ("strip", "both"):
        (folder / f"{name}{suffix}").write_bytes(b"\0\0\0\x18ftypheic\0\0\0\0mif1heic" + bytes(40))
    cv2.imwrite(str(folder / "both.png"), marked() + 30)
    (folder / "sheet.toml").write_text("free_length_mm = 50\n")
    found = extract_curves([folder], folder / "out", BatchOptions(overlays=False, find=answer))
    assert list(found.curves) == ["both", "strip"]  # not twice what is there as PNG, too
    assert list(found.failed) == ["strip"]
    assert "HEIC, which labrig does not read; save it as JPEG or PNG." in found.failed["strip"]


@pytest.mark.parametrize(
    ("written", "said"),
    [
        (["--overlay", "strip.png"], "strip.png: this image would be overwritten"),
        (["--overlay", "curve.jpg"], "an overlay is PNG; name it curve.png"),
        (["-o", "strip.png"], "a table is CSV; name it strip.csv"),
        (["-o", "strip.xlsx"], "a table is CSV; name it strip.csv"),
        (["-o", "new"], "a table is CSV; name it new.csv"),
        (["--summary", "optics.json"], "a table is CSV; name it optics.csv"),
        (["-o", "a.csv", "--summary", "a.csv"], "two tables; name two files"),
        (["--batch", ".", "-o", "out", "--json"], "leave --json and --overlay out"),
        (["--batch", ".", "-o", "out", "--overlay", "a.png"], "leave --json and --overlay out"),
    ],
)
def test_nothing_is_written_over_a_photograph_or_what_is_known_of_it(
    folder, monkeypatch, capsys, written, said
):
    cv2.imwrite(str(folder / "strip.png"), marked(200, 300) + 30)
    (folder / "sheet.toml").write_text("free_length_mm = 50\n")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    monkeypatch.chdir(folder)
    assert run(["curves", "strip.png", *written]) == 2
    assert said in capsys.readouterr().err
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_tables_are_whole_or_not_there(folder):
    cv2.imwrite(str(folder / "bright.png"), marked() + 30)
    (folder / "out" / "summary.csv").mkdir(parents=True)
    with pytest.raises(BadInputError, match=r"summary\.csv: cannot be written"):
        extract_curves([folder], folder / "out", BatchOptions(find=answer))


def test_of_an_image_that_was_cut_short_there_is_our_sentence_alone(tmp_path, capfd):
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_WARNING)
    whole = cv2.imencode(".png", np.arange(4096, dtype=np.uint8).reshape(64, 64))[1].tobytes()
    (tmp_path / "cut.png").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(BadInputError, match="not an image, or damaged"):
        read_image(tmp_path / "cut.png")
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("damage", few(["data", "end"]))
def test_of_a_damaged_png_there_is_our_sentence_alone(tmp_path, capfd, damage):
    whole = bytearray(cv2.imencode(".png", marked())[1].tobytes())
    if damage == "data":
        whole[len(whole) // 2] ^= 255
    (tmp_path / "bad.png").write_bytes(whole if damage == "data" else whole[:-12])
    with pytest.raises(BadInputError, match="not an image, or damaged"):
        read_image(tmp_path / "bad.png")
    assert capfd.readouterr().err == ""


def jpeg():
    noise = np.random.default_rng(3).integers(0, 256, (96, 160), dtype=np.uint8)
    return cv2.imencode(".jpg", noise)[1].tobytes()


@pytest.mark.parametrize("damage", few([b"\xff\xd3", b"\xff\xd9"]))
def test_a_jpeg_that_has_lost_a_part_of_its_picture_is_refused(tmp_path, capfd, damage):
    whole = jpeg()
    half = len(whole) // 2
    (tmp_path / "bad.jpg").write_bytes(whole[:half] + damage + whole[half + len(damage) :])
    with pytest.raises(BadInputError, match=r"bad\.jpg: this JPEG is damaged, and a part of its"):
        read_image(tmp_path / "bad.jpg")
    assert capfd.readouterr().err == ""


def test_a_jpeg_that_has_lost_bytes_before_a_restart_marker_is_refused(tmp_path):
    restarts = [cv2.IMWRITE_JPEG_RST_INTERVAL, 4]
    whole = cv2.imencode(
        ".jpg", cv2.imdecode(np.frombuffer(jpeg(), np.uint8), cv2.IMREAD_UNCHANGED), restarts
    )[1].tobytes()
    marker = whole.index(b"\xff\xd3")
    (tmp_path / "good.jpg").write_bytes(whole)
    assert read_image(tmp_path / "good.jpg").shape == (96, 160)
    (tmp_path / "bad.jpg").write_bytes(whole[: marker - 60] + whole[marker - 30 :])
    with pytest.raises(BadInputError, match="a part of its picture is lost"):
        read_image(tmp_path / "bad.jpg")


def test_a_jpeg_with_bytes_that_nobody_needs_is_read(tmp_path, capfd):
    whole = jpeg()
    (tmp_path / "good.jpg").write_bytes(whole)
    (tmp_path / "odd.jpg").write_bytes(whole[:-2] + b"\0\0\0" + whole[-2:])
    assert np.array_equal(read_image(tmp_path / "odd.jpg"), read_image(tmp_path / "good.jpg"))
    assert capfd.readouterr().err == ""


@pytest.mark.slow
def test_of_a_file_that_is_no_film_there_is_our_sentence_alone(folder):
    (folder / "no.mp4").write_bytes(b"no film")
    # the tests' own setting makes FFmpeg silent
    told = {key: value for key, value in os.environ.items() if key != "OPENCV_FFMPEG_LOGLEVEL"}
    asked = [sys.executable, "-m", "labrig", "curves", "no.mp4"]
    done = subprocess.run(asked, cwd=folder, env=told, capture_output=True, text=True, check=True)
    assert done.stdout == "no: no curve: no.mp4: not a video that OpenCV can open.\n"
    assert done.stderr == ""


def coloured_film(path, codec="MJPG", frames=6):
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*codec), 25, (320, 240))
    for frame in range(frames):
        image = np.full((240, 320, 3), 220, dtype=np.uint8)
        cv2.line(image, (20, 120), (300, 100 + 5 * frame), (30, 60, 90), 3)
        writer.write(image)
    writer.release()


def test_a_video_that_was_cut_short_says_how_much_of_it_was_read(folder):
    coloured_film(folder / "film.avi")
    data = (folder / "film.avi").read_bytes()
    (folder / "film.avi").write_bytes(data[: len(data) // 2])
    read = list(pictures_in(folder / "film.avi"))
    assert 1 <= len(read) - 1 < 5
    assert all(picture.image is not None for picture in read[:-1])
    assert read[-1].why == (
        f"{folder / 'film.avi'}: this video is damaged or cut short: after frame {len(read) - 2}"
        " none could be read; copy it again."
    )


def hidden_by_an_edit_list(path):
    """Write a video as telephones do that was trimmed: its edit list shows the end alone."""
    coloured_film(path, "mp4v")
    data = bytearray(path.read_bytes())
    entry = data.index(b"elst") + 12
    scale = struct.unpack_from(">I", data, data.index(b"mdhd") + 16)[0]
    data[entry + 4 : entry + 8] = struct.pack(">I", 3 * scale // 25)
    path.write_bytes(data)


def dropped_in_recording(path):
    """Write a video that states more frames than it has, as where a camera left some out."""
    coloured_film(path)
    data = bytearray(path.read_bytes())
    at = data.index(b"strh") + 40
    assert struct.unpack_from("<I", data, at) == (6,)
    data[at : at + 4] = struct.pack("<I", 600)
    path.write_bytes(data)


@pytest.mark.parametrize(
    ("write", "name", "frames"),
    [(hidden_by_an_edit_list, "film.mp4", 3), (dropped_in_recording, "film.avi", 6)],
)
def test_a_whole_video_that_states_frames_it_does_not_show_is_not_cut_short(
    tmp_path, write, name, frames
):
    write(tmp_path / name)
    read = list(pictures_in(tmp_path / name))
    assert [picture.why for picture in read] == [""] * frames


def test_the_times_of_a_video_begin_with_its_first_frame(tmp_path):
    coloured_film(tmp_path / "film.avi")
    data = bytearray((tmp_path / "film.avi").read_bytes())
    start = data.index(b"strh") + 36
    data[start : start + 4] = struct.pack("<I", 2)
    (tmp_path / "film.avi").write_bytes(data)
    times = [picture.label.time_s for picture in pictures_in(tmp_path / "film.avi")]
    assert times == pytest.approx([0, 0.04, 0.08, 0.12, 0.16, 0.20])


def test_a_video_whose_pixels_are_not_square_is_told(tmp_path):
    film(tmp_path / "film.y4m", shape="4:3")
    with pytest.warns(LabrigWarning, match="its pixels are 1.33 times as wide as high"):
        assert len(list(pictures_in(tmp_path / "film.y4m"))) == 5


def told_of(name, folder):
    """Return the lines of a video's frames where FFmpeg is not made silent, as it is in tests."""
    told = {key: value for key, value in os.environ.items() if key != "OPENCV_FFMPEG_LOGLEVEL"}
    asked = [sys.executable, "-m", "labrig", "curves", name]
    done = subprocess.run(asked, cwd=folder, env=told, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    return done.stdout.splitlines()


@pytest.mark.slow
def test_the_frames_of_an_interlaced_video_are_refused(folder):
    film(folder / "film.y4m", frames=2, interlaced="t")
    assert told_of("film.y4m", folder) == [
        f"film_00000{frame}: no curve: film.y4m: frame {frame} is interlaced (made of two half "
        "pictures), which OpenCV cannot convert; convert the video first, as `ffmpeg -i OLD -vf "
        "yadif NEW` does."
        for frame in range(2)
    ]


@pytest.mark.slow
def test_a_fault_beside_the_picture_of_a_frame_refuses_none_and_a_frame_cut_short_is(folder):
    whole = jpeg()
    exif = b"Exif\0\0II*\0" + bytes(range(20))
    odd = whole[:2] + b"\xff\xe1" + struct.pack(">H", 2 + len(exif)) + exif + whole[2:]
    (folder / "film.mjpg").write_bytes(odd + odd + whole[: len(whole) // 2])
    lines = told_of("film.mjpg", folder)
    assert len(lines) == 3
    assert [line for line in lines if "damaged" in line] == [
        "film_000002: no curve: film.mjpg: frame 2 is damaged; those after it may be, too."
    ]


@pytest.mark.slow
def test_a_frame_of_a_video_that_ffmpeg_conceals_is_refused_in_our_sentence_alone(folder):
    coloured_film(folder / "film.avi", frames=4)
    data = bytearray((folder / "film.avi").read_bytes())
    pictures = [at for at in range(len(data) - 3) if data[at : at + 3] == b"\xff\xd8\xff"]
    for at in range(pictures[2] + 1000, pictures[2] + 1500, 7):
        data[at] ^= 0x5A
    (folder / "film.avi").write_bytes(data)
    lines = told_of("film.avi", folder)
    assert len(lines) == 4
    assert [line for line in lines if "damaged" in line] == [
        "film_000002: no curve: film.avi: frame 2 is damaged; those after it may be, too."
    ]


def test_what_others_write_while_libraries_decode_is_kept(capfd):
    with without_lines_of_libraries():
        os.write(2, b"libpng error: IDAT: CRC error\na line of the log\nlibpng warning: iCCP\n")
    assert capfd.readouterr().err == "a line of the log\n"


def test_images_and_a_film_of_one_name_are_measured_and_named_by_their_whole_names(folder, capsys):
    for name in ("same.png", "same.jpg", "other.bmp"):
        cv2.imwrite(str(folder / name), marked() + 30)
    film(folder / "same.y4m", frames=2)
    cv2.imwritemulti(str(folder / "same.tif"), [marked() + 30] * 2)
    out = folder / "out"
    extract_curves([folder], out, BatchOptions(find=answer))
    stems = ["other", "same.jpg", "same.png", "same.tif_page0001", "same.tif_page0002"]
    stems += ["same.y4m_000000", "same.y4m_000001"]
    assert sorted(path.stem for path in out.glob("*.json")) == stems
    assert sorted(path.name for path in out.glob("*.png")) == [f"{n}_curve.png" for n in stems]
    names = ["other", "same.jpg", "same.png", "same.tif:1", "same.tif:2"]
    assert [row["image"] for row in table(out / "summary.csv")] == [*names, *stems[5:]]
    (folder / "curves_review.json").write_text(
        '{"pictures": {"same.png": {"decision": "refused", "note": "blurred"}}}'
    )
    assert run(["curves", str(folder / "same.png")]) == 0  # also where it is measured alone
    assert capsys.readouterr().out.startswith("same.png: no curve: refused by hand")


def test_of_images_of_one_name_each_has_a_file_of_its_own_or_both_have_one(folder):
    scales = []

    def find(image, optics, strip, *, start=None):
        scales.append(optics.px_per_mm)
        return arc()

    for name in ("same.png", "same.jpg"):
        cv2.imwrite(str(folder / name), marked() + 30)
    (folder / "same.optics.json").write_text('{"px_per_mm": 3, "clamp_px": [5, 5]}')
    (folder / "same.png.optics.json").write_text('{"px_per_mm": 4, "clamp_px": [5, 5]}')
    extract_curves([folder], folder / "out", BatchOptions(find=find))
    assert scales == [3, 4]  # of same.jpg, then of same.png


def test_a_drawing_of_labrig_is_no_second_image_of_a_name(folder):
    cv2.imwrite(str(folder / "strip.jpg"), marked() + 30)
    write_drawing(folder / "strip.png", marked())
    found = extract_curves([folder], folder / "out", BatchOptions(find=answer))
    assert list(found.curves) == ["strip"]


def test_corrections_that_belong_to_no_image_of_a_folder_are_named(folder, capsys):
    cv2.imwrite(str(folder / "new.png"), marked() + 30)
    cv2.imwritemulti(str(folder / "stack.tif"), [marked() + 30] * 2)
    film(folder / "film.y4m")
    known = '{"px_per_mm": 8, "clamp_px": [5, 5]}'
    for name in ("new", "new.png", "old", "camera"):
        (folder / f"{name}.optics.json").write_text(known)
    (folder / "old.sheet.toml").write_text("free_length_mm = 50\n")
    decided = {name: {"decision": "accepted"} for name in ("old", "new", "stack:2", "film_000003")}
    (folder / "curves_review.json").write_text(json.dumps({"pictures": decided}))
    camera = ["--optics", str(folder / "camera.optics.json")]
    assert run(["curves", "--batch", str(folder), "-o", str(folder / "out"), *camera]) == 0
    said = [line for line in capsys.readouterr().err.splitlines() if "belong" in line]
    assert len(said) == 1
    assert said[0].endswith(
        "old.optics.json, old.sheet.toml and 'old' of curves_review.json belong to no image there "
        "and are not used; name them as the image is named."
    )
