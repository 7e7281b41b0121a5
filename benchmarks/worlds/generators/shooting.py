"""A world that is solved by shooting from the clamp."""

from benchmarks.worlds.generators._shooting_further import FURTHER
from benchmarks.worlds.generators._shooting_known import KNOWN
from benchmarks.worlds.generators._shooting_noise import POINT_M, WAVE_M, RunNoise
from benchmarks.worlds.generators._shooting_specimen import LAYOUT, geometry, specimens
from benchmarks.worlds.generators._shooting_truth import FINER, taken_of
from benchmarks.worlds.session.world import SessionWorld

WORLD = SessionWorld(
    name="shooting",
    numerics=(
        "shooting from the clamp, Dormand-Prince 8(5,3) with step control, Newton for the contact"
    ),
    noise=(
        "Gaussian: white noise of 0.03 mN a reading, a zero that wanders by 0.01 mN over 7 to"
        " 300 s, images of 0.04 mm a point, shifted by 0.02 mm from one set-up to the next"
    ),
    acts={**KNOWN, **FURTHER},
    layout=LAYOUT,
    sheets=specimens,
    geometry=geometry,
    taken=taken_of,
    run_noise=RunNoise,
    point_m=POINT_M,
    wave_m=WAVE_M,
    finer=FINER,
)
