"""Losses are counted one by one, by the numbers that a camera gives its frames."""

import pytest

from drivers.cameras.frame_counter import FrameCounter


def counted(*frames: tuple[int, bool]) -> tuple[int, int]:
    counter = FrameCounter()
    for number, whole in frames:
        counter.count(number, whole=whole)
    return counter.incomplete, counter.missed


def whole(*numbers: int) -> list[tuple[int, bool]]:
    return [(number, True) for number in numbers]


@pytest.mark.parametrize(
    ("frames", "lost"),
    [
        (whole(7, 8, 9), (0, 0)),
        (whole(7, 9, 12), (0, 3)),
        ([(7, True), (8, False), (9, True)], (1, 0)),
        ([(7, True), (0, False), (9, True)], (1, 0)),  # its number was in the part that is missing
        ([(7, True), (0, False), (10, True)], (1, 1)),
        (whole(65534, 65535, 1, 2), (0, 0)),  # short numbers leave 0 out ...
        (whole(65535, 0, 1), (0, 0)),  # ... or do not
        (whole(65534, 2), (0, 2)),
        (whole(65535, 65536), (0, 0)),  # long numbers go on
        (whole(7, 9, 8, 10), (0, 0)),  # overtaken, not missed
        (whole(0, 1, 2), (0, 0)),
    ],
)
def test_losses(frames: list[tuple[int, bool]], lost: tuple[int, int]) -> None:
    assert counted(*frames) == lost


def test_incomplete_frames_of_unknown_number_are_not_missed_as_well() -> None:
    counter = FrameCounter()
    counter.count(1, whole=True)
    counter.count_incomplete()
    counter.count(4, whole=True)  # 2 or 3 came incomplete, the other never came
    assert (counter.incomplete, counter.missed) == (1, 1)
