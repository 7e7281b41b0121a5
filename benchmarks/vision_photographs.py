"""`labrig curves` on photographs that nobody here took, against readings by hand.

    python -m benchmarks.vision_photographs FOLDER [--tuned | --untouched] [--clicks N] ...
    python -m benchmarks.vision_photographs FOLDER --direction --half 1

The photographs are in public repositories, named in benchmarks/photographs/traces.json with their
licences; they are not copied here. FOLDER holds them as OWNER+NAME/PATH. Each is measured with the
clamp's place and a ruler, and with nothing else; `--direction` states a second place on the strip;
`--clicks N` states the tip and N places between it and the clamp, as somebody does who corrects a
curve (each up to 2 pixels off the reading); `--length` the length, of strips that end in the image.
Right: within 2 pixels of the hand reading at each of its 13 places, and ended within 3 % of the
length (and 3 pixels) of its last one; where the strip leaves the picture, anywhere beyond it.
`--half` takes the photographs of half of the repositories, by the hash of their names: 0 to choose
by, 1 to judge by.
"End doubted": it ended elsewhere, and a warning says that the strip may go on there.
Ends inside the image are also counted that lie further than three `end_sigma_m` from the reading's.
What each takes is counted in cold searches, too: on mixed drawn scenes, as `vision_extraction
refusals` does, and on an easy drawn picture of its size, both in the same run.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._cold_search import ColdSearches, summary
from labrig.extractors.choice import BUILT_IN, chosen_extractor
from labrig.vision import NeutralCurve, Optics, StripGeometry, write_overlay
from labrig.vision.checks.kinds.strip_goes_on import CHECK as STRIP_GOES_ON
from labrig.vision.image.reading import read_image

SEARCH_EVERY = 15  # photographs: cold searches on mixed scenes, in turns
TRACES = Path(__file__).parent / "photographs" / "traces.json"
RIGHT_PX = 2.0
END_SHARE_MAX, END_MIN_PX = 0.03, 3.0  # of the length: where the end may be seen along the strip
SIGMA_SHARE_MIN = 1 / 3  # of the error; a smaller sigma is a silent error
END_SIGMAS_MAX = 3.0  # from an end to the reading's
READING_PX = 1.0  # how well an end is read, along the strip
CLICK_PX = 2.0  # how far off the reading a click may be
RULER_MM = 50.0  # the length that every strip is given: scale plays no part in what is found


@dataclass(frozen=True, kw_only=True)
class Photograph:
    """One picture with its hand reading."""

    name: str
    kind: str
    half: int  # 0 or 1, by its repository
    tuned_on: bool
    image: np.ndarray
    trace_px: np.ndarray  # (places, 2) from the clamp on
    leaves_image: bool  # the strip goes on beyond the last place, to the border

    @property
    def length_px(self) -> float:
        return _length(self.trace_px)


def load(folder: Path) -> list[Photograph]:
    """Read all that are there; a missing or changed file is named and left out."""
    found = []
    for entry in json.loads(TRACES.read_text(encoding="utf-8"))["photographs"]:
        path = folder / entry["repository"].replace("/", "+") / entry["path"]
        if not path.exists():
            print(f"(missing: {path})")
        elif hashlib.sha256(path.read_bytes()).hexdigest() != entry["sha256"]:
            print(f"(not the file that was traced: {path})")
        else:
            found.append(
                Photograph(
                    name=entry["name"],
                    kind=entry["kind"],
                    half=_half(entry["repository"]),
                    tuned_on=entry["tuned_on"],
                    image=_picture(path, entry),
                    trace_px=np.array(entry["trace_px"]),
                    leaves_image=entry.get("leaves_image", False),
                )
            )
    return found


def _half(repository: str) -> int:
    return int(hashlib.sha256(repository.encode()).hexdigest(), 16) % 2


def _picture(path: Path, entry: dict[str, Any]) -> np.ndarray:
    import cv2

    if path.suffix == ".h5":
        import h5py

        with h5py.File(path) as file:
            return np.asarray(file["video"][entry["frame"]])
    image = _frame(path, entry["frame"]) if "frame" in entry else read_image(path)
    if "crop_px" in entry:
        u, v, width, height = entry["crop_px"]
        image = image[v : v + height, u : u + width]
    by = entry.get("reduced", 1)
    rows, columns = image.shape[0] // by, image.shape[1] // by
    if by == 1:
        return np.ascontiguousarray(image)
    return np.asarray(
        cv2.resize(
            image[: rows * by, : columns * by], (columns, rows), interpolation=cv2.INTER_AREA
        )
    )


def _frame(path: Path, number: int) -> np.ndarray:
    import cv2

    video = cv2.VideoCapture(str(path))
    video.set(cv2.CAP_PROP_POS_FRAMES, number)
    return np.asarray(video.read()[1])


def errors_px(curve: NeutralCurve, trace: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Return distance from each place of the hand reading to the curve, sigma there, and the end's.

    Both ends are led on straight: how far the curve is too short or too long is the last number.
    """
    points = curve.points_px
    along = np.linspace(0, len(points) - 1, 20 * len(points))
    dense = np.stack([np.interp(along, np.arange(len(points)), points[:, i]) for i in (0, 1)], 1)
    sigma = np.interp(along, np.arange(len(points)), curve.sigma_m)
    few = max(2, len(points) // 30)
    reach = np.linspace(0, 1, 100)[1:, None] * max(END_MIN_PX, END_SHARE_MAX * _length(points))
    ends = [points[0] - points[few], points[-1] - points[-1 - few]]
    first, last = (end / np.hypot(*end) for end in ends)
    dense = np.concatenate([points[0] + reach[::-1] * first, dense, points[-1] + reach * last])
    sigma = np.pad(sigma, len(reach), mode="edge")
    gap = np.hypot(*(dense[:, None] - trace[None]).transpose(2, 0, 1))
    nearest = gap.argmin(axis=0)
    scale = curve.s_m[-1] / _length(points)  # m a pixel
    end = float((points[-1] - trace[-1]) @ last)
    error = gap.min(axis=0)
    # a place beyond the curve's end is not misplaced: the end is
    missing = (np.cumsum(np.arange(len(trace)) > 0) > len(trace) // 2) & (end < -reach[-1])
    missing &= (trace - points[-1]) @ last > reach[-1]
    return np.where(missing, 0.0, error), sigma[nearest] / scale, end


def _length(points: np.ndarray) -> float:
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def verdict(curve: NeutralCurve, photograph: Photograph) -> tuple[str, str]:
    """Return right, wrong, silent or refused, and the figures.

    What is wrong and ended elsewhere, with a warning of that, is as wrong, but its end is doubted.
    """
    if not curve.ok:
        return "refused", curve.why
    error, sigma, end = errors_px(curve, photograph.trace_px)
    worst = int(error.argmax())
    text = f"{np.median(error):.2f} (at most {error[worst]:.2f}, sigma there {sigma[worst]:.2f})"
    text += f", end {end:+.1f}"
    allowed = max(END_MIN_PX, END_SHARE_MAX * photograph.length_px)
    ended = end >= -allowed if photograph.leaves_image else abs(end) <= allowed
    if error[worst] <= RIGHT_PX and ended:
        return "right", text
    silent = (error > RIGHT_PX) & (sigma < SIGMA_SHARE_MIN * error)
    doubted = ", end doubted" if not ended and end_doubted(curve) else ""
    return ("silent" if silent.any() else "wrong") + doubted, text


def end_doubted(curve: NeutralCurve) -> bool:
    """Return whether a warning of the curve says that the strip may go on beyond its end."""
    begin = STRIP_GOES_ON.warning.split("{")[0]
    return any(text.startswith(begin) for text in curve.warnings)


def end_sigmas(curve: NeutralCurve, photograph: Photograph) -> float:
    """Return how far a curve's end lies from the reading's along the strip, in its own sigmas."""
    px_per_m = _length(curve.points_px) / curve.s_m[-1]
    end = errors_px(curve, photograph.trace_px)[2]
    return float(abs(end) / max(curve.end_sigma_m * px_per_m, READING_PX))


def asked(
    photograph: Photograph, *, direction: bool, clicks: int | None = None, length: bool = False
) -> tuple[Optics, StripGeometry]:
    """Return the optics and strip of somebody who states clamp and ruler, and no more.

    With a number of clicks: also the tip, and so many places on the strip. `length`: that, too.
    """
    trace = photograph.trace_px
    rows, columns = photograph.image.shape[:2]
    optics: dict[str, Any] = {
        "px_per_mm": photograph.length_px / RULER_MM,
        "clamp_px": tuple(np.round(trace[0])),
        "image_size": (columns, rows),
        "clamp_angle_known": direction,
        "clamp_sigma_px": 3.0,
    }
    if direction:
        du, dv = trace[1] - trace[0]
        optics["roll_rad"] = math.atan2(dv, du)
        optics["clamp_angle_sigma_rad"] = 0.1
    if clicks is not None:
        at = np.linspace(0, len(trace) - 1, clicks + 2)[1:].round().astype(int)
        aside = np.random.default_rng(len(trace)).uniform(-CLICK_PX, CLICK_PX, (len(at), 2))
        inside = np.clip(trace[at] + aside, 0, (columns - 1, rows - 1))  # as a click is
        *through, tip = map(tuple, np.round(inside, 1))
        optics |= {"through_px": tuple(through) or None, "tip_px": tip}
    return Optics(**optics), StripGeometry(
        free_length_m=RULER_MM / 1000, length_known=length, thickness_known=False
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--tuned", action="store_true", help="only what was tuned on")
    parser.add_argument("--untouched", action="store_true", help="only what was not")
    parser.add_argument("--direction", action="store_true", help="state the direction, too")
    parser.add_argument("--clicks", type=int, help="state the tip, and so many places before it")
    parser.add_argument("--length", action="store_true", help="state the length, too")
    parser.add_argument("--half", type=int, choices=(0, 1), help="of the repositories")
    parser.add_argument("--extractor", default=BUILT_IN, help="which finds the curves")
    parser.add_argument("--overlays", type=Path)
    options = parser.parse_args()
    import cv2

    cv2.setNumThreads(1)
    chosen = chosen_extractor(options.extractor)
    counts: dict[str, int] = {}
    right_doubted = 0
    ends: list[float] = []
    searches, taken = ColdSearches(), list[tuple[float, float, bool]]()
    print("| photograph | kind | result | error, px | CPU s |\n|---|---|---|---|---|")
    for photograph in load(options.folder):
        if (options.tuned and not photograph.tuned_on) or (
            options.untouched and photograph.tuned_on
        ):
            continue
        if options.half is not None and photograph.half != options.half:
            continue
        if options.length and photograph.leaves_image:
            continue
        known = asked(
            photograph,
            direction=options.direction,
            clicks=options.clicks,
            length=options.length,
        )
        if not taken:  # what is compiled or loaded once costs no search
            chosen.curve(photograph.image, *known)
        began = time.process_time()
        curve = chosen.curve(photograph.image, *known)
        spent = time.process_time() - began
        if len(taken) % SEARCH_EVERY == 0:
            searches.search_mixed()
        taken.append((spent, searches.easy_s(*photograph.image.shape[:2]), not curve.ok))
        result, text = verdict(curve, photograph)
        counts[result] = counts.get(result, 0) + 1
        if curve.ok and not photograph.leaves_image:
            ends.append(end_sigmas(curve, photograph))
        right_doubted += result == "right" and end_doubted(curve)
        print(f"| {photograph.name} | {photograph.kind} | {result} | {text} | {spent:.2f} |")
        if options.overlays is not None:
            options.overlays.mkdir(parents=True, exist_ok=True)
            name = photograph.name.replace(" ", "_")
            write_overlay(options.overlays / f"{name}.png", photograph.image, curve)
    print("; ".join(f"{count} {result}" for result, count in counts.items()))
    print(f"{right_doubted} of the right ones have the warning that the strip may go on")
    far = sum(each > END_SIGMAS_MAX for each in ends)
    print(f"{far} of {len(ends)} ends inside the image are {END_SIGMAS_MAX:g} of their sigmas off")
    if taken:
        print(summary(searches, taken))


if __name__ == "__main__":
    main()
