"""`labrig run --diagnose`: what comes after the run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import typer

from labrig.api.diagnose import keep_in, promises_kept_in
from labrig.cli.diagnosis import diagnosed, print_diagnosis
from labrig.cli.follow import run_and_follow
from labrig.cli.measurements import of_sessions
from labrig.cli.screen import say, warn
from labrig.errors import ExitCode
from labrig.experiment.next_measurement.closed_loop import closed_loop
from labrig.experiment.next_measurement.next_protocol import protocol_text, with_protocol
from labrig.files import write_text
from labrig.report.diagnosis.tables import next_sentence
from labrig.session import open_session
from model.discrepancy import DiagnoseOptions, Diagnosis, Next


def follow_up(first: Path, rig: Path, sheet: Path, *, yes: bool, about: Path | None = None) -> None:
    """Diagnose a session that was just run, and measure further where that helps."""
    ended = closed_loop(first, _AtTheRig(rig=rig, sheet=sheet, yes=yes, about=about), say)
    if len(ended.sessions) > 1 or ended.diagnosis.verdict == "indistinguishable":
        say(f"Ended with {len(ended.sessions)} sessions: {ended.why}.")
    if ended.code is not ExitCode.DONE:
        warn(f"labrig: {ended.why}.")
        raise typer.Exit(int(ended.code))


@dataclass(frozen=True, kw_only=True)
class _AtTheRig:
    """See `labrig.experiment.next_measurement.closed_loop.MeasurementRig`."""

    rig: Path
    sheet: Path
    yes: bool
    about: Path | None

    def diagnose(self, sessions: list[Path]) -> Diagnosis:
        found = diagnosed(
            of_sessions(sessions), DiagnoseOptions(promised=promises_kept_in(sessions))
        )
        found = with_protocol(found, of_sessions(sessions[:1]), sessions[0])
        keep_in(sessions[0], found)
        print_diagnosis(found, sessions[0])
        return found

    def agree(self, proposed: Next) -> bool:
        if self.yes:
            return True
        try:
            return typer.confirm(f"{next_sentence(proposed)} Do it now?", default=False)
        except typer.Abort:  # nobody there to be asked
            return False

    def measure(self, proposed: Next, sessions: list[Path], output: Path) -> ExitCode:
        text = protocol_text(proposed, of_sessions(sessions[:1]), sessions[0])
        protocol = output.with_name(f"{output.stem}-protocol.toml")
        write_text(protocol, text)
        say(f"wrote {protocol}")
        with open_session(sessions[0]) as session:
            follows = session.identifier
        result = run_and_follow(
            self.rig,
            protocol,
            self.sheet,
            output,
            yes=self.yes,
            about=self.about,
            follows=follows,
            earlier=len(sessions),
        )
        say(f"{result.path}: {result.text}.")
        return result.code
