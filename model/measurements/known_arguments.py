"""A wrong name of an argument is answered with the right ones."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from functools import wraps
from typing import Any, TypeVar

Job = TypeVar("Job", bound=Callable[..., Any])


def known_arguments(job: Job) -> Job:
    """Return the function, or the class, with a sentence for arguments that it does not have.

    It is a TypeError, as Python's own, and says what the arguments are called. Of a class, its
    subclasses with an `__init__` of their own are not meant.
    """
    parameters = inspect.signature(job).parameters  # of a class without `self`
    made: Any = job
    if not isinstance(job, type):
        made = _checked(job, job.__name__, parameters, first=0)
    else:
        made.__init__ = _checked(made.__init__, job.__name__, parameters, first=1)
    found: Job = made
    return found


def _checked(
    job: Any, name: str, parameters: Mapping[str, inspect.Parameter], *, first: int
) -> Any:
    """Return a function that looks at its arguments, from the one of index `first` on."""
    by_name = [one.name for one in parameters.values() if one.kind is one.KEYWORD_ONLY]
    most = len(parameters) - len(by_name)

    @wraps(job)
    def checked(*args: Any, **kwargs: Any) -> Any:
        given = next((each for each in kwargs if each not in parameters), None)
        if given is not None:
            close = get_close_matches(given, parameters, n=1)
            hint = f"did you mean {close[0]}? Its" if close else "its"
            raise TypeError(
                f"{name}() has no argument {given!r}; {hint} arguments are {', '.join(parameters)}."
            )
        unnamed = len(args) - first
        if unnamed > most and by_name:
            raise TypeError(
                f"{name}() takes {most} argument{'s' * (most != 1)} without a name, not "
                f"{unnamed}; give by name: {', '.join(f'{each}=' for each in by_name)}."
            )
        return job(*args, **kwargs)

    return checked
