"""The table of `weaveusd lobes --check`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table

    from weaveusd.proof.check import Row


def as_table(rows: Sequence[Row]) -> Table:
    """Return the rows as a table; what is out of bounds is named in the last column."""
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("yarn", no_wrap=True)
    for name in ("angle", "∫pdf front", "back", "χ² p", "reflected", "through", "reciprocity",
                 "Dr.Jit", "golden"):  # fmt: skip
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("")
    before: tuple[str, ...] = ()
    for row in rows:
        name = "" if row.yarns == before else _name(row.yarns)
        before = row.yarns
        table.add_row(
            name,
            f"{row.angle_deg:g}°",
            f"{row.density_front:.6f}",
            f"{row.density_back:.6f}",
            f"{row.p_value:.3f}",
            f"{row.reflected:.4f}",
            f"{row.transmitted:.4f}",
            f"{row.reciprocity:.0e}",
            f"{row.single:.0e}",
            "–" if row.golden is None else f"{row.golden:.0e}",
            "; ".join(row.faults) or "ok",
            style="red" if row.faults else "",
        )
    return table


def _name(yarns: tuple[str, ...]) -> str:
    return yarns[0] + (f" and {len(yarns) - 1} alike" if len(yarns) > 1 else "")
