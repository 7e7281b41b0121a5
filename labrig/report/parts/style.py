"""How figures look: one place for size, type and colours that a colour-blind person can tell."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig.errors import BadInputError
from labrig.files import discard, not_written, part_of

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

POSITIVE, ZERO, NEGATIVE = "#D55E00", "#767676", "#0072B2"  # Okabe and Ito's palette
ALONG_COLOUR, CONSTANT_COLOUR = "#009E73", "#CC79A7"  # two simulations, where colour is free
_PALEST = 0.3  # of a colour: what remains of it at the smallest voltages
# Text, axes and neutral lines. A colour of its own, so that the page can turn it with its theme.
INK = "#1b1f24"

MOST_VOLTAGES = 12  # in a legend
_LETTER_IN, _HANDLE_IN = 0.07, 0.63  # of a legend: a letter; a line with the room around it

_SETTINGS = {
    "figure.dpi": 110,
    "savefig.dpi": 160,
    "figure.constrained_layout.use": True,
    "font.size": 9.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.12,
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
    "text.color": INK,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "grid.color": INK,
    "svg.hashsalt": "labrig",  # the same figure gives the same file
    "svg.fonttype": "none",  # text stays text: searched, copied and edited
    "pdf.fonttype": 42,  # fonts embedded as TrueType
}


_OF_SCREENS = ("backend", "interactive", "toolbar", "webagg", "tk.", "keymap", "date.")


def _settings() -> dict[str, Any]:
    """Return the settings of this style, and matplotlib's own where the user has others.

    Theirs may need a program, such as LaTeX, or colours that hide what is drawn here.
    """
    import matplotlib as mpl

    own = mpl.rcParamsDefault
    kept = (name for name in own if not name.startswith(_OF_SCREENS))
    return {name: own[name] for name in kept if mpl.rcParams[name] != own[name]} | _SETTINGS


def colour_of(voltage_V: float, among: Iterable[float] = ()) -> str:
    """Return the colour of a drive voltage: by its sign.

    `among`: the voltages of the figure; the smaller ones of a sign are lighter.
    """
    if voltage_V == 0:
        return ZERO
    colour = POSITIVE if voltage_V > 0 else NEGATIVE
    largest_V = max((abs(each) for each in among if each * voltage_V > 0), default=abs(voltage_V))
    return _lighter(colour, _PALEST + (1.0 - _PALEST) * abs(voltage_V) / largest_V)


def _lighter(colour: str, share: float) -> str:
    """Mix a colour with white."""
    parts = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return "#" + "".join(f"{round(255 - share * (255 - part)):02X}" for part in parts)


def label_of(voltage_V: float) -> str:
    """Return a voltage for a legend, with its sign and a true minus."""
    return f"{voltage_V:+g} V".replace("-", "\N{MINUS SIGN}") if voltage_V else "0 V"


def styled() -> AbstractContextManager[None]:
    """Return a context in which figures are made in this style."""
    import matplotlib as mpl

    context: AbstractContextManager[None] = mpl.rc_context(_SETTINGS)  # beside the user's own
    return context


@contextmanager
def figure(width_in: float, height_in: float) -> Iterator[Figure]:
    """Yield a new figure in this style, without a screen and without pyplot's global state."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with mpl.rc_context(_settings()):
        fig = Figure(figsize=(width_in, height_in))
        FigureCanvasAgg(fig)
        yield fig


def panels_width_in(panels: int) -> float:
    """Width of a figure with so many panels side by side."""
    return 3.8 * panels if panels > 1 else 5.4


def legend_below(fig: Figure, handles: list[Artist]) -> None:
    """One legend for all panels, in as many columns as there is room for; read row by row.

    Of dozens of voltages, whose colours are in order, it names a few.
    """
    handles = _few_voltages(handles)
    most = min(len(handles), int(fig.get_figwidth() / 1.35))
    names = [len(str(handle.get_label())) for handle in handles]
    columns = next((n for n in range(most, 1, -1) if _width_in(names, n) <= fig.get_figwidth()), 1)
    by_column = [handle for i in range(columns) for handle in handles[i::columns]]
    fig.legend(handles=by_column, loc="outside lower center", ncols=columns)


