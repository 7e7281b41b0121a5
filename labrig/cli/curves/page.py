"""`labrig curves --page FOLDER`: the page of a folder of photographs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from labrig.cli.screen import say, warn
from labrig.errors import BadInputError

if TYPE_CHECKING:
    from labrig.panel.access.settings import PanelSettings


def serve_page(folder: Path, port: int, *, open_it: bool) -> None:
    """Serve the page until Ctrl-C. Raises BadInputError."""
    from labrig.panel.access.settings import PanelSettings
    from labrig.panel.server.kept_token import kept_token
    from labrig.panel.server.serve import serve
    from labrig.vision.image.review import load_review

    if not folder.is_dir():
        raise BadInputError(f"{folder}: there is no such folder.")
    load_review(folder)  # its fault is told now, not on the page
    data = folder.resolve()
    settings = PanelSettings(data=data, photographs=True, port=port, token=kept_token(data))

    def ready(settings: PanelSettings) -> None:
        address = settings.url(f"/?token={settings.token}")
        say(address)
        warn(f"the photographs of {data}; Ctrl-C ends the page")
        if open_it:
            import webbrowser

            webbrowser.open(address)

    serve(settings, ready)
