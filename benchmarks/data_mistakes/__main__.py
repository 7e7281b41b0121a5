"""How often a wrong datum is told rightly, and how often one is told where there is none.

python -m benchmarks.data_mistakes [--sessions 20] [--seed 1] [--good 0]

Each mistake is made in sessions with nothing hidden, of several kinds. Good sessions are those of
the suite of hidden effects: nothing hidden, single effects up to d = 120, realistic gaps, pairs and
effects outside the catalogue.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Iterator

import numpy as np

from benchmarks.data_mistakes.mistakes import MISTAKES, Mistake
from benchmarks.hidden_effects.cases import Case, case
from benchmarks.hidden_effects.run import made
from benchmarks.hidden_effects.sessions import hidden_session
from benchmarks.hidden_effects.suite import EXTRAS, tasks
from model.discrepancy import CheckedData, check_data
from model.measurements import Measurements

KINDS: tuple[dict[str, object], ...] = (
    {"extras": EXTRAS}, {}, {"rest": "constant"}, {"scatter": 2.0}, {"streams": "means"},
)  # fmt: skip


def wilson(right: int, count: int, z: float = 1.645) -> tuple[float, float]:
    """Return the 90 % interval of a share (Wilson 1927)."""
    if not count:
        return 0.0, 1.0
    share, zz = right / count, z * z / count
    middle = (share + zz / 2) / (1 + zz)
    half = z / (1 + zz) * np.sqrt(share * (1 - share) / count + zz / count / 4)
    return float(max(0.0, middle - half)), float(min(1.0, middle + half))


def told(found: CheckedData, mistake: Mistake, right: float) -> bool:
    """Whether the mistake is told, with the value that is right where there is one."""
    if "outlier_readings" in mistake.told_by:
        return any(note.startswith(f"{right:.0f} reading") for note in found.notes)
    said = [one for one in found.suspicions if one.check in mistake.told_by]
    if not said or len(said) < len(found.suspicions):
        return False
    values = [one.value / (1e3 if one.unit in ("mm", "mN") else 1.0) for one in said
              if one.value is not None]  # fmt: skip
    if not np.isfinite(mistake.tolerance):
        return True
    return any(abs(value - right) <= mistake.tolerance * abs(right) for value in values)


def _kind(mistake: Mistake, number: int, seed: int) -> Case:
    options = KINDS[number % len(KINDS)]
    if "swing" in mistake.name:
        options = {"extras": EXTRAS}  # with free shapes
    return case(seed=1000 * seed + number, **options)


def detection(sessions: int, seed: int) -> None:
    """Print for each mistake how often it is told, and what else is said."""
    pool: dict[Case, Measurements] = {}
    print("mistake | told rightly | 90 % interval | CPU, median | else")
    for mistake in MISTAKES:
        right, cpu, other = 0, list[float](), Counter[str]()
        for number in range(sessions):
            of = _kind(mistake, number, seed)
            if of not in pool:
                pool[of] = hidden_session(of).measurements
            wrong, value = mistake.make(pool[of], np.random.default_rng((seed, number)))
            began = time.process_time()
            found = check_data(wrong)
            cpu.append(time.process_time() - began)
            good = told(found, mistake, value)
            right += good
            if not good:
                other[", ".join(one.check for one in found.suspicions) or "nothing"] += 1
        low, high = wilson(right, sessions)
        print(
            f"{mistake.name} | {right} of {sessions} | {low:.0%} - {high:.0%} |"
            f" {np.median(cpu):.2f} s | {dict(other) or ''}",
            flush=True,
        )


def good_sessions(count: int, seed: int) -> Iterator[tuple[str, Measurements]]:
    """Yield sessions in which nothing is stated wrong."""
    for task in tasks(count, seed):
        try:
            yield task.family, made(task).hidden.measurements
        except ValueError:  # no such session can be made
            continue


def false_alarms(count: int, seed: int) -> None:
    """Print how many good sessions are stopped, or warned of."""
    total, stopped, warned, left_out = Counter[str](), Counter[str](), Counter[str](), 0
    cpu = []
    for family, measurements in good_sessions(count, seed):
        began = time.process_time()
        found = check_data(measurements)
        cpu.append(time.process_time() - began)
        total[family] += 1
        stopped[family] += bool(found.stops)
        warned[family] += bool(found.suspicions) and not found.stops
        left_out += bool(found.notes)
        for one in found.suspicions:
            print(f"{family}: {one.severity}: {one.sentence}", flush=True)
    number = sum(total.values())
    low, high = wilson(sum(stopped.values()), number)
    print(f"stopped {dict(stopped)}, warned {dict(warned)} of {dict(total)}")
    print(f"stopped: {sum(stopped.values())} of {number} ({low:.1%} - {high:.1%})")
    print(f"readings left out in {left_out} of {number}")
    if cpu:
        print(f"CPU: median {np.median(cpu):.2f} s, 95 % {np.quantile(cpu, 0.95):.2f} s")


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.data_mistakes")
    parser.add_argument("--sessions", type=int, default=20, help="of each mistake")
    parser.add_argument("--good", type=int, default=0, help="sessions without a mistake")
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    if chosen.sessions:
        detection(chosen.sessions, chosen.seed)
    if chosen.good:
        false_alarms(chosen.good, chosen.seed)


if __name__ == "__main__":
    main()
