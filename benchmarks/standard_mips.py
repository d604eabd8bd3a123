"""The standard shaders from afar: maps with widened lobes against averaged ones.

    python benchmarks/standard_mips.py [--pairs 192] [--texels 6]

Cloths of plain, twill and satin are woven of silk, polyester and linen, and their lobe maps written
as an asset has them. A texel of a coarse level is shaded as OpenPBR and UsdPreviewSurface have
it, about the mean normal and in the mean color of what it covers, and compared with the mean of
the exact BSDF over that: Σ |f̂ − f| / Σ f over pairs of directions, texels of 1, 2 and 4
crossings and of the whole tile, in %.

- naive: roughness, anisotropy and the fibre's direction are averaged, as a mip map of textures of
  angles or directions does;
- rotation: the finest level of the lobe maps is averaged, as by a renderer that makes mip maps of
  its own;
- ours: the level that the files hold;
- fit: of the tile, the error that the asset states for it.

Fails where ours is worse than naive, or than the asset states of the tile: see `SLACK`.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813

from weaveusd.cloth.model import Weave
from weaveusd.cloth.weave import weave
from weaveusd.contract import LOBE_MAPS, lobe_file
from weaveusd.draft.make import make_draft
from weaveusd.draft.resolve import from_drawdown
from weaveusd.draft.weaves import tiled
from weaveusd.export.lobe_maps import lobe_maps
from weaveusd.export.lobes import yarn_lobes
from weaveusd.export.textures import write_textures
from weaveusd.shading.directions import pairs
from weaveusd.shading.distance import parameters
from weaveusd.shading.fibre import dot, facing
from weaveusd.shading.lobe import COSINES, albedos, fresnel_edge, halfway, lit, mirror
from weaveusd.shading.material import ClothMaterial, Provenance, StandardFits
from weaveusd.shading.microcylinder import evaluate as exact
from weaveusd.shading.shade import shade
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.recipe import read_preset

Values = np.ndarray[Any, np.dtype[np.float64]]

DRAFTS = ("plain", "twill:2/2", "satin:5:2")
MATERIALS = ("silk", "polyester", "linen")
WAYS = ("naive", "rotation", "ours")
CROSSINGS = (1, 2, 4)
PER_THREAD = 16
"""Texels from thread to thread: levels 4, 5 and 6 have texels of 1, 2 and 4 crossings."""

MOST_TEXELS = 1024
"""Texels below a coarse one that are looked at."""

SLACK, SLACK_OF_ONE = 0.005, 0.02
"""What ours may be worse than naive; more where a texel holds parts of one or two floats."""

STATED = 0.07
"""What ours may be worse than the asset states of the tile, from other texels and directions."""


@dataclass(frozen=True)
class Cloth:
    """A cloth with the texels of its finest level and every level of its lobe maps."""

    made: Weave
    fits: StandardFits
    gains: Values  # (yarns,)
    texels: dict[str, Values]  # (H, W, components), the top row first
    levels: dict[str, list[Values]]


@dataclass(frozen=True)
class Lobe:
    """What a standard shader reads: α along and across a fibre (3,)."""

    along: float
    across: float
    fibre: Values


def main() -> None:
    """Print the tables and exit with 1 where a goal is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=192)
    parser.add_argument("--texels", type=int, default=6, help="of each level that are compared")
    given = parser.parse_args()
    wi, wo = pairs(given.pairs)
    missed: list[str] = []
    cloths = {case: _cloth(*case) for case in product(DRAFTS, MATERIALS)}
    for network in ("OpenPBR", "UsdPreviewSurface"):
        header = "".join(f"{f'{size} crossings':>24}" for size in CROSSINGS) + f"{'tile':>30}"
        print(f"\n{network}: {' / '.join(WAYS)}, error in %; of the tile also the fit")
        print(f"{'':<24}{header}")
        for case, cloth in cloths.items():
            rows = _errors(cloth, network, wi, wo, given.texels)
            stated = getattr(cloth.fits.errors, _STATED[network])
            cells = ["/".join(f"{100 * row[way]:7.1f}" for way in WAYS) for row in rows]
            line = "".join(f"{cell:>24}" for cell in cells)
            print(f"{', '.join(case):<24}{line}{100 * stated:6.1f}")
            missed += _missed(f"{network}, {', '.join(case)}", rows, stated)
    print("\n" + ("\n".join(missed) if missed else "every goal is met"))
    sys.exit(1 if missed else 0)


_STATED = {"OpenPBR": "openpbr_afar", "UsdPreviewSurface": "preview_afar"}


def _missed(who: str, rows: list[dict[str, float]], stated: float) -> Iterator[str]:
    for size, row in zip((*map(str, CROSSINGS), "tile"), rows, strict=True):
        slack = SLACK_OF_ONE if size == "1" else SLACK
        if row["ours"] > row["naive"] + slack:
            yield f"missed: {who}, {size}: {row['ours']:.3f}, naive {row['naive']:.3f}"
    if rows[-1]["ours"] > stated + STATED:
        yield f"missed: {who}: {rows[-1]['ours']:.3f} of the tile, stated {stated:.3f}"


