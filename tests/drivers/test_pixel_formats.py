"""Pixels as cameras send them become grey, packed by hand here from known levels."""

import numpy as np
import pytest

from drivers.cameras.pixel_formats import check_pixel_format, pixel_format
from drivers.interfaces import DeviceError

ROWS, COLUMNS = 3, 4


def levels(bits: int) -> np.ndarray:
    return np.random.default_rng(bits).integers(0, 1 << bits, ROWS * COLUMNS, dtype=np.uint16)


def bit_after_bit(values: np.ndarray, bits: int) -> bytes:
    """The lowest bit of the first pixel is the lowest bit of the first byte (PFNC `p`)."""
    whole = sum(int(value) << (k * bits) for k, value in enumerate(values))
    return whole.to_bytes((len(values) * bits + 7) // 8, "little")


def two_in_three(values: np.ndarray, bits: int) -> bytes:
    """GigE Vision: the high bytes of two pixels around a byte with their low bits."""
    low, raw = bits - 8, bytearray()
    for first, second in values.reshape(-1, 2).tolist():
        mask = (1 << low) - 1
        raw += bytes([first >> low, (second & mask) << 4 | first & mask, second >> low])
    return bytes(raw)


@pytest.mark.parametrize(
    ("name", "bits", "raw"),
    [
        ("Mono10", 10, lambda v, _: v.astype("<u2").tobytes()),
        ("Mono12", 12, lambda v, _: v.astype("<u2").tobytes()),
        ("Mono14", 14, lambda v, _: v.astype("<u2").tobytes()),
        ("Mono16", 16, lambda v, _: v.astype("<u2").tobytes()),
        ("Mono10p", 10, bit_after_bit),
        ("Mono12p", 12, bit_after_bit),
        ("Mono14p", 14, bit_after_bit),
        ("Mono10Packed", 10, two_in_three),
        ("Mono12Packed", 12, two_in_three),
    ],
)
def test_more_than_8_bit_fill_16(name, bits, raw):
    values = levels(bits)
    data = np.frombuffer(raw(values, bits), dtype=np.uint8)
    found = pixel_format(name)
    assert found.size(ROWS * COLUMNS) == data.size
    image = found.grey(data, ROWS, COLUMNS)
    assert image.dtype == np.uint16
    np.testing.assert_array_equal(image.ravel(), values << (16 - bits))


def test_8_bit_stay_8_in_memory_of_their_own():
    raw = np.arange(ROWS * COLUMNS + 5, dtype=np.uint8)  # a buffer may be longer
    image = pixel_format("Mono8").grey(raw, ROWS, COLUMNS)
    np.testing.assert_array_equal(image.ravel(), raw[: ROWS * COLUMNS])
    assert not np.shares_memory(image, raw)


@pytest.mark.parametrize("pattern", ["RG", "GR", "GB", "BG"])
@pytest.mark.parametrize("bits", [8, 12])
def test_a_bayer_pattern_gives_the_grey_of_its_colours(pattern, bits):
    """One colour everywhere: the mosaic has each pixel's own component."""
    colour = {"R": 200, "G": 100, "B": 40}
    (a, b), (c, d) = {"RG": ("RG", "GB"), "GR": ("GR", "BG"), "GB": ("GB", "RG"),
                      "BG": ("BG", "GR")}[pattern]  # fmt: skip
    tile = np.array([[colour[a], colour[b]], [colour[c], colour[d]]])
    mosaic = np.tile(tile, (4, 4)).astype(np.uint16) << (bits - 8)
    raw = mosaic.astype("u1" if bits == 8 else "<u2").tobytes()
    found = pixel_format(f"Bayer{pattern}{bits}")
    image = found.grey(np.frombuffer(raw, dtype=np.uint8), 8, 8)
    grey = 0.299 * 200 + 0.587 * 100 + 0.114 * 40
    scale = 1 if bits == 8 else 256
    np.testing.assert_allclose(image / scale, grey, atol=1.5)


def test_a_short_buffer_is_refused():
    with pytest.raises(DeviceError, match="has 5 bytes; 12 belong to it"):
        pixel_format("Mono8").grey(np.zeros(5, dtype=np.uint8), ROWS, COLUMNS)


@pytest.mark.parametrize("name", ["RGB8", "Mono9", "Mono16p", "mono8", "YUV422_8", "BayerXX8", ""])
def test_what_cannot_be_made_grey_is_refused(name):
    assert pixel_format(name) is None
    with pytest.raises(ValueError, match="must be a format such as"):
        check_pixel_format(name)
