"""Hide one effect in one session, and write it as files, the truth apart.

python -m benchmarks.hidden_effects.hide --list
python -m benchmarks.hidden_effects.hide nonuniform_eibm --form cosh --size 0.4 --seed 3 -o /tmp/a
python -m benchmarks.hidden_effects.hide nothing --seed 4 --extras -o /tmp/b
"""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks.hidden_effects import (
    CATALOGUE,
    OUTSIDE,
    Extras,
    case,
    forms_of,
    hidden_session,
    write,
)
from benchmarks.hidden_effects.cases import NOTHING

EXTRAS = Extras(free_shapes=True, remounts=3, random_order=True, reversed_approach=True)


def listed() -> str:
    """What can be hidden, with its forms and usual sizes."""
    lines = []
    for title, effects in (("in the catalogue", CATALOGUE), ("outside", OUTSIDE)):
        lines.append(f"{title}:")
        for effect in effects:
            lines += [
                f"  {effect:24} {form.form:16} {form.size:<7g} {form.unit}"
                for form in forms_of(effect)
            ]
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.hidden_effects.hide")
    effects = [NOTHING, *CATALOGUE, *OUTSIDE]
    parser.add_argument("effect", nargs="?", default=NOTHING, choices=effects, metavar="EFFECT")
    parser.add_argument("--form", default="")
    parser.add_argument("--size", type=float)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--extras", action="store_true", help="free shapes, remounts, random order")
    parser.add_argument("--means", action="store_true", help="no times, series, curves of readings")
    parser.add_argument("--list", action="store_true", help="say what can be hidden")
    parser.add_argument("-o", "--output", type=Path)
    chosen = parser.parse_args()
    if chosen.list or chosen.output is None:
        print(listed())
        return
    asked = case(
        chosen.effect,
        chosen.form,
        chosen.size,
        seed=chosen.seed,
        streams="means" if chosen.means else "all",
        symmetric=chosen.effect == "eibm_asymmetry",
        extras=EXTRAS if chosen.extras else Extras(),
    )
    for path in write(hidden_session(asked), chosen.output):
        print(path)


if __name__ == "__main__":
    main()
