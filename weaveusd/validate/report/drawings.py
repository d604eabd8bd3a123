"""Drawings of a report, as SVG: the draft, and how a yarn scatters."""

from __future__ import annotations

import math

import numpy as np

from weaveusd.validate.drafts import ReadDraft
from weaveusd.validate.scattering import YarnOptics, lobes

MOST_THREADS = 64
"""Ends and picks of a draft that are drawn, from its first corner."""

CELL = 8
RADIUS = 100
INCLINATIONS_DEG = (0, 30, 60)
COLORS = ("#1f4e79", "#b8541a", "#3a7d44")


def draft_svg(draft: ReadDraft) -> str:
    """Return the drawdown, warp on top dark, the first pick at the bottom, the first end left."""
    shown = draft.warp_up[:MOST_THREADS, :MOST_THREADS]
    picks, ends = shown.shape
    width, height = ends * CELL, picks * CELL
    cells = "".join(
        f"M{end * CELL} {(picks - 1 - pick) * CELL}h{CELL}v{CELL}h-{CELL}z"
        for pick, end in np.argwhere(shown)
    )
    grid = "".join(f"M{x * CELL} 0v{height}" for x in range(ends + 1))
    grid += "".join(f"M0 {y * CELL}h{width}" for y in range(picks + 1))
    return (
        f'<svg viewBox="-1 -1 {width + 2} {height + 2}" width="{min(2 * width, 420)}" '
        'role="img" aria-label="Drawdown">'
        f'<path d="{cells}" fill="#26323c"/>'
        f'<path d="{grid}" stroke="#9aa5ad" stroke-width="0.5" fill="none"/></svg>'
    )


def lobe_svg(optics: YarnOptics) -> str:
    """Return a polar plot of a white yarn's lobes in the plane of its fibre, of three angles.

    The length is the value times the cosine in a logarithmic scale, two decades long.
    """
    angles = np.linspace(-math.pi / 2, math.pi / 2, 181)
    curves, lengths = [], []
    for degrees in INCLINATIONS_DEG:
        surface, volume = lobes(optics, math.radians(degrees), 0.0, angles, 0.0)
        lengths.append((surface + volume) * np.cos(angles))
    top = max(float(length.max()) for length in lengths)
    for degrees, length, color in zip(INCLINATIONS_DEG, lengths, COLORS, strict=True):
        share = np.clip(1 + np.log10(np.maximum(length / top, 1e-9)) / 2, 0, 1)
        x, y = RADIUS * share * np.sin(angles), -RADIUS * share * np.cos(angles)
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
        towards = math.radians(degrees)
        curves.append(
            f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="1.5"/>'
            f'<path d="M0 0L{RADIUS * math.sin(towards):.1f} {-RADIUS * math.cos(towards):.1f}" '
            f'stroke="{color}" stroke-width="0.5" stroke-dasharray="3 2"/>'
        )
    return (
        f'<svg viewBox="{-RADIUS - 4} {-RADIUS - 4} {2 * RADIUS + 8} {RADIUS + 12}" width="260" '
        'role="img" aria-label="Lobes">'
        f'<path d="M{-RADIUS} 0A{RADIUS} {RADIUS} 0 0 1 {RADIUS} 0z" fill="none" '
        f'stroke="#c4ccd2"/>{"".join(curves)}</svg>'
    )
