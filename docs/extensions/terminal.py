"""The directive `terminal`: commands that are run in the build, with what they printed.

All blocks of a page are run one after the other in one new folder, which holds tutorials/data.
The build fails where a command ends with another exit code than the page says.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any, ClassVar

import prepared
from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


class Terminal(SphinxDirective):
    """Run each line as a command; show it with its output.

    Options: `prepared` to work in a copy of the folder of the first session; `exit` the exit code
    of the last command; `answers` what is typed, a comma between two lines; `stop` to press
    Ctrl-C when something was printed; `lines` the most that are shown of each output; `before`
    and `after` lines that are run and not shown.
    """

    has_content = True
    option_spec: ClassVar[dict[str, Any]] = {
        "prepared": directives.flag,
        "exit": directives.nonnegative_int,
        "answers": directives.unchanged,
        "stop": directives.flag,
        "lines": directives.positive_int,
        "before": directives.unchanged,
        "after": directives.unchanged,
    }

    def run(self) -> list[nodes.Node]:
        """Run the commands and return one block of text."""
        commands = [line for line in _joined(self.content) if line.strip()]
        shown = []
        self._unseen("before")
        for command in commands:
            wanted = self.options.get("exit", 0) if command is commands[-1] else 0
            code, output = self._run(command)
            if code != wanted:
                raise self.error(f"`{command}` ended with {code}, not {wanted}:\n{output}")
            shown.append(f"$ {command}\n{self._cut(output)}".rstrip())
        self._unseen("after")
        block = nodes.literal_block("", "\n".join(shown))
        block["language"] = "console"
        return [block]

    def _run(self, command: str) -> tuple[int, str]:
        folder = self._folder()
        known = prepared.prepared()[1] if "prepared" in self.options else {}
        if command not in known:  # else another page, in the same folder, has run it
            answers = self.options.get("answers", "").split(",")
            known[command] = prepared.run(command, folder, answers, stop="stop" in self.options)
        return known[command]

    def _unseen(self, option: str) -> None:
        if option in self.options:
            prepared.run(self.options[option], self._folder())

    def _cut(self, output: str) -> str:
        lines, most = output.splitlines(), self.options.get("lines", 60)
        return "\n".join([*lines[:most], "..."] if len(lines) > most else lines)

    def _folder(self) -> Path:
        folders = _folders(self.env)
        if self.env.docname not in folders:
            folder = prepared.new_folder()
            if "prepared" in self.options:
                shutil.copytree(prepared.prepared()[0], folder, dirs_exist_ok=True)
            folders[self.env.docname] = folder
        return folders[self.env.docname]


def _joined(lines: Any) -> list[str]:
    """Return commands; a line that ends with a backslash continues in the next."""
    commands: list[str] = []
    for line in lines:
        if commands and commands[-1].endswith("\\"):
            commands[-1] += f"\n{line}"
        else:
            commands.append(line)
    return commands


def _folders(env: Any) -> dict[str, Path]:
    folders: dict[str, Path] = env.__dict__.setdefault("terminal_folders", {})
    return folders


def _read_anew(_app: Sphinx, env: Any, docname: str) -> None:
    folder = _folders(env).pop(docname, None)
    if folder is not None:
        shutil.rmtree(folder, ignore_errors=True)


def _start(_app: Sphinx, _env: Any, docnames: list[str]) -> None:
    if docnames:
        prepared.start_server()


def _remove(app: Sphinx, _error: Exception | None) -> None:
    for docname in list(_folders(app.env)):
        _read_anew(app, app.env, docname)
    prepared.remove_prepared()


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("terminal", Terminal)
    app.connect("env-before-read-docs", _start)
    app.connect("env-purge-doc", _read_anew)
    app.connect("build-finished", _remove)
    return {"parallel_read_safe": False, "parallel_write_safe": True}
