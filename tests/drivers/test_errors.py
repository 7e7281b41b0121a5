"""What an error says to an operator, whoever raised it."""

from __future__ import annotations

import pytest

from drivers.interfaces import DeviceError, in_words, is_mistake
from drivers.plugins import UnknownPartError


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        (KeyError("volts"), "KeyError: 'volts'"),
        (TypeError("'NoneType' object is not iterable"), None),
        (ZeroDivisionError("division by zero"), "ZeroDivisionError: division by zero"),
        (ValueError("the answer was\n  'OK'."), "the answer was 'OK'"),
        (RuntimeError(), "RuntimeError"),
        (DeviceError("the stage does not answer; check its cable"), None),
        (UnknownPartError("there is no camera 'x'"), "there is no camera 'x'"),
    ],
)
def test_the_type_is_told_where_the_text_is_none_or_for_the_author_of_a_program(
    fault: Exception, words: str | None
) -> None:
    if words is None:
        words = f"TypeError: {fault}" if isinstance(fault, TypeError) else str(fault)
    assert in_words(fault) == words
    assert is_mistake(fault) == words.startswith(("KeyError", "TypeError", "ZeroDivision"))
