"""Comparing tokens and finding them. Standard library only: the STOP process uses it, too."""

from __future__ import annotations

import hmac
from http.cookies import CookieError, SimpleCookie

from labrig.panel.access.settings import COOKIE


def same_token(given: str, token: str) -> bool:
    """Compared in a time that tells nothing."""
    return hmac.compare_digest(given.encode("utf-8", "replace"), token.encode("utf-8"))


def cookie_of(header: str) -> str:
    """The token in a `Cookie` header; empty when there is none."""
    try:
        found = SimpleCookie(header).get(COOKIE)
    except CookieError:
        return ""
    return "" if found is None else found.value
