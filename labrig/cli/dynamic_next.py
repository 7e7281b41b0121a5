"""What `labrig next --dynamic` prints."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig.cli.screen import print_json, print_table, say

if TYPE_CHECKING:
    from labrig.analysis.motion.proposals import Proposal
    from labrig.cli.dynamic_fit import DynamicRequest


def next_in_time(request: DynamicRequest, model: Path | None, *, as_json: bool) -> None:
    """Print what further runs would determine of each configuration."""
    from labrig.analysis.motion.proposals import proposals
    from labrig.report.tables.dynamic_next import next_table, next_text, proposals_json
    from labrig.session import open_session

    with open_session(request.sessions[0]) as session:
        frame_rate_hz = session.schedule.frame_rate_hz or 25.0
    found: dict[str, Any] = {}
    for name, (sheet, beam, runs, noise) in _known(request, model).items():
        offered: Sequence[Proposal] = proposals(sheet, beam, runs, noise, frame_rate_hz)
        found[name] = proposals_json(offered)
        if not as_json:
            table = next_table(name, offered)
            print_table(table.title, table.columns, table.rows)
            say(table.note)
            for text in next_text(offered):
                say(text)
            say()
    if as_json:
        print_json({"configurations": found})


def _known(request: DynamicRequest, model: Path | None) -> dict[str, tuple[Any, Any, Any, Any]]:
    """Return sheet, beam, runs and noise of each configuration, fitted or of a model file."""
    from labrig.analysis.motion.noise import noise_at_first
    from labrig.cli.dynamic_fit import fitted_in_time, records_of
    from labrig.model_file import load_model, moving_configuration

    if model is None:
        fits = fitted_in_time(request)
        return {
            fit.sheet.configuration: (fit.sheet, fit.found.beam, fit.runs, fit.noise)
            for fit in fits
        }
    known = load_model(model)
    name = moving_configuration(known, model, None)
    runs = [run for record in records_of(request, name) for run in record.runs]
    sheet = known.sheet(name).sheet
    return {name: (sheet, known.moving(name, None)[0], runs, noise_at_first(runs))}
