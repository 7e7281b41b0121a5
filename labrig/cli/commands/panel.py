"""The operator's page: panel."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.screen import say, warn
from labrig.errors import BadInputError
from labrig.files import SESSION_ENDINGS, typed

if TYPE_CHECKING:
    from labrig.panel.access.settings import PanelSettings

_PORT = 8720


def panel(
    what: Annotated[
        Path | None, typer.Argument(help="rig.toml, or a recorded session to replay")
    ] = None,
    open_it: Annotated[bool, typer.Option("--open", help="open the page in the browser")] = False,
    data: Annotated[
        Path | None, typer.Option(help="where sessions are; by default the folder of WHAT")
    ] = None,
    model: Annotated[
        Path | None,
        typer.Option(
            help="a model file whose predicted curve is drawn; one of the sheet in time "
            "(labrig fit --dynamic) runs beside the run"
        ),
    ] = None,
    port: Annotated[int, typer.Option(min=0, max=65535, help="0: any free one")] = _PORT,
    host: Annotated[
        str, typer.Option(help="listen elsewhere; needs --certificate and --key, or --insecure")
    ] = "127.0.0.1",
    certificate: Annotated[Path | None, typer.Option(help="for TLS, PEM")] = None,
    key: Annotated[Path | None, typer.Option(help="for TLS, PEM")] = None,
    insecure: Annotated[
        bool, typer.Option("--insecure", help="listen elsewhere without encryption")
    ] = False,
    other_token: Annotated[
        bool, typer.Option("--new-token", help="let no page in that knows an earlier address")
    ] = False,
) -> None:
    """Serve the operator's page in the browser.

    Run, watch, answer, stop, calibrate, replay and compare there.

    Prints the address with its token. The run is a process of its own: neither closing the page
    nor ending the panel touches it. Without WHAT: rig.toml of this folder, or its sessions.
    """
    from labrig.panel.server.serve import serve

    settings = _settings(what, data, model, host, port)
    settings = _with_tls(settings, certificate, key, insecure=insecure)
    settings = _with_token(settings, other=other_token)

    def ready(settings: PanelSettings) -> None:
        address = settings.url(f"/?token={settings.token}")
        say(address)
        warn(f"sessions go to {settings.data}; Ctrl-C ends the panel, not a run")
        if open_it:
            import webbrowser

            webbrowser.open(address)

    serve(settings, ready)


def _settings(
    what: Path | None, data: Path | None, model: Path | None, host: str, port: int
) -> PanelSettings:
    from labrig.panel.access.settings import PanelSettings

    if what is None and Path("rig.toml").is_file():
        what = Path("rig.toml")
    if what is not None and what.is_dir():
        raise BadInputError(
            f"{what}: this is a folder; give a rig.toml or a session, or --data {typed(what)} for "
            "its sessions."
        )
    if model is not None and model.is_dir():
        raise BadInputError(f"{model}: this is a folder; a model file is needed.")
    for path in (what, model):
        if path is not None and not path.is_file():
            raise BadInputError(f"{path}: there is no such file.")
    if data is not None and not data.is_dir():
        raise BadInputError(f"{data}: there is no such folder.")
    is_session = what is not None and what.suffix.lower() in SESSION_ENDINGS
    folder = (data or (what.parent if what else Path())).resolve()
    rig, session = (None, what) if is_session else (what, None)
    if session is not None and not session.resolve().is_relative_to(folder):
        raise BadInputError(f"{session}: does not lie in the data folder {folder}.")
    _require_readable(rig, session, model)
    return PanelSettings(
        data=folder,
        rig=None if rig is None else rig.resolve(),
        session=None if session is None else session.resolve(),
        model=None if model is None else model.resolve(),
        host=host,
        port=port,
    )


def _with_token(settings: PanelSettings, *, other: bool) -> PanelSettings:
    """Take the token of this folder's last panel, unless others may have listened to it."""
    from dataclasses import replace

    from labrig.panel.access.settings import LOOPBACK
    from labrig.panel.server.kept_token import kept_token, new_token

    if settings.host not in LOOPBACK and settings.certificate is None:
        return settings
    make = new_token if other else kept_token
    return replace(settings, token=make(settings.data))


def _require_readable(rig: Path | None, session: Path | None, model: Path | None) -> None:
    """Raise BadInputError, as reading the file later would, if it cannot be read."""
    if rig is not None:
        from labrig.config import load_rig

        load_rig(rig)
    if session is not None:
        from labrig.session import open_session

        open_session(session, live=True).close()
    if model is not None:
        from labrig.model_file import load_model

        load_model(model)


def _with_tls(
    settings: PanelSettings, certificate: Path | None, key: Path | None, *, insecure: bool
) -> PanelSettings:
    from dataclasses import replace

    from labrig.panel.access.settings import LOOPBACK

    if (certificate is None) != (key is None):
        raise BadInputError("--certificate and --key belong together; give both.")
    if settings.host not in LOOPBACK and certificate is None and not insecure:
        raise BadInputError(
            f"--host {settings.host}: others could listen in and take the token; give "
            "--certificate and --key, or --insecure when the network is the rig's own."
        )
    if certificate is None or key is None:
        return settings
    import ssl

    try:
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(certificate, key)
    except (OSError, ssl.SSLError) as error:
        raise BadInputError(f"{certificate}: cannot be used with {key} ({error}).") from None
    return replace(settings, certificate=certificate.resolve(), key=key.resolve())


COMMAND = Command(
    "panel",
    panel,
    order=110,
    examples=(CommandExample(line="labrig panel rig/rig.toml --port 0", stop=True),),
)
