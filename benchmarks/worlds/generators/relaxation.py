"""A world whose sheets are solved by relaxation: box scheme on three grids, extrapolated.

Equations in `_relaxation_grid`, what lies beyond the contact and shapes in `_relaxation_shape`,
noise in `_relaxation_noise`, sheets and times in `_relaxation_specimen`. What can be hidden is in
`_relaxation_known*` and `_relaxation_beyond*`; how it acts in `_relaxation_acting` and
`_relaxation_truth`.
"""

from __future__ import annotations

from benchmarks.worlds.generators import _relaxation_beyond as beyond
from benchmarks.worlds.generators import _relaxation_beyond_rig as beyond_rig
from benchmarks.worlds.generators import _relaxation_known as known
from benchmarks.worlds.generators import _relaxation_known_rig as known_rig
from benchmarks.worlds.generators._relaxation_noise import POINT_M, SHAKE_M, WAVE_M, RunNoise
from benchmarks.worlds.generators._relaxation_specimen import LAYOUT, geometry, strips
from benchmarks.worlds.generators._relaxation_truth import FINER, taken
from benchmarks.worlds.session.world import SessionWorld

WORLD = SessionWorld(
    name="relaxation",
    numerics=(
        "Keller's box scheme with 16, 32 and 64 cells, relaxed by Newton's method, extrapolated"
    ),
    noise=(
        "white, with the steps of a meter, a zero that wanders within seconds and stray readings;"
        " curves whose neighbouring points err together, a beat of pixels and edge, frames that"
        " shake; set-ups with a logistic scatter of EIBM 1.2 %, B 0.8 %, position 0.06 mm"
    ),
    acts={
        **known.SHEET, **known.COURSE, **known_rig.CONTACT, **known_rig.CELL, **known_rig.CAMERA,
        **beyond.NAMELESS, **beyond_rig.CELL, **beyond_rig.CAMERA,
    },
    layout=LAYOUT,
    sheets=strips,
    geometry=geometry,
    taken=taken,
    run_noise=RunNoise,
    point_m=float((POINT_M**2 + SHAKE_M**2) ** 0.5),
    wave_m=WAVE_M,
    finer=FINER,
)  # fmt: skip