def _few_voltages(handles: list[Artist]) -> list[Artist]:
    voltages = [i for i, one in enumerate(handles) if str(one.get_label()).endswith(" V")]
    if len(voltages) <= MOST_VOLTAGES:
        return handles
    step = (len(voltages) - 1) / (MOST_VOLTAGES - 1)
    kept = {voltages[round(k * step)] for k in range(MOST_VOLTAGES)}
    return [one for i, one in enumerate(handles) if i in kept or i not in voltages]


def _width_in(names: list[int], columns: int) -> float:
    """Return about how wide a legend is whose names have so many letters each."""
    letters = sum(max(names[i::columns]) for i in range(columns))
    return _LETTER_IN * letters + _HANDLE_IN * columns


def letter(axes: Axes, name: str, title: str) -> None:
    """Write a panel's letter and title above its left edge."""
    axes.set_title(f"({name}) {title}", loc="left")


FORMATS = ("png", "svg", "pdf")
DEFAULT_FORMATS = ("png", "svg")
_METADATA: dict[str, dict[str, None]] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}


def known_formats(wanted: Sequence[str] | None) -> tuple[str, ...]:
    """Return the formats of figures, each once; BadInputError for one that is not known."""
    for one in wanted or ():
        if one not in FORMATS:
            raise BadInputError(f"--format {one}: give {', '.join(FORMATS[:-1])} or {FORMATS[-1]}.")
    return tuple(dict.fromkeys(wanted or DEFAULT_FORMATS))


def save_all(
    fig: Figure, folder: Path, name: str, formats: Sequence[str], svg: str = ""
) -> list[Path]:
    """Write NAME in each format and return the paths; `svg`: the figure as `svg_text` has it."""
    paths = [folder / f"{name}.{ending}" for ending in formats]
    for path in paths:
        save(fig, path, svg)
    return paths


def lay_out(fig: Figure) -> None:
    """Find places for axes, labels and legends, once for all files of a figure.

    That takes as long as drawing it; and a figure that is yet to be laid out matplotlib draws twice
    for each file, the first time without ink.
    """
    import matplotlib as mpl

    engine = fig.get_layout_engine()
    if engine is not None:
        # with equal scales the room that is left turns out smaller than was counted on
        equal = any(axes.get_aspect() != "auto" for axes in fig.axes)
        with mpl.rc_context(_settings()):
            for _ in range(2 if equal else 1):
                engine.execute(fig)
    with _laid_out():
        fig.set_layout_engine(None)


def _laid_out() -> AbstractContextManager[None]:
    """Return a context in which what is saved has its places; to save one sets its layout anew."""
    import matplotlib as mpl

    settled = {"figure.autolayout": False, "figure.constrained_layout.use": False}
    context: AbstractContextManager[None] = mpl.rc_context(_settings() | settled)
    return context


def svg_text(fig: Figure) -> str:
    """Return a figure as SVG, with text that is text."""
    import io

    lay_out(fig)
    text = io.StringIO()
    with _laid_out():
        fig.savefig(text, format="svg", metadata=_METADATA["svg"], transparent=True)
    return text.getvalue()


def save(fig: Figure, path: Path, svg: str = "") -> None:
    """Write a figure beside its place and rename it; the ending chooses png, svg or pdf.

    `svg`: the figure as `svg_text` has it, where it was drawn as that already.
    """
    ending = path.suffix.lower().lstrip(".")
    if ending not in FORMATS:
        raise BadInputError(f"{path}: a figure's name must end in .png, .svg or .pdf.")
    part = part_of(path)
    try:
        if ending == "svg":
            part.write_text(svg or svg_text(fig), encoding="utf-8", newline="\n")
        else:
            lay_out(fig)
            with _laid_out():
                fig.savefig(part, format=ending, metadata=_METADATA.get(ending))
        part.replace(path)
    except OSError as error:
        discard(part)
        raise not_written(path, error) from None
