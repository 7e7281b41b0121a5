"""How good the extractor is, on pictures drawn by `vision_scenes`; prints tables in Markdown.

    python -m benchmarks.vision_extraction accuracy     RMSE, bound, coverage by SNR
    python -m benchmarks.vision_extraction failures     silent failures and refusals
    python -m benchmarks.vision_extraction faces        the same where the sheet shows its far face
    python -m benchmarks.vision_extraction swings       mean images of a sheet that swings
    python -m benchmarks.vision_extraction speed        frames per second, cold and following
    python -m benchmarks.vision_extraction refusals     what a refusal costs, in cold searches

Run one at a time on a quiet machine; `--scenes N` sets how many, `--first SEED` which. `failures`
draws a fifth of N of every kind but the mixed one, unless `--kind NAME` asks for one only. Beside
what else there is: `python -m benchmarks vision_peers`.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks.vision_scenes import Recipe, Scene, make_scene, mixed, rmse_px
from labrig.vision import Optics, StripGeometry, neutral_curve


def parts(scene: Scene) -> tuple[Optics, StripGeometry]:
    mm = {key: value / 1000 for key, value in scene.strip.items()}
    strip = StripGeometry(
        free_length_m=mm["free_length_mm"],
        elongation_m=mm["elongation_mm"],
        thickness_m=mm["thickness_mm"],
    )
    return Optics.from_json(json.dumps(scene.optics)), strip


def curve_px_per_m(scene: Scene) -> float:
    return scene.recipe.px_per_mm * 1000


def signed_errors_px(curve, scene: Scene) -> np.ndarray:
    found = np.stack([curve.x_m, curve.y_m], axis=1) * 1000
    near = ((found[:, None] - scene.truth_mm[None, ::4]) ** 2).sum(axis=2).argmin(axis=1) * 4
    i = np.clip(near, 1, len(scene.truth_mm) - 2)
    tangent = scene.truth_mm[i + 1] - scene.truth_mm[i - 1]
    tangent /= np.hypot(*tangent.T)[:, None]
    gap = found - scene.truth_mm[i]
    across = gap[:, 1] * tangent[:, 0] - gap[:, 0] * tangent[:, 1]
    return across * scene.recipe.px_per_mm


def bound_px(curve, snr: float, thickness_px: float, blur_px: float) -> float:
    """Cramer-Rao: RMS error of a curve with these many free parameters, fitted to all pixels.

    The information of a pixel length of a blurred band is snr^2 int P'^2; m parameters over L
    pixels leave sqrt(m/(L info)).
    """
    from scipy.special import erf

    d = np.linspace(-15, 15, 6001)
    scale = np.sqrt(2) * blur_px
    p = 0.5 * (erf((d + thickness_px / 2) / scale) - erf((d - thickness_px / 2) / scale))
    information = snr**2 * np.trapezoid(np.gradient(p, d) ** 2, d)
    length = curve.s_m[-1] / (curve.s_m[1] - curve.s_m[0])
    return float(np.sqrt(len(curve.parameters) / length / information))


def accuracy(count: int, first: int = 0) -> None:
    print(
        "| SNR | RMSE median px | p95 px | bound px | ratio | band 95 % holds "
        "| curvature RMS median /m | p95 /m | its band 95 % holds |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for snr in (5, 10, 20, 40):
        errors, bounds, bends, inside, inside_k = [], [], [], [], []
        for seed in range(count):
            scene = make_scene(
                Recipe(seed=first + seed, physical=True, snr=snr, bright=seed % 2 == 0)
            )
            curve = neutral_curve(scene.image, *parts(scene))
            if not curve.ok:
                print(f"(seed {seed}: {curve.why})")
                continue
            miss = signed_errors_px(curve, scene)
            errors.append(np.sqrt(np.mean(miss**2)))
            r = scene.recipe
            bounds.append(bound_px(curve, snr, r.thickness_mm * r.px_per_mm, r.blur_px))
            k = np.interp(curve.s_m * 1000, scene.s_mm, scene.k_per_m)
            miss_k = curve.curvature_per_m - k
            bends.append(np.sqrt(np.mean(miss_k**2)))
            inside_k.append(np.mean(np.abs(miss_k) < 1.96 * curve.curvature_sigma_per_m))
            inside.append(np.mean(np.abs(miss) < 1.96 * curve.sigma_m * r.px_per_mm * 1000))
        ratio = np.sqrt(np.mean(np.square(errors)) / np.mean(np.square(bounds)))
        print(
            f"| {snr} | {np.median(errors):.4f} | {np.percentile(errors, 95):.4f} | "
            f"{np.median(bounds):.4f} | {ratio:.2f} | {np.mean(inside):.1%} | "
            f"{np.median(bends):.2f} | {np.percentile(bends, 95):.2f} | {np.mean(inside_k):.1%} |",
            flush=True,
        )


def faced(seed: int) -> Recipe:
    """A mixed scene whose sheet shows its far face, from hardly grey to a silhouette."""
    share = np.random.default_rng(77_000 + seed).choice([0.2, 0.35, 0.5, 0.7, 0.85, 1.0])
    return replace(mixed(seed), face=float(share))


MIXED = {
    "mixed": mixed,
    "no sheet": lambda s: replace(mixed(s), sheet=False, rolls=False),
    "no sheet, clutter": lambda s: replace(mixed(s), sheet=False, rolls=False, clutter=3 + s % 17),
    "sheet in clutter": lambda s: replace(mixed(s), clutter=2 + s % 10),
}


def wilson(hits: int, n: int) -> str:
    """A share's 95 % interval."""
    z2 = 1.96**2
    middle = hits / n + z2 / (2 * n)
    half = 1.96 * np.sqrt(hits * (n - hits) / n**3 + z2 / (4 * n**2))
    low, high = (max(0.0, (middle + sign * half) / (1 + z2 / n)) for sign in (-1, 1))
    return f"{low:.1%} to {high:.1%}"


