"""A world that is solved by motions of the plane: Magnus maps of a sheet's curvatures."""

from benchmarks.worlds.generators._magnus_further import FURTHER
from benchmarks.worlds.generators._magnus_known import KNOWN
from benchmarks.worlds.generators._magnus_noise import WAVE_M, RunNoise
from benchmarks.worlds.generators._magnus_specimen import LAYOUT, geometry, specimens
from benchmarks.worlds.generators._magnus_truth import FINER, taken_of
from benchmarks.worlds.session.world import SessionWorld

WORLD = SessionWorld(
    name="magnus",
    numerics=(
        "a product of plane motions, Magnus maps of fourth order of curvatures at Gauss points;"
        " least energy with a Lagrange multiplier, by Newton's iteration"
    ),
    noise=(
        "white noise of 0.022 mN a reading, converter steps of 0.012 mN, a zero with 1/f noise of"
        " 0.008 mN from two-state fluctuators, one reading in 80 astray by 0.1 mN; set-ups"
        " logistic; images of 0.033 mm a point, alike over a ninth of the curve, and their scale"
        " by 0.04 %"
    ),
    acts={**KNOWN, **FURTHER},
    layout=LAYOUT,
    sheets=specimens,
    geometry=geometry,
    taken=taken_of,
    run_noise=RunNoise,
    point_m=0.036e-3,
    wave_m=WAVE_M,
    finer=FINER,
)
