"""What the figures are drawn with: rings, petals, the yarn, the viewer, the legend.

A panel is drawn in shares of its largest value, the normal upwards and the viewer on the left.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.proof.sheet import FAINT, bare

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from weaveusd.proof.curves import Parts, Plane

    Doubles = NDArray[np.float64]

_LETTER, _HANDLE = 0.075, 0.65
"""Inches that a letter of the legend takes, and the line before a name with the space after it."""


def depth_of(turn: Doubles, found: Parts) -> float:
    """Return how far what comes through the yarn reaches down."""
    return float(np.max(-np.cos(turn) * found.total))


def protractor(axes: Axes, reach: float, depth: float) -> None:
    """Draw rings and rays for values up to `reach`, cut off below `depth` of it."""
    bare(axes)
    low = -max(1.15 * depth, 0.12)
    angles = np.linspace(-np.pi / 2, np.pi / 2, 181)
    step = _round_step(reach)
    for ring in np.arange(step, reach * (1 + 1e-9), step) / reach:
        axes.plot(ring * np.sin(angles), ring * np.cos(angles), color="#dddddd", lw=0.6, zorder=0)
        axes.text(ring, -0.015, f"{ring * reach:.3g}", ha="center", va="top", fontsize=6.5,
                  color=FAINT)  # fmt: skip
    for ray in np.radians(np.arange(-90, 91, 30)):
        axes.plot([0, np.sin(ray)], [0, np.cos(ray)], color="#e6e6e6", lw=0.6, zorder=0)
    axes.set_xlim(-1.08, 1.08)
    axes.set_ylim(low, 1.1)


def _round_step(reach: float) -> float:
    """Return 1, 2 or 5 times a power of ten, of which two to five fit into `reach`."""
    power = 10.0 ** math.floor(math.log10(reach / 2))
    return next(power * k for k in (5.0, 2.0, 1.0) if power * k <= reach / 2)


def petal(
    axes: Axes, turn: Doubles, radius: Doubles, color: str, *, filled: bool = False,
    dashed: bool = False,
) -> None:  # fmt: skip
    """Draw a closed curve of `radius` (N,), in shares, over the angles `turn` (N,)."""
    x, y = -radius * np.sin(turn), radius * np.cos(turn)
    if filled:
        axes.fill(x, y, color=color, alpha=0.18, lw=0)
    axes.plot(x, y, color=color, lw=1.3, ls=(0, (4, 2)) if dashed else "-")


def thread(axes: Axes, plane: Plane) -> None:
    """Draw the yarn at the origin: a bar along the fibre, a disk across it."""
    if plane == "along":
        axes.plot([-0.09, 0.09], [0, 0], color="#777777", lw=4, solid_capstyle="round", zorder=5)
    else:
        axes.plot([0], [0], "o", color="#777777", ms=6, zorder=5)


def viewer(axes: Axes, angle: float) -> None:
    """Draw where the viewer is, and where a mirror would look."""
    x, y = -math.sin(angle), math.cos(angle)
    axes.annotate("", (0.72 * x, 0.72 * y), (1.06 * x, 1.06 * y),
                  arrowprops={"arrowstyle": "-|>", "color": "#555555", "lw": 0.9})  # fmt: skip
    axes.plot([0, -x], [0, y], color=FAINT, lw=0.8, ls=":")


def compass(axes: Axes, angle: float, *, below: bool) -> None:
    """Draw the rim, rings every 30°, the fibre's direction, the viewer and the mirrored cone."""
    turn = np.linspace(0, 2 * np.pi, 241)
    for ring in (1 / 3, 2 / 3, 1.0):
        axes.plot(ring * np.cos(turn), ring * np.sin(turn), color="white", lw=0.5, alpha=0.35)
    axes.plot([-1.06, -1.0], [0, 0], color="#777777", lw=3)
    axes.plot([1.0, 1.06], [0, 0], color="#777777", lw=3)
    if not below:
        axes.plot([-angle / (np.pi / 2)], [0], "o", mfc="none", mec="#4dd2ff", ms=6, mew=1.2)
    axes.set_xlim(-1.08, 1.08)
    axes.set_ylim(-1.08, 1.08)


def legend(figure: Figure, names: Sequence[tuple[str, str, str]]) -> None:
    """Draw one line for each label, color and line style below the panels."""
    from matplotlib.lines import Line2D

    lines = [Line2D([], [], color=c, ls=style, lw=1.6, label=name) for name, c, style in names]
    inches = sum(_LETTER * len(name) + _HANDLE for name, *_ in names)
    rows = math.ceil(inches / figure.get_figwidth())
    columns = math.ceil(len(lines) / rows)
    figure.legend(handles=lines, loc="outside lower center", ncols=columns, fontsize=8.5)


def viridis(share: float) -> str:
    """Return the color at a share of a map that is even to the eye."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    return str(to_hex(colormaps["viridis"](share)))