def failures(count: int, first: int, kinds: dict[str, Callable[[int], Recipe]]) -> None:
    """Count silent failures (a curve off by more than a pixel, or without a sheet), refusals."""
    print(
        "| scenes | n | silent failures | 95 % interval | refused | 95 % interval "
        "| RMSE median px | p95 px |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for name, kind in kinds.items():
        n = silent = refused = 0
        errors = []
        many = count if name == "mixed" or len(kinds) == 1 else count // 5
        for seed in range(first, first + many):
            try:
                scene = make_scene(kind(seed))
            except RuntimeError:
                continue
            n += 1
            curve = neutral_curve(scene.image, *parts(scene))
            if not curve.ok:
                refused += 1
                if scene.recipe.sheet:
                    print(f"(refused: {name}, seed {seed}: {curve.why})", flush=True)
                continue
            errors.append(rmse_px(curve.points_px, scene.truth_px))
            if errors[-1] > 1 or not scene.recipe.sheet:
                silent += 1
                sigma = float(np.sqrt(np.mean(curve.sigma_m**2))) * curve_px_per_m(scene)
                said = f"{errors[-1]:.2f} px, its own sigma {sigma:.2f}"
                print(f"(silent: {name}, seed {seed}, {said})", flush=True)
        middle = f"{np.median(errors):.3f}" if errors else "-"
        high = f"{np.percentile(errors, 95):.3f}" if errors else "-"
        print(
            f"| {name} | {n} | {silent} | {wilson(silent, n)} | {refused} | {wilson(refused, n)} "
            f"| {middle} | {high} |",
            flush=True,
        )


def swings(count: int, first: int) -> None:
    """Mean images of a plain sheet whose tip swings by up to a pixel to each side."""
    print("| tip swings by, px | n | refused | face | RMSE median px | p95 px | 95 % band holds |")
    print("|---|---|---|---|---|---|---|")
    for swing in (0.25, 0.5, 0.75, 1.0):
        errors, inside, refused, faces = [], [], 0, 0
        for seed in range(first, first + count):
            snr = float(np.random.default_rng(seed).choice([10, 20, 40, 80]))
            scene = make_scene(
                Recipe(seed=seed, physical=True, snr=snr, bright=seed % 2 == 0, swing_px=swing)
            )
            curve = neutral_curve(scene.image, *parts(scene))
            if not curve.ok:
                refused += 1
                continue
            miss = signed_errors_px(curve, scene)
            errors.append(np.sqrt(np.mean(miss**2)))
            faces += bool(np.abs(curve.side_face_px).max() > 0)
            inside.append(
                np.mean(np.abs(miss) < 1.96 * curve.sigma_m * scene.recipe.px_per_mm * 1000)
            )
        # of whole images: neighbouring places of one image say the same
        spread = 1.96 * np.std(inside) / np.sqrt(len(inside))
        print(
            f"| {swing} | {count} | {refused} | {faces} | {np.median(errors):.4f} "
            f"| {np.percentile(errors, 95):.4f} | {np.mean(inside):.1%} ± {spread:.1%} |",
            flush=True,
        )


def speed(count: int) -> None:
    """Medians on one core, and as ratios to two of OpenCV's filters on the same picture."""
    import cv2

    cv2.setNumThreads(1)
    scene = make_scene(Recipe(seed=3, physical=True))
    optics, strip = parts(scene)
    first = neutral_curve(scene.image, optics, strip)
    neutral_curve(scene.image, optics, strip, start=first)
    work = {
        "GaussianBlur and Laplacian": lambda: cv2.Laplacian(
            cv2.GaussianBlur(scene.image, (0, 0), 1.2), cv2.CV_32F
        ),
        "cold": lambda: neutral_curve(scene.image, optics, strip),
        "following": lambda: neutral_curve(scene.image, optics, strip, start=first),
    }
    times: dict[str, list[float]] = {name: [] for name in work}
    for _ in range(count):  # in turns, so that whatever else runs slows all of them
        for name, run in work.items():
            begin = time.process_time()
            run()
            times[name].append(time.process_time() - begin)
    peer = np.median(times["GaussianBlur and Laplacian"])
    print("| | ms of processor time, median | least | frames/s | ratio |")
    print("|---|---|---|---|---|")
    for name, taken in times.items():
        middle = np.median(taken)
        print(
            f"| {name} | {middle * 1e3:.2f} | {min(taken) * 1e3:.2f} | {1 / middle:.0f} "
            f"| {middle / peer:.0f} |"
        )


def refusals(count: int, first: int) -> None:
    """Processor time of images without a sheet over that of a cold search on mixed scenes."""
    import cv2

    cv2.setNumThreads(1)

    def seconds(kind: str, seed: int) -> float | None:
        try:
            scene = make_scene(MIXED[kind](seed))
        except RuntimeError:
            return None
        begin = time.process_time()
        found = neutral_curve(scene.image, *parts(scene)).ok
        return time.process_time() - begin if found == scene.recipe.sheet else None

    kinds = ("mixed", "no sheet", "no sheet, clutter")
    for kind in kinds:  # what is compiled or loaded once costs no search
        seconds(kind, first)
    taken: dict[str, list[float]] = {kind: [] for kind in kinds}
    for seed in range(first + 1, first + 1 + count):  # in turns: other load slows all of them
        for kind in kinds:
            spent = seconds(kind, seed)
            if spent is not None:
                taken[kind].append(spent)
    cold = float(np.median(taken["mixed"]))
    print("| scenes | n | median, cold searches | 95 % below | most |")
    print("|---|---|---|---|---|")
    for kind in kinds:
        many = np.array(taken[kind]) / cold
        print(
            f"| {kind} | {len(many)} | {np.median(many):.2f} | {np.percentile(many, 95):.2f} "
            f"| {many.max():.2f} |"
        )
    print(f"a cold search: {cold * 1e3:.0f} ms of processor time")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "what", choices=("accuracy", "failures", "faces", "swings", "speed", "refusals")
    )
    parser.add_argument("--scenes", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="seed of the first scene")
    parser.add_argument("--kind", choices=list(MIXED), help="of failures: only this kind")
    given = parser.parse_args()
    if given.what == "speed":
        speed(given.scenes)
        return
    if given.what == "refusals":
        refusals(given.scenes, given.first)
    elif given.what == "swings":
        swings(given.scenes, given.first)
    elif given.what == "accuracy":
        accuracy(given.scenes, given.first)
    else:
        kinds = MIXED if given.what == "failures" else {"faces": faced}
        if given.kind and given.what == "failures":
            kinds = {given.kind: MIXED[given.kind]}
        failures(given.scenes, given.first, kinds)


if __name__ == "__main__":
    main()
