"""How the figures look and how they are written: the same numbers give the same bytes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from weaveusd.errors import WeaveusdError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Format = Literal["png", "svg"]

SURFACE, VOLUME, TOTAL, OTHER, FAINT = "#d55e00", "#0072b2", "#1b1b1b", "#8a2c8f", "#9a9a9a"
"""Colors of what is drawn, told apart by the color-blind too (after Okabe and Ito)."""

COLD_TO_HOT = "magma"

_STYLE: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.titlesize": 9.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#555555",
    "axes.linewidth": 0.7,
    "xtick.color": "#555555",
    "ytick.color": "#555555",
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.frameon": False,
    "lines.solid_capstyle": "round",
    "figure.facecolor": "white",
    "savefig.dpi": 160,
    "svg.hashsalt": "weaveusd",
    "svg.fonttype": "path",
    "path.simplify_threshold": 0.05,
}
_NO_DATES: dict[Format, dict[str, None]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
}


@contextmanager
def style() -> Iterator[None]:
    """Draw and write in our style while the body runs, whatever the user's settings."""
    import matplotlib as mpl

    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_STYLE)
        yield


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure of that size in inches, of no window."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def bare(axes: Axes) -> None:
    """Take spines, ticks and background away."""
    axes.set_axis_off()
    axes.set_aspect("equal")


def write(figure: Figure, folder: Path, name: str, formats: tuple[Format, ...]) -> list[Path]:
    """Write `figure` as folder/name in every format; return the files.

    Raises
    ------
    WeaveusdError
        A file cannot be written.
    """
    files = []
    for suffix in formats:
        file = folder / f"{name}.{suffix}"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            figure.savefig(file, format=suffix, metadata=_NO_DATES[suffix])
        except OSError as error:
            raise WeaveusdError(f"{file}: cannot be written: {error.strerror}") from error
        files.append(file)
    return files
