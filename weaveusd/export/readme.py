"""The README.md of an asset: what it is, how it is used, its yarns, networks and losses."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from weaveusd.contract import COLORWAYS, MATERIAL_NAME, MTLX_SURFACES, MTLX_VARIANTS, entry_layer
from weaveusd.export.attributes import cloth_values, plain_text, yarn_values
from weaveusd.export.losses import losses_of

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Sequence

    from weaveusd.export.attributes import Value
    from weaveusd.export.losses import NetworkLosses
    from weaveusd.shading.material import ClothMaterial

_SIGNS = {"carried": "yes", "approximated": "nearly", "dropped": "no"}


def readme_text(
    material: ClothMaterial,
    cover: float,
    colorways: Sequence[str] = (),
    previews: bool = False,
    also: Collection[str] = (),
) -> str:
    """Return the text, in Markdown, of an asset with its `cover`, the mean of its opacity.

    `colorways` are the names of all of them where there are several, the first being the one
    described and the default; with `previews` there are pictures; `also` names the networks on
    request.
    """
    values = cloth_values(material, cover)
    sections = [
        _head(material, values, previews),
        _use(material, colorways),
        _size(values),
        _yarns(material),
        _networks(losses_of(material, also)),
        _origin(values),
    ]
    return "\n\n".join(sections) + "\n"


def _head(material: ClothMaterial, values: dict[str, Value], previews: bool) -> str:
    title = escaped(str(values["draftTitle"])) or material.name
    lines = [
        f"# {material.name}",
        "",
        f"Woven cloth, {title}, of {escaped(str(values['recipe']))}: a material for USD and "
        "MaterialX, with textures made from the geometry of its yarns.",
    ]
    if previews:
        lines += ["", "![The cloth, draped](previews/draped.png)"]
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
            "default and the one described here.",
        ]
    surfaces = " or ".join(f"`{name}`" for name in MTLX_VARIANTS)
    lines += ["", f"The variant set `{MTLX_SURFACES}` of the material chooses {surfaces}."]
    return "\n".join(lines)


def _size(values: dict[str, Value]) -> str:
    rows = [
        ("one texture", f"{values['repeatWidth']:.4g} × {values['repeatHeight']:.4g} mm, "
         f"{values['textureWidth']} × {values['textureHeight']} texels, "
         f"{values['repeatsAcross']} × {values['repeatsAlong']} repeats"),
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
