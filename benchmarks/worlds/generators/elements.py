"""A world that is solved by finite elements."""

from benchmarks.worlds.generators._elements_further import FURTHER
from benchmarks.worlds.generators._elements_known import KNOWN
from benchmarks.worlds.generators._elements_noise import POINT_M, WAVE_M, RunNoise
from benchmarks.worlds.generators._elements_specimen import LAYOUT, geometry, specimens
from benchmarks.worlds.generators._elements_truth import FINER, taken_of
from benchmarks.worlds.session.world import SessionWorld

WORLD = SessionWorld(
    name="elements",
    numerics=(
        "geometrically exact finite elements, quadratic in the direction, on a mesh that stretches"
        " to the contact; Newton's iteration with a Lagrange multiplier"
    ),
    noise=(
        "Student's t of 4 degrees, 0.03 mN a reading, each correlated by 0.4 with the one before;"
        " mains hum of 0.01 mN; set-ups of 6 degrees; images of 0.04 mm a point, neighbours alike"
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
