"""The figures of `weaveusd lobes`, after figures 6.1 and 6.2 of the thesis.

Angles are in radians, values in 1/sr. The viewer is to the left of the normal; what a mirror
would show is to the right.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.proof.curves import ALBEDO, Form, Plane, cut, from_above
from weaveusd.proof.marks import (
    compass,
    depth_of,
    legend,
    petal,
    protractor,
    thread,
    viewer,
    viridis,
)
from weaveusd.proof.sheet import (
    COLD_TO_HOT,
    FAINT,
    OTHER,
    SURFACE,
    TOTAL,
    VOLUME,
    bare,
    new_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from weaveusd.proof.subjects import Subject

    Doubles = NDArray[np.float64]

PLANES: tuple[tuple[Plane, str], ...] = (
    ("along", "plane of the fibre"),
    ("across", "plane across the fibre"),
)
PIXELS = 420
"""Pixels along the side of a hemisphere."""

DECADES = 3
"""Powers of ten that the colors of a hemisphere span."""

COLUMNS = 4


def components(subject: Subject, forms: Sequence[Form], angles: Sequence[float]) -> Figure:
    """Return polar plots of surface, volume and total, in both planes, a column for each angle.

    A second form is drawn by its total alone. The panels of a row share their scale.
    """
    figure = new_figure(max(3.1 * len(angles) + 0.3, 7.2), 5.4)
    grid = figure.subplots(2, len(angles), squeeze=False)
    for row, (plane, title) in zip(grid, PLANES, strict=True):
        cuts = [[cut(subject, form, plane, angle) for form in forms] for angle in angles]
        reach = max(float(found.total.max()) for each in cuts for _, found in each)
        depth = max(depth_of(*found) for each in cuts for found in each) / reach
        for axes, angle, each in zip(row, angles, cuts, strict=True):
            protractor(axes, reach, depth)
            thread(axes, plane)
            turn, first = each[0]
            for value, color in ((first.surface, SURFACE), (first.volume, VOLUME)):
                petal(axes, turn, value / reach, color, filled=True)
            petal(axes, turn, first.total / reach, TOTAL)
            for turn, other in each[1:]:
                petal(axes, turn, other.total / reach, OTHER, dashed=True)
            viewer(axes, angle)
            axes.set_title(f"{title}, {math.degrees(angle):g}°", color="#333333")
    names = [("surface", SURFACE, "-"), ("volume", VOLUME, "-")]
    names += [(f"total, {forms[0].name}", TOTAL, "-")]
    names += [(f"total, {form.name}", OTHER, "--") for form in forms[1:]]
    legend(figure, [*names, ("mirror image of the viewer (arrow)", FAINT, ":")])
    figure.suptitle(_title(subject), fontsize=11)
    return figure


def cone(subject: Subject, form: Form, angles: Sequence[float]) -> Figure:
    """Return hemispheres, seen from above, a column for each angle; below them what comes through.

    The colors are logarithmic, `DECADES` powers of ten below the brightest, and shared.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm

    sides = (False, True) if subject.optics.tau > 0 else (False,)
    figure = new_figure(max(2.7 * len(angles) + 0.7, 6.4), 2.75 * len(sides) + 0.7)
    grid = figure.subplots(len(sides), len(angles), squeeze=False)
    pictures = [
        [from_above(subject, form, angle, PIXELS, below=side) for angle in angles] for side in sides
    ]
    brightest = max(float(np.nanmax(picture)) for row in pictures for picture in row)
    colors = LogNorm(brightest * 10.0**-DECADES, brightest, clip=True)
    for row, line, below in zip(grid, pictures, sides, strict=True):
        for axes, angle, picture in zip(row, angles, line, strict=True):
            bare(axes)
            axes.imshow(picture, norm=colors, cmap=COLD_TO_HOT, extent=(-1, 1, -1, 1),
                        interpolation="bilinear")  # fmt: skip
            compass(axes, angle, below=below)
            what = "through the yarn" if below else "reflected"
            axes.set_title(f"{what}, {math.degrees(angle):g}°", color="#333333")
    bar = figure.colorbar(
        ScalarMappable(colors, COLD_TO_HOT), ax=list(grid.flat), shrink=0.8, pad=0.02, aspect=30
    )
    bar.set_label("f |n·ωo| in 1/sr")
    figure.suptitle(f"{_title(subject)}; {form.name}\n○ viewer, – fibre", fontsize=10)
    return figure


