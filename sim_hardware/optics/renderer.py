"""Images of the sheet."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from sim_hardware.optics import backdrop
from sim_hardware.optics.geometry import FloatArray, Geometry, smooth_polyline
from sim_hardware.optics.layer import BandLayer, Image
from sim_hardware.optics.marker import write_marker
from sim_hardware.optics.settings import FarFace, OpticsSettings

# Part of the lens's blur goes into the edges of the bands before they are sampled: a sharp edge,
# sampled, would carry the band's middle up to 0.03 px off, and no later blur brings that back.
_EDGE_BLUR_PX = 0.5
_PIXEL_VARIANCE = 1 / 12

Contact = tuple[float, float, float]
"""x and y in m of the point between the rolls, and the sheet's direction there in rad."""

Band = tuple[FloatArray, FloatArray, FloatArray]
"""Points (n, 2) in undistorted pixels, half widths (n,) and grey levels (n,)."""


class Renderer:
    """Draws frames: bands with soft edges, two-dimensional blur, uneven light, then the sensor.

    A frame depends only on the settings, the seed and the arguments of `render`, so frames may be
    rendered in any order, and again. Not for several threads at once.
    """

    def __init__(self, settings: OpticsSettings, seed: int = 0) -> None:
        from sim_hardware.optics import kernels

        self.settings = settings
        self._kernels = kernels
        self._seed = seed % (1 << 63)
        self._geometry = Geometry(settings)
        self._columns, self._rows = settings.image_size
        self._gain = backdrop.light_gain(settings).ravel()
        self._glare = backdrop.glare(settings).ravel()
        self._jaws = backdrop.jaws(settings, self._geometry)
        edge_blur = min(settings.blur_px, _EDGE_BLUR_PX)
        self._blur_left_px = math.sqrt(settings.blur_px**2 - edge_blur**2)
        softness = math.sqrt(edge_blur**2 + _PIXEL_VARIANCE)
        self._layer = BandLayer(self._columns, self._rows, softness)
        self._lit_m, self._lit_level = self._light_along_the_sheet()

    def render(
        self,
        shapes: Sequence[FloatArray],
        contact: Contact | None,
        number: int,
        *,
        sheet_length_m: float = math.inf,
        time_s: float | None = None,
    ) -> npt.NDArray[np.uint8]:
        """Return a frame (rows, columns).

        `shapes`: the neutral curve (n, 2) in m from the clamp to the end of the elongation, at
        instants spread over the exposure. `sheet_length_m`: where along it the sheet ends and the
        elongation begins. `time_s`: written into the marker, if the settings ask for one.
        """
        background = self.settings.background_level
        image = np.full(self._rows * self._columns, background, dtype=np.float32)
        bands = [self._band(shape, sheet_length_m) for shape in shapes]
        for band in bands:
            if self.settings.far_face is not None:
                self._draw_far_face(band, self.settings.far_face)
                self._layer.add(1 / len(bands))
            pixels, half, level = band
            self._layer.draw(self._geometry.distort(pixels), half, level)
            self._layer.add(1 / len(bands))
        self._layer.lay_over(image)
        if contact is not None and self.settings.rolls.visible:
            self._draw_rolls(image, contact, sheet_length_m)
        frame = image.reshape(self._rows, self._columns)
        if self._jaws is not None:
            self._jaws.draw(frame)
        return self._expose(self._blurred(frame), number, time_s)

    def _light_along_the_sheet(self) -> tuple[FloatArray, FloatArray]:
        """Places along the sheet and its grey level there: waves of 2-8 mm, drawn by the seed."""
        random = np.random.default_rng((self._seed, 0x0971C5))
        lengths, phases = random.uniform(2e-3, 8e-3, 6), random.uniform(0, 2 * np.pi, 6)
        at = np.arange(0, 0.2, 1e-4)
        waves = np.cos(at[:, None] * (2 * np.pi / lengths) + phases).sum(1) / math.sqrt(3)
        return at, self.settings.sheet_level * (1 + self.settings.light.unevenness * waves)

    def _band(self, shape: FloatArray, sheet_length_m: float) -> Band:
        """Return the sheet with its elongation."""
        s = self.settings
        points, at = smooth_polyline(shape, 1 / self._geometry.px_per_m)
        on_sheet = at <= sheet_length_m
        half = np.where(on_sheet, s.sheet_thickness_m, s.elongation_thickness_m) / 2
        lit = np.interp(at, self._lit_m, self._lit_level)
        pixels = self._geometry.to_undistorted(points)
        if self._jaws is not None:
            # The sheet goes on a little under the jaws, so that no background shows at their edge.
            pixels[0] += 2 * (pixels[0] - pixels[1])
        return pixels, half * self._geometry.px_per_m, np.where(on_sheet, lit, s.elongation_level)

    def _draw_far_face(self, band: Band, face: FarFace) -> None:
        """Draw what shows beside a band of the surface that it sweeps as it shrinks with depth.

        It shrinks towards the image's centre, which keeps its directions. The strip begins at the
        band's edge, so that none of it shines through.
        """
        pixels, half, level = band
        size = 1 / (1 + face.depth_m / face.distance_m)
        along = np.gradient(pixels, axis=0)
        along /= np.maximum(np.hypot(*along.T), 1e-12)[:, None]
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        away = (size - 1) * (pixels - self._geometry.centre_px)
        aside = np.sum(away * across, axis=1)
        shown = np.maximum(np.abs(aside) - (1 - size) * half, 0.0)
        middle = pixels + (np.sign(aside) * (half + shown / 2))[:, None] * across
        middle += np.sum(away * along, axis=1)[:, None] / 2 * along
        self._layer.draw(self._geometry.distort(middle), shown / 2, np.full_like(level, face.level))

    def _draw_rolls(self, image: Image, contact: Contact, sheet_length_m: float) -> None:
        x, y, angle = contact
        rolls = self.settings.rolls
        # The straight distance to the contact is close enough to the arc length.
        on_sheet = math.hypot(x, y) <= sheet_length_m
        held_m = (
            self.settings.sheet_thickness_m if on_sheet else self.settings.elongation_thickness_m
        )
        away = rolls.radius_m + held_m / 2
        for side in (-away, away):
            centre = (x - side * math.sin(angle), y + side * math.cos(angle))
            u, v = self._geometry.to_pixels([centre])[0]
            scale = self._geometry.px_per_m
            disc = self._kernels.Disc(
                u=float(u),
                v=float(v),
                radius=rolls.radius_m * scale,
                level=rolls.level,
                rim=rolls.rim_m * scale,
                rim_level=rolls.rim_level,
            )
            self._kernels.draw_disc(image, self._columns, disc)

    def _blurred(self, frame: Image) -> Image:
        import cv2

        sigma = self._blur_left_px
        if sigma == 0:
            return frame
        blurred = cv2.GaussianBlur(frame, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE)
        return np.asarray(blurred, dtype=np.float32)

    def _expose(self, frame: Image, number: int, time_s: float | None) -> npt.NDArray[np.uint8]:
        image = np.empty((self._rows, self._columns), dtype=np.uint8)
        noise = self.settings.noise
        sensor = self._kernels.Sensor(
            seed=self._seed,
            number=number,
            shot_variance_per_level=1 / noise.electrons_per_level,
            read_variance=noise.read_levels**2,
        )
        self._kernels.expose(frame.ravel(), self._gain, self._glare, sensor, image.ravel())
        if self.settings.marker:
            write_marker(image, number, time_s)
        return image