def _cloth(name: str, preset: str) -> Cloth:
    """Weave a patch of some crossings, and write and read its maps."""
    draft, recipe = make_draft(name), read_preset(preset)
    up = draft.drawdown()
    repeats = 16 // len(up)
    up = tiled(up, repeats * len(up), repeats * len(up))
    ends = np.zeros(len(up), np.int32)
    made = weave(from_drawdown(up, ends, ends + 1, draft.palette), recipe)
    width, height = made.repeat_mm
    pitch = min(width / made.ends, height / made.picks)
    textures = synthesize(made, resolution=round(PER_THREAD * max(width, height) / pitch))
    origin = Provenance("", "0" * 64, b"", 0, preset, "", "0")
    material = shade("cloth", made, textures, origin)
    with tempfile.TemporaryDirectory() as scratch:
        levels = _written(material, Path(scratch))
    texels = {n: np.asarray(rows[::-1], float) for n, rows in textures.whole().items()}
    gains = np.array([measured.gain for measured in material.measured])
    return Cloth(made, material.fits, gains, texels, levels)


def _written(material: ClothMaterial, folder: Path) -> dict[str, list[Values]]:
    """Return every level of the lobe maps of `material`, written to and read from `folder`."""
    with lobe_maps(material, folder) as add:
        write_textures(material.textures, folder, yarn_lobes(material.fits), also=[add])
    return {name: _levels(folder / lobe_file(name)) for name in LOBE_MAPS}


def _levels(path: Path) -> list[Values]:
    source = oiio.ImageInput.open(str(path))
    found: list[Values] = []
    while source.seek_subimage(0, len(found)):
        spec = source.spec()
        pixels = source.read_image(0, len(found), 0, spec.nchannels, oiio.FLOAT)
        found.append(np.asarray(pixels, float).reshape(spec.height, spec.width, -1))
    source.close()
    return found


def _errors(
    cloth: Cloth, network: str, wi: Values, wo: Values, count: int
) -> list[dict[str, float]]:
    """Return the mean error of each way for each size of texels, the tile last."""
    depth = len(cloth.levels["roughness"])
    first = PER_THREAD.bit_length() - 1
    rows = []
    for level in (*(first + size.bit_length() - 1 for size in CROSSINGS), depth - 1):
        high, wide = cloth.levels["roughness"][level].shape[:2]
        chosen = np.random.default_rng(level).permutation(high * wide)[:count]
        errors = [_error(cloth, network, level, divmod(int(k), wide), wi, wo) for k in chosen]
        rows.append({way: float(np.mean([e[way] for e in errors])) for way in WAYS})
    return rows


def _error(
    cloth: Cloth, network: str, level: int, place: tuple[int, int], wi: Values, wo: Values
) -> dict[str, float]:
    """Return Σ |f̂ − f| / Σ f of each way for the texel of a level at row and column `place`."""
    below = _below(cloth, level, place)
    truth = _truth(cloth, below, wi, wo)
    found = {
        "naive": _averaged(cloth, network, below),
        "rotation": _rotated(cloth, network, below),
        "ours": _published(cloth, network, below, level, place),
    }
    fit = (cloth.fits.yarns if network == "OpenPBR" else cloth.fits.isotropic_yarns)[0]
    errors = {}
    for way, lobe in found.items():
        value = _shaded(lobe, below, fit.f0, fit.base, wi, wo)
        errors[way] = float(np.abs(value - truth).sum() / truth.sum())
    return errors


@dataclass(frozen=True)
class Below:
    """Texels (N,) below a coarse one, with what a renderer's own mip maps make of them."""

    yarn: Values
    opacity: Values
    weight: Values  # opacity, as shares
    normal: Values  # (N, 3)
    fibre: Values  # (N, 3)
    color: Values  # (N, 3)

    @property
    def mean_normal(self) -> Values:
        """The unit mean of the normals."""
        return _unit(self.weight @ self.normal)


