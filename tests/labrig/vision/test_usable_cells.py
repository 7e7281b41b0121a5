"""Which pieces of a curve are believed to show the sheet."""

from types import SimpleNamespace

import numpy as np

from labrig.vision.fit.context import CrossSection
from labrig.vision.fit.curve_fit import usable_cells


def test_odd_pieces_in_a_gap_are_not_the_sheet():
    """What is left of a wire beside its mask led a curve from one crossing to the other."""
    count = 300
    seen = np.ones(count, dtype=bool)
    seen[100:220] = False
    odd = seen.copy()
    odd[[118, 119, 123, 126, 130, 131, 132, 150, 151, 190]] = True
    section = CrossSection(
        half_width=np.full(count, 1.0),
        blur=0.8,
        elongation=np.zeros(count, dtype=bool),
        side_face=np.zeros(count),
    )
    cells = np.zeros((count, 10))
    cells[:, 0], cells[:, 5], cells[:, 6] = 80.0, 10.0, 2 * section.reach
    present = np.where(odd, 1.0, 0.3)
    cells[:, 6] *= present
    context = SimpleNamespace(sign=1.0, image=SimpleNamespace(downscaling=1))
    used = usable_cells(cells, present, context, section, noise=4.0)
    assert not used[100:220].any()
    assert used[5:98].all()
    assert used[222:-5].all()
