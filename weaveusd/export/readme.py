"""The README.md of an asset: what it is, how it is used, its yarns, networks and losses."""

from __future__ import annotations

import re
from itertools import islice
from typing import TYPE_CHECKING, cast

from weaveusd.color_space import to_rec709
from weaveusd.contract import (
    COLORWAYS,
    MATERIAL_NAME,
    MTLX_SURFACES,
    MTLX_VARIANTS,
    PREVIEW_DIR,
    entry_layer,
)
from weaveusd.export.attributes import cloth_values, plain_text, yarn_values
from weaveusd.export.losses import differing, losses_of
from weaveusd.yarn.color import srgb_from_linear

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping, Sequence

    from weaveusd.contract import ColorSpace
    from weaveusd.export.attributes import Value
    from weaveusd.export.losses import NetworkLosses
    from weaveusd.shading.material import ClothMaterial

MAX_COLORS = 8
"""Yarns of a colorway whose colors are listed."""

_SIGNS = {"carried": "yes", "approximated": "nearly", "dropped": "no"}


def readme_text(
    material: ClothMaterial,
    cover: float,
    colorways: Mapping[str, ClothMaterial] | None = None,
    previews: Mapping[str, Sequence[str]] | None = None,
    also: Collection[str] = (),
) -> str:
    """Return the text, in Markdown, of an asset with its `cover`, the mean of its opacity.

    `colorways` are all of them by name where there are several, the first being `material`, the
    one described in full and the default; `previews` are files of pictures by colorway, of ""
    where there are none; `also` names the networks on request.
    """
    values = cloth_values(material, cover)
    pictures = previews or {}
    sections = [
        _head(material, values, pictures),
        _use(material, tuple(colorways or ())),
        *([_colorways(colorways, pictures, also)] if colorways else []),
        _size(values),
        _yarns(material),
        _networks(losses_of(material, also)),
        _origin(values),
    ]
    return "\n\n".join(sections) + "\n"


def _head(
    material: ClothMaterial, values: dict[str, Value], pictures: Mapping[str, Sequence[str]]
) -> str:
    title = escaped(str(values["draftTitle"])) or material.name
    lines = [
        f"# {material.name}",
        "",
        f"Woven cloth, {title}, of {escaped(str(values['recipe']))}: a material for USD and "
        "MaterialX, with textures made from the geometry of its yarns.",
    ]
    for thumbnail, *_ in islice(pictures.values(), 1):
        lines += ["", f"![The cloth, draped]({PREVIEW_DIR}/{thumbnail})"]
    return "\n".join(lines)


def _use(material: ClothMaterial, colorways: Sequence[str]) -> str:
    entry = entry_layer(material.name)
    lines = [
        "## Use",
        "",
        "```",
        f'def Scope "Cloth" (prepend references = @./{entry}@)',
        "{",
        "}",
        "```",
        "",
        f"Bind `/Cloth/{MATERIAL_NAME}`. Texture coordinates `st` are in **metres** of cloth; for "
        "others override `inputs:uv_scale`, the repeats in one unit of st.",
    ]
    if colorways:
        names = ", ".join(f"`{name}`" for name in colorways)
        lines += [
            "",
            f"The variant set `{COLORWAYS}` of the root has {names}; `{colorways[0]}` is the "
            "default and the one described below the colorways.",
        ]
    surfaces = " or ".join(f"`{name}`" for name in MTLX_VARIANTS)
    lines += ["", f"The variant set `{MTLX_SURFACES}` of the material chooses {surfaces}."]
    return "\n".join(lines)


def _colorways(
    colorways: Mapping[str, ClothMaterial],
    pictures: Mapping[str, Sequence[str]],
    also: Collection[str],
) -> str:
    """Return a row for each colorway, and what its networks lose other than the default's."""
    losses = {name: losses_of(cloth, also) for name, cloth in colorways.items()}
    default = next(iter(losses.values()))
    measured = [n.network for n in default if _error(n) is not None]
    rows = [
        (
            _linked(name, pictures.get(name)), escaped(cloth.provenance.recipe), _colors(cloth),
            *(f"{_error(n):.1%} off" for n in losses[name] if n.network in measured),
        )
        for name, cloth in colorways.items()
    ]  # fmt: skip
    notes = [
        f"- `{name}`, {network}: {effect.effect}: {_SIGNS[effect.fate]}"
        + (f", {effect.how}" if effect.how else "")
        for name, own in losses.items()
        for network, effects in differing(own, default).items()
        for effect in effects
        if effect.error is None
    ]
    parts = [
        "## Colorways",
        "Colors of the yarns as sRGB; behind an arrow what the exact shader shows of one that is "
        "lighter than its fibres reach.",
        _table(("colorway", "recipe", "yarns", *measured), rows),
    ]
    if pictures and len(pictures) < len(colorways):
        parts.append(f"Pictures are made of the first {len(pictures)} colorways only.")
    if notes:
        parts += ["Other than in the default:", "\n".join(notes)]
    return "\n\n".join(parts)


