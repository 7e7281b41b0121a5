"""Documents of the Bluesky event model, one line of JSON each; arrays stay in the session file."""

from __future__ import annotations

import json
from pathlib import Path

from labrig.exports._files import new_file
from labrig.session import open_session
from labrig.session.bluesky.documents import documents
from labrig.session.recording.disk import written_beside


class _Bluesky:
    summary = "Bluesky documents as lines of JSON; signals and images stay in the session file."
    extra = "bluesky"

    def write(self, session: Path, folder: Path) -> list[Path]:
        target = new_file(folder, f"{session.stem}.documents.jsonl")
        with (
            open_session(session) as opened,
            written_beside(target) as beside,
            beside.open("w", encoding="utf-8", newline="\n") as file,
        ):
            for name, content in documents(opened):
                file.write(json.dumps([name, content]) + "\n")
        return [target]


FORMAT = _Bluesky()
