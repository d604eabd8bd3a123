"""A cloth made by hand: plain weave of two ends and two picks, textures by formula."""

from __future__ import annotations

import numpy as np

from weaveusd.cloth.model import Floats, Weave
from weaveusd.contract import CHANNELS, GAP, LOBE_MAPS, lobe_file
from weaveusd.export.lobes import yarn_lobes
from weaveusd.export.moments import moment_files
from weaveusd.shading.material import (
    ClothMaterial,
    FitErrors,
    FitsAfar,
    Provenance,
    StandardFit,
    StandardFits,
)
from weaveusd.shading.measured import Measured
from weaveusd.synth.model import Band, TextureSet
from weaveusd.yarn.model import Optics, System, Yarn

REPEAT_MM = (0.8, 1.0)


def yarn(name: str, system: System) -> Yarn:
    optics = Optics(eta=1.54, k_d=0.3, k_s=1.0, gamma_s=0.21, gamma_v=0.42, tau=0.1)
    return Yarn(
        name=name,
        system=system,
        fibre="linen",
        tex=66.0,
        plies=1,
        twist_per_m=500.0,
        twist_direction="Z",
        packing=0.6,
        width_mm=0.3,
        height_mm=0.18,
        twist_angle=-0.35,
        twist_deviation=0.05,
        twist_correlation_mm=1.0,
        spine="circle",
        kappa=0.0,
        color=(0.1 + 0.2, 0.25, 0.125),
        optics=optics,
    )


def floats(at: list[list[int]], length_mm: float) -> Floats:
    return Floats(
        thread=np.array([0, 1], np.int32),
        start=np.array([0, 1], np.int32),
        count=np.array([1, 1], np.int32),
        length_mm=np.array([length_mm, length_mm]),
        center_mm=np.array([0.25, 0.75]) * 2 * length_mm,
        bend_mm=np.full(2, 0.5 * length_mm),
        u_max=np.array([0.5, 0.5]),
        at=np.array(at, np.int32),
    )


def plain_weave() -> Weave:
    width, height = REPEAT_MM
    return Weave(
        warp_up=np.array([[True, False], [False, True]]),
        yarns=(yarn("warp", "warp"), yarn("weft", "weft")),
        warp_yarn=np.array([0, 0], np.int32),
        weft_yarn=np.array([1, 1], np.int32),
        warp_edge_mm=np.linspace(0, width, 3),
        weft_edge_mm=np.linspace(0, height, 3),
        warp_width_mm=np.full(2, 0.3),
        weft_width_mm=np.full(2, 0.4),
        warp_height_mm=np.full(2, 0.18),
        weft_height_mm=np.full(2, 0.2),
        warp_floats=floats([[0, -1], [-1, 1]], height / 2),
        weft_floats=floats([[-1, 0], [1, -1]], width / 2),
        crimp_balance=0.5,
    )


def texels(first: int, last: int, width: int, height: int) -> Band:
    """Return rows of unlike channels, none of them symmetric up and down."""
    y, x = np.mgrid[first:last, 0:width].astype(np.float64)
    u, v = x / width, y / height
    tilt, turn = 0.7 * np.sin(2 * np.pi * u), 2 * np.pi * v
    normal = np.stack([np.sin(tilt), np.zeros_like(u), np.cos(tilt)], -1)
    side = np.stack([np.cos(tilt), np.zeros_like(u), -np.sin(tilt)], -1)
    up = np.cross(normal, side)
    turn = turn[..., None]
    gap = (x.astype(int) % 8 == 0) & (y.astype(int) % 4 == 0)
    index = np.where(v < 0.25, 0.0, 1.0)
    values = {
        "base_color": np.stack([u, v, np.full_like(u, 0.2)], -1),
        "normal": normal,
        "tangent": np.cos(turn) * up + np.sin(turn) * side,
        "height": -0.3 * (v * 0.75 + u * 0.25)[..., None],
        "opacity": np.where(gap, 0.0, 1.0)[..., None],
        "yarn_id": np.where(gap, float(GAP), index)[..., None],
        "system": np.where(gap, float(GAP), index)[..., None],
        "fibre_angle": np.stack([np.cos(2 * np.pi * u), np.sin(2 * np.pi * u)], -1),
        "ambient_occlusion": (0.5 + 0.5 * v)[..., None],
    }
    assert set(values) == {name for name, c in CHANNELS.items() if not c.per_yarn}
    return {name: value.astype(np.float32) for name, value in values.items()}


def texture_set(width: int = 32, height: int = 48) -> TextureSet:
    def band(first: int, last: int) -> Band:
        return texels(first, last, width, height)

    return TextureSet(width, height, REPEAT_MM, 7, band)


def texture_files() -> set[str]:
    """Return the names of the textures that an asset of a cloth has, with all its maps."""
    channels = {file for channel in CHANNELS.values() for file in channel.files}
    return channels | set(map(lobe_file, LOBE_MAPS)) | set(moment_files(plain_weave()))


FIT = StandardFit(alpha_along=0.2, alpha_across=0.8, f0=0.045)
ROUND = StandardFit(0.4, 0.4, 0.045)
FITS = StandardFits(
    FIT, (FIT, FIT), ROUND, (ROUND, ROUND), FitsAfar(FIT, "warp", ROUND),
    FitErrors(0.2, 0.25, 0.4, 0.3, 0.4),
)  # fmt: skip
LOBES = yarn_lobes(FITS)


def cloth(name: str = "plain", *, title: str = "Plain weave", size: int = 32) -> ClothMaterial:
    return ClothMaterial(
        name=name,
        weave=plain_weave(),
        textures=texture_set(size, size * 3 // 2),
        normalization=(1.8608, 1.75),
        measured=(Measured(1.5, (0.2, 0.2, 0.1)), Measured(1.25, (0.3, 0.25, 0.125))),
        fits=FITS,
        provenance=Provenance(
            draft_title=title,
            draft_sha256="0" * 64,
            draft_wif=b"[WIF]\nVersion=1.1\n",
            shafts=2,
            recipe="linen",
            recipe_source="made by hand",
            tool_version="0.1.0",
        ),
    )