def _below(cloth: Cloth, level: int, place: tuple[int, int]) -> Below:
    full = cloth.texels["opacity"].shape[:2]
    size = cloth.levels["roughness"][level].shape[:2]
    spans = [
        np.arange(p * f // s, -(-(p + 1) * f // s))
        for p, f, s in zip(place, full, size, strict=True)
    ]
    rows, columns = (axis.ravel() for axis in np.meshgrid(*spans, indexing="ij"))
    some = np.random.default_rng(0).permutation(len(rows))[:MOST_TEXELS]
    rows, columns = rows[some], columns[some]
    at = {name: texels[rows, columns] for name, texels in cloth.texels.items()}
    opacity = at["opacity"][:, 0]
    normal = _unit(at["normal"])
    fibre = _unit(at["tangent"] - normal * dot(normal, at["tangent"])[:, None])
    weight = opacity / max(opacity.sum(), 1e-9)
    return Below(at["yarn_id"][:, 0], opacity, weight, normal, fibre, at["base_color"])


def _truth(cloth: Cloth, below: Below, wi: Values, wo: Values) -> Values:
    """Return the mean of the exact BSDF over all texels, (P, 3), gaps adding nothing."""
    total = np.zeros((len(wi), 3))
    for index in np.unique(below.yarn[below.yarn >= 0]).astype(int):
        own = below.yarn == index
        n, t = below.normal[own][:, None], below.fibre[own][:, None]
        albedo = below.color[own][:, None] * cloth.gains[index]
        optics = parameters(cloth.made.yarns[index].optics)
        value = exact(wi, wo, n, t, optics._replace(A=albedo))
        front = dot(facing(np.broadcast_to(n, value.shape), wi), wo) > 0
        total += np.einsum("n,npc->pc", below.opacity[own], value * front[..., None])
    return np.asarray(total / len(below.yarn))


def _averaged(cloth: Cloth, network: str, below: Below) -> Lobe:
    """Return the lobe of averaged roughness, anisotropy and fibres."""
    lobes = yarn_lobes(cloth.fits)
    loose = below.opacity < 1
    yarn = below.yarn.astype(int)
    if network == "UsdPreviewSurface":
        rough = np.where(loose, 1.0, lobes.preview_roughness[yarn])
        alpha = float(below.weight @ rough) ** 2
        return Lobe(alpha, alpha, _unit(below.weight @ below.fibre))
    rough = np.where(loose, 1.0, lobes.roughness[yarn])
    p = np.where(loose, 0.0, lobes.stretch[yarn])
    anisotropy = below.weight @ (2 * p / (1 + p))
    return _openpbr(below.weight @ rough, anisotropy, _unit(below.weight @ below.fibre))


def _rotated(cloth: Cloth, network: str, below: Below) -> Lobe:
    """Return the lobe of averaged roughness and rotation, as the networks read them."""
    if network == "UsdPreviewSurface":
        return _averaged(cloth, network, below)
    lobes = yarn_lobes(cloth.fits)
    loose, yarn = below.opacity < 1, below.yarn.astype(int)
    rough = np.where(loose, 1.0, lobes.roughness[yarn])
    p = np.where(loose, 0.0, lobes.stretch[yarn])
    x, y = np.cross(below.normal, below.fibre)[:, 0], below.fibre[:, 0]
    square = np.maximum(x * x + y * y, 1e-12)
    turned = np.stack([(x * x - y * y) / square, 2 * x * y / square], -1) * p[:, None]
    return _of_rotation(below.weight @ rough, below.weight @ turned, below.mean_normal)


def _published(
    cloth: Cloth, network: str, below: Below, level: int, place: tuple[int, int]
) -> Lobe:
    """Return the lobe of the level that the files hold."""
    if network == "UsdPreviewSurface":
        alpha = float(cloth.levels["preview_roughness"][level][place][0]) ** 2
        return Lobe(alpha, alpha, _unit(below.weight @ below.fibre))
    rough, rotation = (cloth.levels[name][level][place] for name in ("roughness", "rotation"))
    return _of_rotation(float(rough[0]), rotation[:2], below.mean_normal)


def _of_rotation(rough: float, rotation: Values, normal: Values) -> Lobe:
    """Return the lobe about `normal` that the network makes of a rotation."""
    angle = 0.5 * np.arctan2(rotation[1], rotation[0])
    beside = _unit(np.cross(normal, (1.0, 0.0, 0.0)))
    laid = np.cross(beside, normal)
    fibre = np.cos(angle) * beside - np.sin(angle) * laid
    stretch = float(np.hypot(*rotation))
    return _openpbr(rough, 2 * stretch / (1 + stretch), fibre)


def _openpbr(rough: float, anisotropy: float, fibre: Values) -> Lobe:
    ratio = 1 - float(anisotropy)
    across = float(rough) ** 2 * np.sqrt(2 / (1 + ratio**2))
    return Lobe(ratio * across, min(across, 1.0), fibre)


def _shaded(lobe: Lobe, below: Below, f0: float, base: float, wi: Values, wo: Values) -> Values:
    """Return what a standard shader reflects to the viewer, times the coverage, (P, 3)."""
    normal = below.mean_normal
    fibre = _unit(lobe.fibre - normal * (normal @ lobe.fibre))
    under = lit(normal[None], fibre[None], wi, wo)
    edge = fresnel_edge(dot(wi, halfway(wi, wo)))
    shine = mirror(under, lobe.along, lobe.across)[0] * (f0 + (1 - f0) * edge)
    a, b = albedos(round(float(np.clip(np.sqrt(lobe.along * lobe.across), 0.03, 1)), 4))
    step = np.minimum((under.n_i[0] * len(COSINES)).astype(int), len(COSINES) - 1)
    diffuse = base * (1 - f0 * a - b)[step] * np.maximum(under.n_o[0], 0) / np.pi
    color = below.weight @ below.color
    value = diffuse[:, None] * color + (shine * (under.n_o[0] > 0))[:, None]
    return np.asarray(below.opacity.mean() * value)


def _unit(vectors: Values) -> Values:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.maximum(length, 1e-12))


if __name__ == "__main__":
    main()
