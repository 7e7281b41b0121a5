"""The directive `terminal`: commands that are run in the build, with what they printed.

All blocks of a page are run one after the other in one new folder, which holds tutorials/data.
The build fails where a command ends with another exit code than the page says.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import tempfile
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

_PROGRESS = re.compile(r"^[\w -]+: \d+ %")
_TIMEOUT_S = 180.0


class Terminal(SphinxDirective):
    """Run each line as a command; show it with its output.

    Options: `exit` the exit code of the last command, `answers` what is typed (a comma between
    two lines), `stop-after` seconds after which Ctrl-C is pressed, `lines` the most that are shown of
    each output, `hidden` to show nothing.
    """

    has_content = True
    option_spec: ClassVar[dict[str, Any]] = {
        "exit": directives.nonnegative_int,
        "answers": directives.unchanged,
        "stop-after": float,
        "lines": directives.positive_int,
        "hidden": directives.flag,
    }

    def run(self) -> list[nodes.Node]:
        """Run the commands and return one block of text."""
        commands = [line for line in _joined(self.content) if line.strip()]
        shown = []
        for command in commands:
            wanted = self.options.get("exit", 0) if command is commands[-1] else 0
            code, output = self._run(command)
            if code != wanted:
                raise self.error(f"`{command}` ended with {code}, not {wanted}:\n{output}")
            shown.append(f"$ {command}\n{self._cut(output)}".rstrip())
        if "hidden" in self.options:
            return []
        block = nodes.literal_block("", "\n".join(shown))
        block["language"] = "console"
        return [block]

    def _run(self, command: str) -> tuple[int, str]:
        process = subprocess.Popen(
            ["bash", "-c", command],
            cwd=self._folder(),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            text=True,
        )
        answers = self.options.get("answers", "").replace(",", "\n") + "\n"
        if "stop-after" not in self.options:
            output = process.communicate(answers, timeout=_TIMEOUT_S)[0]
        else:
            try:
                output = process.communicate(timeout=self.options["stop-after"])[0]
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGINT)
                output = process.communicate(timeout=_TIMEOUT_S)[0]
        kept = [line for line in output.splitlines() if not _PROGRESS.match(line)]
        return process.returncode, "\n".join(kept).strip("\n")

    def _cut(self, output: str) -> str:
        lines, most = output.splitlines(), self.options.get("lines", 60)
        return "\n".join([*lines[:most], "..."] if len(lines) > most else lines)

    def _folder(self) -> Path:
        folders = _folders(self.env)
        if self.env.docname not in folders:
            folders[self.env.docname] = folder = Path(tempfile.mkdtemp(prefix="labrig-docs-"))
            shutil.copytree(os.environ["LABRIG_DOCS_DATA"], folder, dirs_exist_ok=True)
        return folders[self.env.docname]


def _joined(lines: Any) -> list[str]:
    """Return commands; a line that ends with a backslash continues in the next."""
    commands = [""]
    for line in lines:
        commands[-1] += line
        commands += ["\n"] if line.endswith("\\") else [""]
    return [command.strip("\n") for command in "".join(f"{c}\x00" for c in commands).split("\x00")]


def _folders(env: Any) -> dict[str, Path]:
    if not hasattr(env, "_terminal_folders"):
        env._terminal_folders = {}
    folders: dict[str, Path] = env._terminal_folders
    return folders


def _read_anew(_app: Sphinx, env: Any, docname: str) -> None:
    folder = _folders(env).pop(docname, None)
    if folder is not None:
        shutil.rmtree(folder, ignore_errors=True)


def _remove(app: Sphinx, _error: Exception | None) -> None:
    for docname in list(_folders(app.env)):
        _read_anew(app, app.env, docname)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("terminal", Terminal)
    app.connect("env-purge-doc", _read_anew)
    app.connect("build-finished", _remove)
    return {"parallel_read_safe": False, "parallel_write_safe": True}
