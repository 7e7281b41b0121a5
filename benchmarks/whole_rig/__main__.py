"""What `labrig diagnose` says of sessions of the simulated rig, from `labrig init` on.

    python -m benchmarks.whole_rig [--seed 1] [--jobs 1] [--only WORD ...] -o answers.jsonl
    python -m benchmarks.whole_rig --score answers.jsonl [...]

The worlds are those of worlds.toml. Each session is made by the commands that a user types, so that
boards, camera, image processing and what the rig states of itself take part. Cases that the file
holds already are not made again.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import tomllib
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import tomlkit

from benchmarks.hidden_effects.score import wilson

WORLDS = Path(__file__).parent / "worlds.toml"
ALONE, AMONG, NOTHING = "named, and nothing else", "named, with others", "nothing is said"
UNKNOWN, ELSEWHERE, IN_THE_SET = "unknown, there", "unknown, elsewhere", "in the reported set alone"
WRONG = "something else is named"
ANSWERS = (ALONE, AMONG, IN_THE_SET, UNKNOWN, ELSEWHERE, NOTHING, WRONG)


@dataclass(frozen=True, kw_only=True)
class Case:
    """A world, and what should be said of it: one of the names, or unknown at a location."""

    hidden: str
    world: Mapping[str, Any]
    protocol: Mapping[str, Any] = field(default_factory=dict)  # what differs from the paper's
    names: tuple[str, ...] = ()
    locations: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What was said of one session; `error` is what a command ended with."""

    hidden: str
    seed: int
    error: str = ""
    named: tuple[str, ...] = ()
    unknown: str = ""  # its location
    reported_set: tuple[str, ...] = ()
    confidence: float = 0.0  # of the first name


def cases() -> list[Case]:
    """Return the worlds, with what each has from the clean one."""
    table = tomllib.loads(WORLDS.read_text(encoding="utf-8"))
    return [
        Case(
            hidden=one["hidden"],
            world=merged(table["clean"], one["world"]),
            protocol=one.get("protocol", {}),
            names=tuple(one.get("names", ())),
            locations=tuple(one.get("locations", ())),
        )
        for one in table["case"]
    ]


def merged(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table with what another one has instead or besides."""
    found = dict(below)
    for key, value in above.items():
        own = found.get(key)
        both = isinstance(value, Mapping) and isinstance(own, Mapping)
        found[key] = merged(own, value) if both else value
    return found


def answer(case: Case, seed: int) -> Answer:
    """Make a session as a user does, and diagnose it."""
    with tempfile.TemporaryDirectory() as folder:
        rig, session = Path(folder) / "rig", Path(folder) / "session.h5"
        said = ""
        for command in (
            ("init", rig, "--simulated"),
            ("run", *(rig / n for n in ("rig.toml", "protocol.toml", "sheet.toml")),
             "-o", session, "--yes"),
            ("analyze", session),
            ("diagnose", session, "--json"),
        ):  # fmt: skip
            done = _labrig(*command)
            if done.returncode:
                return Answer(hidden=case.hidden, seed=seed, error=done.stderr.strip())
            if command[0] == "init":
                _write(rig / "world.toml", {"seed": seed, **case.world})
                usual = tomllib.loads((rig / "protocol.toml").read_text(encoding="utf-8"))
                _write(rig / "protocol.toml", merged(usual, case.protocol))
            said = done.stdout
    return _read(case, seed, json.loads(said))


def _write(path: Path, content: Mapping[str, Any]) -> None:
    path.write_text(tomlkit.dumps(content), encoding="utf-8")


def _labrig(*words: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "labrig", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, encoding="utf-8", check=False)


def _read(case: Case, seed: int, said: Mapping[str, Any]) -> Answer:
    effects = said["effects"]
    return Answer(
        hidden=case.hidden,
        seed=seed,
        named=tuple(one["name"] for one in effects),
        unknown=(said["unknown"] or {}).get("slot", ""),
        reported_set=tuple(said["reported_set"]),
        confidence=effects[0]["confidence"] if effects else 0.0,
    )


def judged(case: Case, given: Answer) -> str:
    """Return which of `ANSWERS` it is, or its error."""
    if given.error:
        return f"error: {given.error}"
    right = set(given.named) & set(case.names)
    if right:
        return ALONE if set(given.named) == right and not given.unknown else AMONG
    if given.named:
        return WRONG
    if given.unknown:
        return UNKNOWN if given.unknown in case.locations else ELSEWHERE
    return IN_THE_SET if set(given.reported_set) & set(case.names) else NOTHING


def table(answers: Iterable[Answer]) -> Iterator[str]:
    """Yield the lines of the tables: each case, then how often each answer was given."""
    by_hidden = {one.hidden: one for one in cases()}
    count: dict[str, Counter[str]] = {}
    for given in answers:
        case = by_hidden[given.hidden]
        found = judged(case, given)
        kind = "in the catalogue" if case.names else "in no catalogue"
        if not case.names and not case.locations:
            kind = "nothing hidden"
        count.setdefault(kind, Counter())[found.split(":")[0]] += 1
        others = [one for one in given.named if one not in case.names]
        besides = [*others, *([f"unknown: {given.unknown}"] if given.unknown else [])]
        yield (
            f"{given.hidden} | {given.seed} | {found} | {given.confidence:.2f} |"
            f" {', '.join(besides)} | {', '.join(given.reported_set)}"
        )
    for kind, each in count.items():
        number = sum(each.values())
        yield f"\n{kind}, n {number}; 90 % intervals"
        for found in sorted(each, key=lambda one: ANSWERS.index(one) if one in ANSWERS else 99):
            low, high = wilson(each[found], number)
            yield f"{found} | {each[found]} | {100 * low:.0f} to {100 * high:.0f} %"


def read(path: Path) -> list[Answer]:
    """Return the answers that a file holds."""
    if not path.exists():
        return []
    lines = path.read_text(encoding="utf-8").splitlines()
    rows = [json.loads(line) for line in lines]
    return [Answer(**row | {k: tuple(row[k]) for k in ("named", "reported_set")}) for row in rows]


def make(wanted: list[Case], seed: int, jobs: int, path: Path) -> None:
    """Make the sessions that a file lacks, and add what is said of them, one line each."""
    there = {(one.hidden, one.seed) for one in read(path)}
    left = [one for one in wanted if (one.hidden, seed) not in there]
    with ThreadPoolExecutor(jobs) as pool, path.open("a", encoding="utf-8") as file:
        for given in pool.map(lambda one: answer(one, seed), left):
            print(json.dumps(asdict(given)), file=file, flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.whole_rig")
    parser.add_argument("--seed", type=int, default=1, help="of the worlds")
    parser.add_argument("--jobs", type=int, default=1, help="sessions at once")
    parser.add_argument("--only", nargs="+", default=[], help="words of what is hidden")
    parser.add_argument("-o", "--output", type=Path)
    parser.add_argument("--score", type=Path, nargs="+", default=[])
    chosen = parser.parse_args()
    if not chosen.output and not chosen.score:
        parser.error("give -o FILE, or --score FILE")
    if chosen.output:
        words = chosen.only
        wanted = [one for one in cases() if not words or any(w in one.hidden for w in words)]
        make(wanted, chosen.seed, chosen.jobs, chosen.output)
    files = chosen.score or [chosen.output]
    print("\n".join(table(one for path in files for one in read(path))))


if __name__ == "__main__":
    main()
