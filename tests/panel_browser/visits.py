"""Pages in the browser for a test: what they did is looked at, and one is kept for the next."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any
from urllib.parse import urlsplit

POLLING_MS = 50  # as it is shipped it looks at each frame, and so has the browser make frames
WAIT_MS = 30_000  # a shared machine may be slow; nothing waits longer than it must
FORGET = "localStorage.clear(); sessionStorage.clear()"
FRAME_MS = 100
# A page that follows a run takes 0.4 of a processor; half of that is for more frames than these.
SELDOM = f"""
window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), {FRAME_MS});
window.cancelAnimationFrame = clearTimeout;
"""
Visit = Callable[..., Any]


class Watched:
    """What the pages of a test did that they must not do."""

    def __init__(self) -> None:
        self.hosts: set[str] = set()
        self.faults: list[str] = []
        self._pages: list[Any] = []

    def watch(self, page: Any) -> None:
        self._pages.append(page)
        page.on("request", self._asked)
        page.on("websocket", self._asked)
        page.on("pageerror", self._failed)

    def end(self) -> None:
        """Watch no longer: the next test may have one of the pages."""
        for page in self._pages:
            page.remove_listener("request", self._asked)
            page.remove_listener("websocket", self._asked)
            page.remove_listener("pageerror", self._failed)

    def _asked(self, request: Any) -> None:
        self.hosts.add(urlsplit(request.url).hostname or "")

    def _failed(self, error: Any) -> None:
        self.faults.append(str(error))


class KeptPage:
    """One page of the browser for the first visit of each test.

    A page of its own takes a second of processor time more: a window, its processes, and scripts
    that are compiled anew. It is left as if nobody had used it, else the next test gets another.
    """

    def __init__(self, chromium: Any, *, seldom: bool = False, **context: Any) -> None:
        self.context = context
        self._chromium = chromium
        self._seldom = seldom  # it draws ten times a second
        self._page: Any = None

    def get(self, width: int, height: int, dark: bool) -> Any:
        """The page, empty."""
        if self._page is None:
            context = self._chromium.new_context(reduced_motion="reduce", **self.context)
            context.set_default_timeout(WAIT_MS)
            if self._seldom:
                context.add_init_script(SELDOM)
            self._page = context.new_page()
        self._page.set_viewport_size({"width": width, "height": height})
        self._page.emulate_media(color_scheme="dark" if dark else "light", reduced_motion="reduce")
        return self._page

    def leave(self) -> None:
        """Empty it, and all that its address may have kept; let it go where that fails."""
        page, self._page = self._page, None
        try:
            page.context.set_offline(False)
            page.unroute_all()
            speaks = page.context.new_cdp_session(page)
            speaks.send("Runtime.evaluate", {"expression": FORGET})
            speaks.detach()
            page.goto("about:blank")
            page.context.clear_cookies()
            page.context.clear_permissions()
            page.mouse.move(0, 0)
            others = [other for other in page.context.pages if other != page]
        except Exception:  # noqa: BLE001 - a page that crashed, for one
            others = [page]
        if others:
            page.context.close()
        else:
            self._page = page


@contextmanager
def visits(chromium: Any, kept: Sequence[KeptPage] = ()) -> Iterator[Visit]:
    """`visit(url, width=, height=, dark=, **context)`: a page in a context of its own.

    The first one with the `context` of a page that is kept is that one.
    """
    contexts: list[Any] = []
    free, used = list(kept), []
    watched = Watched()

    def go(url: str, width: int = 1440, height: int = 900, dark: bool = False, **more: Any) -> Any:
        fits = next((one for one in free if one.context == more), None)
        if fits is not None:
            free.remove(fits)
            used.append(fits)
            page = fits.get(width, height, dark)
        else:
            context = chromium.new_context(
                viewport={"width": width, "height": height},
                color_scheme="dark" if dark else "light",
                reduced_motion="reduce",
                **more,
            )
            contexts.append(context)
            context.set_default_timeout(WAIT_MS)
            page = context.new_page()
        watched.watch(page)
        page.wait_for_function = partial(type(page).wait_for_function, page, polling=POLLING_MS)
        page.goto(url)
        return page

    try:
        yield go
    finally:
        for context in contexts:
            context.close()
        for one in used:
            one.leave()
        watched.end()
    assert watched.faults == []
    assert watched.hosts <= {"127.0.0.1", ""}  # "": blob: and data:, which leave no computer
