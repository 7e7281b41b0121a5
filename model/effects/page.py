"""The catalogue as a page of the documentation: `python -m model.effects.page` prints it."""

from __future__ import annotations

import math
from collections.abc import Iterable

from model.effects.catalogue import catalogue
from model.effects.interface import Effect, EffectParameter
from model.locations import locations

HEAD = """\
# The catalogue of effects

An effect is a physical cause that the base model leaves out. `labrig diagnose` looks for all of
these. The documentation build makes this page from the effects themselves.

Each section has the effect's meaning, its formula, and its trace in the data. The formula is a
first guess: the data may depart from it along the coordinates listed under *may differ along*.
`labrig effects show NAME` prints the same.

To add an effect, write one file with a frozen subclass of `Effect` and the constant `EFFECT`; its
first parameter is the amplitude. It goes into `model/effects/`, or into a distribution of yours:

```toml
[project.entry-points."labrig.effects"]
moonlight = "my_package.moonlight:EFFECT"
```

`labrig.testing.effect_faults(EFFECT)` returns its faults. A faulty effect is left out with a
warning. `diagnose` records the name and version of the distribution that an effect comes from.
"""


def page() -> str:
    """Return the whole page."""
    effects = [e for e in catalogue().values() if type(e).__module__.startswith("model.effects.")]
    return "\n".join([HEAD, *_overview(effects), *_sections(effects)])


def _overview(effects: list[Effect]) -> Iterable[str]:
    yield "| effect | location | parameters | form |"
    yield "|---|---|---|---|"
    for e in effects:
        names = ", ".join([*(k.name for k in e.parameters), *e.extra])
        yield f"| [{e.name}](#{e.name}) | {e.location} | {names} | {_cell(e.form)} |"
    yield ""


def _sections(effects: list[Effect]) -> Iterable[str]:
    for location in locations().values():
        yield f"## {location.name}: {location.meaning}\n"
        for e in effects:
            if e.location == location.name:
                yield from _section(e)


def _section(e: Effect) -> Iterable[str]:
    yield f"### {e.name}\n"
    yield f"{e.meaning}\n"
    yield f"- **form**: {e.form}"
    yield f"- **leaves in the data**: {e.signature}"
    yield f"- **isolated by**: {e.isolates}"
    yield f"- **may differ along**: {', '.join(e.form_error_along)}" + (
        "; each configuration may have its own size" if e.by_configuration else ""
    )
    if e.explained_by_dynamics:
        yield "- **explained by dynamics**: beside a model that has them, the deviation from these"
    yield f"- **source**: {e.source}\n"
    yield "| parameter | meaning | unit | prior scale | bounds | absent at | starting values |"
    yield "|---|---|---|---|---|---|---|"
    for parameter in e.parameters:
        yield _row(parameter, shape=parameter is not e.amplitude)
    for name, unit in e.extra.items():
        yield f"| {name} | follows from the others | {unit} | | | | |"
    yield ""


def _row(parameter: EffectParameter, *, shape: bool) -> str:
    bounds = f"{_number(parameter.low)} to {_number(parameter.high)}"
    absent = "" if shape else _number(parameter.neutral)
    tried = ", ".join(_number(v) for v in parameter.starting_values)
    plausible = _number(parameter.prior_scale)
    cells = [
        parameter.name,
        _cell(parameter.meaning),
        parameter.unit,
        plausible,
        bounds,
        absent,
        tried,
    ]
    return f"| {' | '.join(cells)} |"


def _number(value: float) -> str:
    if math.isinf(value):
        return "-∞" if value < 0.0 else "∞"
    return f"{value:.4g}"


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


if __name__ == "__main__":
    import sys

    sys.stdout.reconfigure(encoding="utf-8", newline="\n")  # type: ignore[union-attr]
    sys.stdout.write(page())
