"""The options of `labrig curves` that state a strip fact: one for each that is found."""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Mapping
from typing import Annotated, Any

import typer

from drivers.plugins import PluginWarning
from labrig.errors import BadInputError
from labrig.vision.facts.catalogue import origin_of, strip_facts
from labrig.vision.facts.contract import FactOf, FactShape, StripFact

PARAMETER = "fact_"  # before a fact's name: what the command has is called otherwise


def with_facts(command: Callable[..., None], before: str) -> Callable[..., None]:
    """Return a command with an option for each fact in place of its `**facts`.

    They stand before the parameter `before`. A fact whose option the command has is left out.
    """
    signature = inspect.signature(command, eval_str=True)
    own = [p for p in signature.parameters.values() if p.kind != p.VAR_KEYWORD]
    flags = set(_flags(own))
    options = [_option(fact) for fact in strip_facts().values() if _is_new(fact, flags)]
    at = [p.name for p in own].index(before)

    def called(**options: Any) -> None:
        command(**options)

    parameters = [*own[:at], *options, *own[at:]]
    called.__doc__, called.__name__ = command.__doc__, command.__name__
    called.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    called.__annotations__ = {p.name: p.annotation for p in parameters}
    return called


def stated_facts(options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of the facts that these options state, by name. Raises BadInputError."""
    from labrig.vision.facts.stated import joined, read

    found: dict[str, Any] = {}
    for name, fact in strip_facts().items():
        texts = options.get(PARAMETER + name)
        if not texts and texts != "":
            continue
        if fact.shape == FactShape.FLAG:
            found[name] = True
            continue
        for text in texts if fact.option.repeated else [texts]:
            found[name] = joined(fact, found.get(name), read(fact, text))
    return found


def refuse_for_several_strips(stated: Mapping[str, Any]) -> None:
    """Raise BadInputError where a fact of one strip is stated for several."""
    of_strips = [fact for fact in strip_facts().values() if fact.of == FactOf.STRIP]
    if any(fact.name in stated for fact in of_strips):
        from labrig.vision.calibration.optics import listed

        flags = listed([fact.option.flag for fact in of_strips])
        raise BadInputError(f"{flags} are for one strip; of several, state them in optics.json.")


def flags_of_facts() -> list[str]:
    """Return the options of all facts."""
    return [fact.option.flag for fact in strip_facts().values()]


def _flags(parameters: list[inspect.Parameter]) -> list[str]:
    """Return the options that a command has, and what typer makes of those without a name."""
    found = ["--help"]
    for parameter in parameters:
        for info in getattr(parameter.annotation, "__metadata__", ()):
            found += getattr(info, "param_decls", None) or ()
        found.append("--" + parameter.name.replace("_", "-"))
    return found


def _is_new(fact: StripFact, flags: set[str]) -> bool:
    if fact.option.flag not in flags:
        return True
    warnings.warn(
        f"the strip fact '{fact.name}'{origin_of(fact.name)} is left out: labrig curves has an "
        f"option {fact.option.flag} already.",
        PluginWarning,
        stacklevel=2,
    )
    return False


def _option(fact: StripFact) -> inspect.Parameter:
    info = typer.Option(fact.option.flag, help=fact.option.help)
    kind: Any = str | None
    default: Any = None
    if fact.shape == FactShape.FLAG:
        kind, default = bool, False
    elif fact.option.repeated:
        kind = list[str] | None
    return inspect.Parameter(
        PARAMETER + fact.name,
        inspect.Parameter.POSITIONAL_OR_KEYWORD,
        default=default,
        annotation=Annotated[kind, info],
    )
