"""A short run of the benchmark of what a camera on the network loses."""

from __future__ import annotations

import pytest

from tests.drivers.fake_gige import PACKAGE, needs_fake_camera

pytestmark = [
    needs_fake_camera,
    pytest.mark.system_package(PACKAGE),
    pytest.mark.alone,
    pytest.mark.thorough,
]


@pytest.mark.parametrize("lost_per_thousand", [0, 10])
def test_every_frame_came_whole_or_is_counted(lost_per_thousand: int) -> None:
    from benchmarks.camera_losses import received_with, uncounted

    found, _ = received_with(lost_per_thousand, 6.0)
    assert len(found.sent) > 100
    assert uncounted(found) == 0
    assert bool(sum(found.lost)) is bool(lost_per_thousand)
    assert not found.spoilt & set(found.whole)