def side_by_side(subjects: Sequence[Subject], form: Form, angles: Sequence[float]) -> Figure:
    """Return a panel for each subject: the total in the fibre's plane, for every angle.

    Each panel has its own scale, told by its outer ring.
    """
    figure, panels = _small_multiples(len(subjects), 1.7)
    shades = np.linspace(0.15, 0.8, max(len(angles), 2))
    cuts_of = [[cut(subject, form, "along", angle) for angle in angles] for subject in subjects]
    reaches = [max(float(found.total.max()) for _, found in cuts) for cuts in cuts_of]
    depth = max(
        depth_of(*found) / reach
        for cuts, reach in zip(cuts_of, reaches, strict=True)
        for found in cuts
    )
    for axes, subject, cuts, reach in zip(panels, subjects, cuts_of, reaches, strict=False):
        protractor(axes, reach, depth)
        thread(axes, "along")
        for (turn, found), shade in zip(cuts, shades, strict=False):
            petal(axes, turn, found.total / reach, viridis(shade))
        axes.set_title(subject.name, color="#333333")
    legend(
        figure,
        [
            (f"seen from {math.degrees(angle):g}°", viridis(shade), "-")
            for angle, shade in zip(angles, shades, strict=False)
        ],
    )
    figure.suptitle(f"In the plane of the fibre, albedo {ALBEDO:g}; {form.name}", fontsize=11)
    return figure


def gaussian_against_cauchy(
    subjects: Sequence[Subject], angle: float, *, published: bool = False
) -> Figure:
    """Return a panel for each subject: both lobes in the fibre's plane, on a logarithmic scale."""
    figure, panels = _small_multiples(len(subjects), 2.2)
    forms = (Form(published=published), Form(gaussian=True, published=published))
    for axes, subject in zip(panels, subjects, strict=False):
        for form, color in zip(forms, (TOTAL, OTHER), strict=True):
            turn, found = cut(subject, form, "along", angle)
            above = np.abs(turn) < np.pi / 2 - 1e-6
            axes.semilogy(-np.degrees(turn[above]), found.total[above], color=color, lw=1.4)
            axes.semilogy(-np.degrees(turn[above]), np.maximum(found.surface[above], 1e-9),
                          color=color, lw=0.8, ls=(0, (4, 2)))  # fmt: skip
        axes.axvline(math.degrees(angle), color=FAINT, lw=0.7, ls=":")
        axes.set_xlim(-90, 90)
        axes.set_xticks([-90, -45, 0, 45, 90], ["-90°", "-45°", "0°", "45°", "90°"])
        top = max(float(cut(subject, form, "along", angle)[1].total.max()) for form in forms)
        axes.set_ylim(top * 1e-4, top * 2)
        axes.grid(axis="y", color="#e4e4e4", lw=0.6)
        axes.set_title(subject.name, color="#333333")
    colors = zip(forms, (TOTAL, OTHER), strict=True)
    legend(figure, [(form.name, color, "-") for form, color in colors]
            + [("the surface lobe alone", FAINT, "--")])  # fmt: skip
    figure.suptitle(
        f"f |n·ωo| in 1/sr over the angle in the plane of the fibre, seen from "
        f"{math.degrees(angle):g}°; the same γ in both", fontsize=10,
    )  # fmt: skip
    return figure


def _title(subject: Subject) -> str:
    o = subject.optics
    widths = f"γ_s {math.degrees(o.gamma_s):g}°, γ_v {math.degrees(o.gamma_v):g}°"
    return f"{subject.name}: η {o.eta:g}, k_d {o.k_d:g}, {widths}, τ {o.tau:g}; albedo {ALBEDO:g}"


def _small_multiples(count: int, side: float) -> tuple[Figure, list[Axes]]:
    """Return a figure of `count` panels in rows of `COLUMNS` at most."""
    columns = min(count, COLUMNS)
    rows = math.ceil(count / columns)
    figure = new_figure(max(1.25 * side * columns, 5.6), side * rows + 0.8)
    panels = list(figure.subplots(rows, columns, squeeze=False).flat)
    for empty in panels[count:]:
        empty.set_axis_off()
    return figure, panels
