"""Comparing tokens and finding them. Standard library only: the STOP process uses it, too."""

from __future__ import annotations

import hmac
from collections.abc import Mapping
from http.cookies import CookieError, SimpleCookie

from labrig.panel.access.settings import COOKIE


def same_token(given: str, token: str) -> bool:
    """Compare in a time that does not depend on the difference."""
    return hmac.compare_digest(given.encode("utf-8", "replace"), token.encode("utf-8"))


def cookie_of(header: str) -> str:
    """Return the token in a `Cookie` header; empty when there is none."""
    try:
        found = SimpleCookie(header).get(COOKIE)
    except CookieError:
        return ""
    return "" if found is None else found.value


def bearer_of(headers: Mapping[str, str]) -> str:
    """Return the token of an `Authorization` header; names of headers are in lower case."""
    return headers.get("authorization", "").removeprefix("Bearer ")


def has_token(headers: Mapping[str, str], token: str) -> bool:
    """Whether a request shows the token, by header or by cookie."""
    return same_token(bearer_of(headers), token) or same_token(
        cookie_of(headers.get("cookie", "")), token
    )
