"""Make the example stages: `python examples/stages/make_stages.py [folder [scene …]]`.

Every stage holds a prim `/World/Cloth`, where a published cloth is referenced; what is made of
cloth binds `/World/Cloth/Material`. Until a cloth is there, a gray one stands in. How far warp and
weft are stretched is printed.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

sys.path.insert(0, str(Path(__file__).parent))

import author
import ball
import cushions
import drape
import numpy as np
import pillow
import skirt
import sofa
import swatch
from panels import body_of, sew
from relax import Fabric, stretches
from scenes import SCENES
from skies import write_clear_sky, write_evening_sky

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from panels import Sewn

    Covers = dict[str, tuple[Sewn, NDArray[np.float64]]]

CELLS = {"cornell_drape": 96, "pillow": 72, "skirt": 56}
"""Quads along a side of a panel."""

SOFA_CELL = 0.028
"""Width of a quad of the sofa in metres."""


ANY = Fabric(1.0, 1.0, 1.0, 1.0)
"""How a cloth resists does not matter to how far it is stretched."""


def main(folder: Path, names: list[str]) -> None:
    """Write the stages of `names`, and the geometry and skies that they are made of."""
    folder.mkdir(parents=True, exist_ok=True)
    write_clear_sky(folder / "sky.exr")
    write_evening_sky(folder / "evening.exr")
    for name in dict.fromkeys(name.removesuffix("_sky") for name in names):
        component, make = GEOMETRY[name]
        covers = make()
        author.write_component(folder / f"{name}.geometry.usdc", component, covers)
        report(name, covers)
        if name == "skirt":
            form = sew([skirt.form()])
            author.write_component(
                folder / "skirt.form.usdc", "DressForm", {"Form": (form, form.start)}
            )
    for name in names:
        stage = author.new_stage(folder / f"{name}.usda")
        SCENES[name](stage)
        stage.Save()


def pillow_covers() -> Covers:
    """Return the pillow's cover and the cord in its seam."""
    sewn, rest = pillow.pillow(CELLS["pillow"])
    seam = sew([cushions.cord(rest[cushions.rim(sewn.ids[0])], 0.0025)])
    return {"Cover": (sewn, rest), "Piping": (seam, seam.start)}


def skirt_covers() -> Covers:
    """Return the skirt and its waistband."""
    band = sew([skirt.waistband()])
    return {"Gores": skirt.skirt(CELLS["skirt"]), "Waistband": (band, band.start)}


def sofa_covers() -> Covers:
    """Return the covers of the sofa and all their cords."""
    pieces = sofa.sofa(SOFA_CELL)
    cords = sew([cord for piece in pieces for cord in piece.cords])
    return {piece.name: (piece.sewn, piece.rest) for piece in pieces} | {
        "Piping": (cords, cords.start)
    }


def ball_cover() -> Covers:
    """Return the ball in cloth."""
    cover = sew([ball.ball_facing_z(64)])
    return {"Cover": (cover, cover.start)}


GEOMETRY = {
    "cornell_drape": ("Drape", lambda: {"Cloth": drape.drape(CELLS["cornell_drape"])}),
    "sky_sphere": ("Ball", ball_cover),
    "pillow": ("Pillow", pillow_covers),
    "skirt": ("Skirt", skirt_covers),
    "sofa": ("Sofa", sofa_covers),
    "swatch": ("Swatch", lambda: {"Cloth": swatch.swatch()}),
}


def report(name: str, covers: Covers) -> None:
    """Print triangles and stretch of what was relaxed."""
    for cover, (sewn, rest) in covers.items():
        line = f"{name + ' ' + cover:28} {2 * len(sewn.quads):6} triangles"
        if rest is not sewn.start:
            strain = np.abs(stretches(body_of(sewn, ANY), rest) - 1)
            line += (
                f", stretch {100 * strain.mean():4.1f} % mean, "
                f"{100 * np.quantile(strain, 0.99):4.1f} % at most in 99 of 100, "
                f"{100 * strain.max():4.1f} % at most"
            )
        print(line)


if __name__ == "__main__":
    main(
        Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent,
        sys.argv[2:] or list(SCENES),
    )
