"""What a person wants to know of a cloth, read from the attributes of its material."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from html import escape
from itertools import islice
from typing import Any

from pxr import Sdf, Usd, UsdShade, Vt

from weaveusd.contract import CLOTH_API, CLOTH_NAMESPACE, MAX_YARNS, YARN_NAMESPACE

MAX_TEXT = 300
"""Characters of a value that are shown."""

MAX_PRIMS = 10_000
"""Prims below a selected one that are searched for a cloth."""

Row = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Section:
    """A table: its title, the heads of its columns if it has any, and its rows."""

    title: str
    head: Row
    rows: tuple[Row, ...]


@dataclass(frozen=True, slots=True)
class ClothCard:
    """A cloth in words. `draft` is the resolved path of its draft, "" where there is none."""

    title: str
    prim: str
    sections: tuple[Section, ...]
    draft: str


def find_cloth(prim: Usd.Prim) -> Usd.Prim:
    """Return the cloth material that `prim` is about, or an invalid prim.

    It is `prim` itself or one that it lies in, else the material bound to it, else the first
    below it.
    """
    above: Usd.Prim = prim
    while above and not above.IsPseudoRoot():
        if _is_cloth(above):
            return above
        above = above.GetParent()
    bound = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0].GetPrim()
    if bound and _is_cloth(bound):
        return bound
    below = (p for p in islice(Usd.PrimRange(prim), MAX_PRIMS) if _is_cloth(p))
    return next(below, Usd.Prim())


def cloth_card(material: Usd.Prim) -> ClothCard:
    """Return what the cloth `material` says of itself; what is not authored is left out."""
    cloth = _Values(material, CLOTH_NAMESPACE)
    title = cloth.text("draftTitle") or material.GetParent().GetName() or material.GetName()
    draft = cloth.value("draft")
    return ClothCard(
        title,
        str(material.GetPath()),
        tuple(s for s in (*_facts(cloth), _yarns(material, cloth), _origin(cloth)) if s.rows),
        draft.resolvedPath if isinstance(draft, Sdf.AssetPath) else "",
    )


def card_html(card: ClothCard) -> str:
    """Return the card as HTML; every text that comes from the asset is escaped."""
    parts = [f"<h2>{escape(card.title)}</h2><p><code>{escape(card.prim)}</code></p>"]
    for section in card.sections:
        head = "".join(f"<th align='left'>{escape(cell)}</th>" for cell in section.head)
        rows = "".join(
            "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>"
            for row in section.rows
        )
        parts.append(
            f"<h3>{escape(section.title)}</h3><table cellpadding='3'>"
            f"{f'<tr>{head}</tr>' if head else ''}{rows}</table>"
        )
    return "".join(parts)


def card_text(card: ClothCard) -> str:
    """Return the card as plain text, to be copied."""
    lines = [card.title, card.prim]
    for section in card.sections:
        lines += ["", section.title]
        table = [section.head, *section.rows] if section.head else list(section.rows)
        widths = [max(len(cell) for cell in column) for column in zip(*table, strict=True)]
        lines += ["  ".join(_filled(row, widths)).rstrip() for row in table]
    return "\n".join(lines) + "\n"


class _Values:
    """The attributes of a namespace, as text."""

    def __init__(self, prim: Usd.Prim, namespace: str) -> None:
        self._prim, self._namespace = prim, namespace

    def value(self, name: str) -> Any:
        return self._prim.GetAttribute(f"{self._namespace}:{name}").Get()

    def text(self, name: str, unit: str = "") -> str:
        """Return a value on one line with its unit, "" where there is none."""
        value = self.value(name)
        if value is None:
            return ""
        shown = f"{value:.4g}" if isinstance(value, float) else str(value)
        shown = " ".join(shown.split())
        return f"{shown[:MAX_TEXT]} {unit}".rstrip()

    def pair(self, one: str, other: str, unit: str = "") -> str:
        """Return two values as 3 × 4, "" unless both are there."""
        first, second = self.text(one), self.text(other, unit)
        return f"{first} × {second}" if first and second else ""


def _facts(cloth: _Values) -> Iterator[Section]:
    yield _section(
        "Draft",
        ("Title", cloth.text("draftTitle")),
        ("Ends × picks in the repeat", cloth.pair("ends", "picks")),
        ("Repeats of the draft in it", cloth.pair("repeatsAcross", "repeatsAlong")),
        ("Shafts", cloth.text("shafts")),
        ("Longest float", cloth.text("longestFloat", "threads")),
    )
    yield _section(
        "Size",
        ("Width × height of the repeat", cloth.pair("repeatWidth", "repeatHeight", "mm")),
        ("Ends × picks a centimetre", cloth.pair("endsPerCm", "picksPerCm")),
        ("Thickness", cloth.text("thickness", "mm")),
        ("Weight", cloth.text("arealDensity", "g/m²")),
        ("Cover", cloth.text("cover")),
        ("Texels of the repeat", cloth.pair("textureWidth", "textureHeight")),
    )


def _yarns(material: Usd.Prim, cloth: _Values) -> Section:
    head = ("Id", "Yarn", "System", "Fibre", "tex", "Plies", "Twist /m", "Section mm", "Color")
    rows = []
    names = cloth.value("yarns")
    for name in islice(names if isinstance(names, Vt.TokenArray) else (), MAX_YARNS):
        yarn = _Values(material, f"{YARN_NAMESPACE}:{name}")
        twist = f"{yarn.text('twist')} {yarn.text('twistDirection')}".strip()
        cells = [yarn.text(key) for key in ("system", "fibre", "tex", "plies")]
        section = yarn.pair("width", "height")
        rows.append((yarn.text("id"), str(name), *cells, twist, section, _color(yarn)))
    return Section("Yarns", head, tuple(rows))


def _color(yarn: _Values) -> str:
    value = yarn.value("color")
    try:
        return " ".join(f"{component:.3f}" for component in value)
    except (TypeError, ValueError):
        return ""


def _origin(cloth: _Values) -> Section:
    return _section(
        "Origin",
        ("Recipe", cloth.text("recipe")),
        ("Source", cloth.text("recipeSource")),
        ("Seed", cloth.text("seed")),
        ("Color space", cloth.text("colorSpace")),
        ("Made by weaveusd", cloth.text("toolVersion")),
        ("SHA-256 of the draft", cloth.text("draftSha256")),
        ("SHA-256 of the drawdown", cloth.text("drawdownSha256")),
    )


def _section(title: str, *rows: Row) -> Section:
    return Section(title, (), tuple(row for row in rows if row[-1]))


def _filled(row: Sequence[str], widths: Iterable[int]) -> Iterator[str]:
    for cell, width in zip(row, widths, strict=True):
        yield cell.ljust(width)


def _is_cloth(prim: Usd.Prim) -> bool:
    return CLOTH_API in prim.GetPrimTypeInfo().GetAppliedAPISchemas()