def _linked(colorway: str, files: Sequence[str] | None) -> str:
    """Return the name of a colorway, with a link to its thumbnail where it has one."""
    return f"[`{colorway}`]({PREVIEW_DIR}/{files[0]})" if files else f"`{colorway}`"


def _error(network: NetworkLosses) -> float | None:
    return next((e.error for e in network.effects if e.error is not None), None)


def _colors(material: ClothMaterial) -> str:
    """Return the first yarns with their colors, and how many more there are."""
    shown = []
    for name, values in islice(yarn_values(material).items(), MAX_COLORS):
        color, reached = (
            _hex(values[key], material.color_space) for key in ("color", "colorReached")
        )
        shown.append(f"{name} `{color}`" + (f" → `{reached}`" if reached != color else ""))
    more = len(material.weave.yarns) - len(shown)
    return ", ".join(shown) + (f" and {more} more" if more > 0 else "")


def _hex(color: Value, space: ColorSpace) -> str:
    """Return a linear color of `space` as display sRGB, clipped."""
    linear = to_rec709(cast("tuple[float, float, float]", color), space)
    display = srgb_from_linear(linear)
    return "#" + "".join(f"{round(255 * min(max(c, 0.0), 1.0)):02x}" for c in display)


def _size(values: dict[str, Value]) -> str:
    rows = [
        ("one texture", f"{values['repeatWidth']:.4g} × {values['repeatHeight']:.4g} mm, "
         f"{values['textureWidth']} × {values['textureHeight']} texels, "
         f"{values['repeatsAcross']} × {values['repeatsAlong']} repeats"),
        ("seen from afar", f"moment maps of {values['momentWidth']} × {values['momentHeight']} "
         "texels"),
        ("threads in it", f"{values['ends']} ends, {values['picks']} picks"),
        ("sett", f"{values['endsPerCm']:.4g} ends/cm, {values['picksPerCm']:.4g} picks/cm"),
        ("longest float", f"{values['longestFloat']} threads"),
        ("thickness", f"{values['thickness']:.3g} mm"),
        ("weight", f"{values['arealDensity']:.3g} g/m²"),
        ("cover", f"{values['cover']:.1%}"),
    ]  # fmt: skip
    return "## Size\n\n" + _table(("", ""), rows)


def _yarns(material: ClothMaterial) -> str:
    rows = [
        (
            str(v["id"]), name, str(v["system"]), escaped(str(v["fibre"])), f"{v['tex']:.4g}",
            str(v["plies"]), f"{v['twist']:.4g} {v['twistDirection']}",
            f"{v['width']:.3g} × {v['height']:.3g}",
            f"{v['eta']:.4g}", f"{v['gammaS']:.3g}", f"{v['gammaV']:.3g}",
        )
        for name, v in yarn_values(material).items()
    ]  # fmt: skip
    head = ("id", "yarn", "system", "fibre", "tex", "plies", "twist /m", "section mm",
            "η", "γ_s rad", "γ_v rad")  # fmt: skip
    return "## Yarns\n\n" + _table(head, rows)


def _networks(losses: Sequence[NetworkLosses]) -> str:
    names = [network.network for network in losses]
    effects = list(dict.fromkeys(e.effect for network in losses for e in network.effects))
    rows = []
    for effect in effects:
        fates = []
        for network in losses:
            found = [e for e in network.effects if e.effect == effect]
            fates.append(
                ", ".join(
                    _SIGNS[e.fate] + (f", {e.error:.1%} off" if e.error is not None else "")
                    for e in found
                )
            )
        rows.append((effect, *fates))
    where = [(network.network, f"`{network.where}`", network.readers) for network in losses]
    notes = [
        f"- {network.network}: {e.effect}: {e.how}"
        for network in losses
        for e in network.effects
        if e.how
    ]
    return "\n\n".join(
        (
            "## Networks",
            _table(("network", "where", "read by"), where),
            "What each carries of the exact cloth. An error is Σ |f̂ − f| / Σ f of the tile's "
            "reflectance over directions that were not fitted.",
            _table(("effect", *names), rows),
            "\n".join(notes),
        )
    )


def _origin(values: dict[str, Value]) -> str:
    rows = [
        ("draft", f"`draft.wif`, SHA-256 of the file read `{values['draftSha256']}`"),
        ("recipe", f"`recipe.toml`: {escaped(str(values['recipeSource']))}"),
        ("seed", str(values["seed"])),
        ("color space", f"`{values['colorSpace']}`"),
        ("made by", f"weaveusd {escaped(str(values['toolVersion']))}"),
    ]
    return "## Origin\n\n" + _table(("", ""), rows)


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def escaped(text: str) -> str:
    """Return `text` from outside as one line that Markdown shows as it is."""
    return re.sub(r"([\\`*_\[\]<>|~&])", r"\\\1", plain_text(text))
