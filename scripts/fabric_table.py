"""Write the tables and swatches of docs/fabrics.md from the fabric presets.

`--check` only compares.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813

from weaveusd.cloth import measures
from weaveusd.cloth.model import Weave
from weaveusd.cloth.weave import weave
from weaveusd.draft.make import make_draft
from weaveusd.swatch import swatch
from weaveusd.yarn.model import Recipe, System, YarnSpec
from weaveusd.yarn.recipe import preset_names, read_preset
from weaveusd.yarn.textile import diameter_mm

PAGE = Path(__file__).resolve().parents[1] / "docs" / "fabrics.md"
PICTURES = PAGE.parent / "figures"
SWATCH = (96, 48)
"""Pixels of a swatch, across and up."""

BEGIN, END = "<!-- made by scripts/fabric_table.py -->\n", "<!-- end -->\n"

SHOPS = {
    "canvas": (300, 500), "charmeuse": (52, 130), "chiffon": (26, 35),
    "crepe_de_chine": (52, 69), "denim": (200, 400), "poplin": (110, 160),
}  # fmt: skip
"""g/m² that shops quote, from the two charts that docs/fabrics.md names."""


def fabrics() -> list[tuple[Recipe, Weave]]:
    """Return the fabric presets, each woven in the weave that it names."""
    recipes = (read_preset(name) for name in preset_names())
    return [(r, weave(make_draft(r.weave), r)) for r in recipes if r.kind == "fabric"]


def tables() -> str:
    """Return both tables and the list of sources as Markdown."""
    made = fabrics()
    lines = [
        "| | fabric | weave | counts | per inch | diameter µm | section µm | cover | crimp % |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
        *(_threads(recipe, cloth) for recipe, cloth in made),
        "",
        "| fabric | computed g/m² | without crimp | reference | off by | shops quote |",
        "| --- | --- | --- | --- | --- | --- |",
        *(_weight(recipe, cloth) for recipe, cloth in made),
        "",
        *(_source(recipe) for recipe, _ in made),
    ]
    return "\n".join(lines) + "\n"


def _threads(recipe: Recipe, cloth: Weave) -> str:
    warp, weft = _spec(recipe, "warp"), _spec(recipe, "weft")
    crimps = measures.crimps(cloth)
    warp_cover, weft_cover = measures.warp_cover(cloth), measures.weft_cover(cloth)
    both = [
        [1e3 * diameter_mm(s.tex, s.fibre, s.packing) for s in (warp, weft)],
        [f"{1e3 * y.width_mm:.0f} × {1e3 * y.height_mm:.0f}" for y in _yarns(cloth)],
        [warp_cover, weft_cover, warp_cover + weft_cover - warp_cover * weft_cover],
        [100 * crimps[cloth.warp_yarn[0]], 100 * crimps[cloth.weft_yarn[0]]],
    ]
    cells = [
        f"![{recipe.name}](figures/{picture_name(recipe)})", recipe.name, f"`{recipe.weave}`",
        _pair(warp.count, weft.count),
        f"{recipe.ends_per_cm * 2.54:.4g} × {recipe.picks_per_cm * 2.54:.4g}",
        _pair(*(f"{d:.0f}" for d in both[0])), _pair(*both[1]),
        " / ".join(f"{c:.2f}" for c in both[2]), _pair(*(f"{c:.1f}" for c in both[3])),
    ]  # fmt: skip
    return f"| {' | '.join(cells)} |"


def _weight(recipe: Recipe, cloth: Weave) -> str:
    computed, reference = measures.areal_density_g_m2(cloth), recipe.weight_g_m2
    off = "—" if reference is None else f"{round(100 * (computed / reference - 1)):+d} %"
    shops = "–".join(str(g) for g in SHOPS[recipe.name]) if recipe.name in SHOPS else "—"
    stated = "—" if reference is None else f"{reference:g}"
    straight = sum(
        cloth.yarns[of_thread[0]].tex * per_cm * 0.1
        for of_thread, per_cm in (
            (cloth.warp_yarn, recipe.ends_per_cm), (cloth.weft_yarn, recipe.picks_per_cm),
        )
    )  # fmt: skip
    return f"| {recipe.name} | {computed:.0f} | {straight:.0f} | {stated} | {off} | {shops} |"


def _source(recipe: Recipe) -> str:
    return (
        f"- **{recipe.name}**: {recipe.title}; {recipe.finish}. *Source:* {recipe.source}. "
        f"*Certainty:* {recipe.certainty}."
    )


def _spec(recipe: Recipe, system: System) -> YarnSpec:
    return next(spec for spec in recipe.yarns if system in spec.systems)


def _yarns(cloth: Weave) -> tuple:
    return cloth.yarns[cloth.warp_yarn[0]], cloth.yarns[cloth.weft_yarn[0]]


def _pair(warp: str, weft: str) -> str:
    return warp if warp == weft else f"{warp} / {weft}"


def picture_name(recipe: Recipe) -> str:
    """Return the file name of a preset's swatch."""
    return f"fabrics_{recipe.name}.png"


def drawn(recipe: Recipe) -> np.ndarray:
    """Return the swatch of a preset, (H, W, 3) uint8."""
    width, height = SWATCH
    return swatch(recipe, width=width, height=height)


def is_drawn(recipe: Recipe) -> bool:
    """Return whether the swatch in docs is the preset's, to a step: sines differ by machine."""
    path = PICTURES / picture_name(recipe)
    stored = oiio.ImageBuf(str(path)).get_pixels(oiio.UINT8) if path.is_file() else None
    made = drawn(recipe)
    if stored is None or stored.shape != made.shape:
        return False
    return int(np.abs(stored.astype(int) - made.astype(int)).max()) <= 1


def draw(recipe: Recipe) -> None:
    """Write the swatch of a preset."""
    image = oiio.ImageBuf(drawn(recipe))
    image.specmod().attribute("png:compressionLevel", 9)
    if not image.write(str(PICTURES / picture_name(recipe))):
        raise SystemExit(image.geterror())


def page() -> str:
    """Return docs/fabrics.md with its tables made anew."""
    text = PAGE.read_text(encoding="utf-8")
    before, _, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not end:
        raise SystemExit(f"{PAGE}: expected {BEGIN.strip()} and {END.strip()}")
    return before + BEGIN + tables() + END + after


def main() -> None:
    """Write page and swatches, or with `--check` exit with 1 when one is out of date."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    made = page()
    if not check:
        PAGE.write_text(made, encoding="utf-8")
    elif made != PAGE.read_text(encoding="utf-8"):
        raise SystemExit(f"{PAGE}: out of date; run scripts/fabric_table.py")
    for recipe, _ in fabrics():
        if not is_drawn(recipe):
            if check:
                raise SystemExit(
                    f"{picture_name(recipe)}: out of date; run scripts/fabric_table.py"
                )
            draw(recipe)


if __name__ == "__main__":
    main()
