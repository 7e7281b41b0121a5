"""How good the extractor is, on pictures drawn by `vision_scenes`; prints tables in Markdown.

    python -m benchmarks.vision_extraction accuracy     RMSE, bound, coverage by SNR
    python -m benchmarks.vision_extraction failures     silent and reported failures
    python -m benchmarks.vision_extraction speed        frames per second, cold and following

Run one at a time on a quiet machine; `--scenes N` sets how many, `--first SEED` which. Beside what
else there is: `python -m benchmarks vision_peers`.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import replace

import numpy as np

from benchmarks.vision_scenes import Recipe, Scene, make_scene, mixed, rmse_px
from labrig.vision import Optics, StripGeometry, neutral_curve


def parts(scene: Scene) -> tuple[Optics, StripGeometry]:
    mm = {key: value / 1000 for key, value in scene.strip.items()}
    strip = StripGeometry(mm["free_length_mm"], mm["elongation_mm"], mm["thickness_mm"])
    return Optics.from_json(json.dumps(scene.optics)), strip


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
        "| SNR | RMSE median px | p95 px | bound px | ratio | curvature RMS /m | band 95 % holds |"
    )
    print("|---|---|---|---|---|---|---|")
    for snr in (5, 10, 20, 40):
        errors, bounds, bends, inside = [], [], [], []
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
            bends.append(np.sqrt(np.mean((curve.curvature_per_m - k) ** 2)))
            inside.append(np.mean(np.abs(miss) < 1.96 * curve.sigma_m * r.px_per_mm * 1000))
        ratio = np.sqrt(np.mean(np.square(errors)) / np.mean(np.square(bounds)))
        print(
            f"| {snr} | {np.median(errors):.4f} | {np.percentile(errors, 95):.4f} | "
            f"{np.median(bounds):.4f} | {ratio:.2f} | {np.median(bends):.2f} | "
            f"{np.mean(inside):.1%} |"
        )


def failures(count: int, first: int = 0) -> None:
    kinds = {
        "mixed": mixed,
        "no sheet": lambda s: replace(mixed(s), sheet=False, rolls=False),
        "no sheet, clutter": lambda s: replace(
            mixed(s), sheet=False, rolls=False, clutter=3 + s % 17
        ),
        "sheet in clutter": lambda s: replace(mixed(s), clutter=2 + s % 10),
    }
    print("| scenes | n | ok | silent failures | reported | RMSE median px | p95 px |")
    print("|---|---|---|---|---|---|---|")
    for name, kind in kinds.items():
        n = silent = reported = 0
        errors = []
        for seed in range(first, first + (count if name == "mixed" else count // 5)):
            try:
                scene = make_scene(kind(seed))
            except RuntimeError:
                continue
            n += 1
            curve = neutral_curve(scene.image, *parts(scene))
            if not curve.ok:
                reported += 1
                if scene.recipe.sheet:
                    print(f"(refused: {name}, seed {seed}: {curve.why})", flush=True)
                continue
            errors.append(rmse_px(curve.points_px, scene.truth_px))
            if errors[-1] > 1 or not scene.recipe.sheet:
                silent += 1
                print(f"(silent: {name}, seed {seed}, {errors[-1]:.2f} px)", flush=True)
        middle = f"{np.median(errors):.3f}" if errors else "-"
        high = f"{np.percentile(errors, 95):.3f}" if errors else "-"
        print(
            f"| {name} | {n} | {len(errors)} | {silent} | {reported} | {middle} | {high} |",
            flush=True,
        )


def speed(count: int) -> None:
    scene = make_scene(Recipe(seed=3, physical=True))
    optics, strip = parts(scene)
    first = neutral_curve(scene.image, optics, strip)
    neutral_curve(scene.image, optics, strip, start=first)
    for name, start in (("cold", None), ("following", first)):
        wall, cpu = time.perf_counter(), time.process_time()
        for _ in range(count):
            neutral_curve(scene.image, optics, strip, start=start)
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        print(
            f"{name}: {wall / count * 1000:.1f} ms, {count / wall:.0f} frames/s by the clock; "
            f"{cpu / count * 1000:.1f} ms, {count / cpu:.0f} frames/s of processor time"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("accuracy", "failures", "speed"))
    parser.add_argument("--scenes", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="seed of the first scene")
    given = parser.parse_args()
    if given.what == "speed":
        speed(given.scenes)
        return
    {"accuracy": accuracy, "failures": failures}[given.what](given.scenes, given.first)


if __name__ == "__main__":
    main()
