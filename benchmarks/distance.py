"""The cloth from afar: how near each way to filter a footprint comes to the mean of its texels.

    python benchmarks/distance.py [--windows 4] [--pairs 96]

Footprints lie anywhere on the cloth, from a quarter of a crossing to the tile, square and long.
The error is Σ |f̂ − f| / Σ f over pairs of directions, f the mean over the footprint's texels;
radiance is Σ f̂ / Σ f − 1 of all windows of a size.

- naive: one frame, the mean of all normals and tangents, as an ordinary mip map gives;
- vMF: normals spread by a von Mises–Fisher lobe of the mean normal's length around the mesh's
  tangent, warp and weft apart (more than the literature does: it takes them together);
- lean, ours: the moments of `weaveusd.synth.moments`, as `weaveusd.shading.distance` shades them;
- lean taps, taps: both as the mean of the footprint's four quarters.

Frames are the strands of a footprint that a pair of directions sees, which is what shading costs; a
frame of vMF is a normal of a yarn. Afterwards errors for two yarns of unlike optics in one system,
and for picks twisted S and Z in turn. The exit status is 1 when a goal is missed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from weaveusd.cloth.model import Weave
from weaveusd.cloth.weave import weave
from weaveusd.draft.make import make_draft
from weaveusd.draft.model import Draft
from weaveusd.draft.resolve import from_drawdown
from weaveusd.draft.weaves import tiled
from weaveusd.shading.directions import pairs
from weaveusd.shading.distance import FULL, LEAN, Nodes, evaluate, parameters
from weaveusd.shading.fibre import dot, facing
from weaveusd.shading.microcylinder import evaluate as exact
from weaveusd.shading.strands import strands
from weaveusd.synth.moments import Footprint, MomentMaps, moment_maps
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.model import Optics
from weaveusd.yarn.recipe import read_preset

Values = np.ndarray[Any, np.dtype[np.float64]]

MATERIALS = ("silk", "shot_silk", "polyester", "linen")
MATTE = "linen"
DRAFTS = ("plain", "twill:2/2", "satin:5:2", "damask 60")
SIZES = {
    "1/4": (0.25, 0.25), "1/2": (0.5, 0.5), "1": (1, 1), "2": (2, 2), "4": (4, 4),
    "4 x 1/4": (4, 0.25), "1/4 x 4": (0.25, 4), "8 x 1": (8, 1), "16": (16, 16), "tile": None,
}  # fmt: skip
"""Width and height of the footprints in threads."""

PER_THREAD = 20
MOST_TEXELS, MOST_OF_TILE = 512, 4096
LEVELS = ("1", "2", "4", "8 x 1", "16")
"""Footprints that a mip map with a texel a crossing has to serve."""

SHADED = {"lean": (LEAN, False), "ours": (FULL, False),
          "lean taps": (LEAN, True), "taps": (FULL, True)}  # fmt: skip
"""Ways to shade moments: nodes, and whether quarters of the footprint are taken."""

WAYS = ("naive", "vMF", *SHADED)
SPREAD = 64
"""Normals of each yarn that stand for a von Mises–Fisher lobe."""

TILE_MEAN, TILE_MOST, LEVEL_MOST, OF_NAIVE, RADIANCE = 0.06, 0.08, 0.13, 0.1, 0.03


@dataclass(frozen=True)
class Cloth:
    """A woven cloth with all its texels, and their moments."""

    made: Weave
    texels: dict[str, Values]
    maps: tuple[MomentMaps, MomentMaps]


@dataclass(frozen=True)
class Seen:
    """A footprint as its texels are (P, 3), what each way makes of them, and of how many frames."""

    truth: Values
    found: dict[str, Values]
    frames: dict[str, float]

    def error(self, way: str) -> float:
        """Return Σ |f̂ − f| / Σ f."""
        return float(np.abs(self.found[way] - self.truth).sum() / self.truth.sum())


def main() -> None:
    """Measure and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--windows", type=int, default=4)
    parser.add_argument("--pairs", type=int, default=96)
    given = parser.parse_args()
    wi, wo = pairs(given.pairs)
    seen = {
        (draft, material): _measured(_cloth(_draft(draft), material), wi, wo, given.windows)
        for draft, material in product(DRAFTS, MATERIALS)
    }
    header = "".join(f"{size:>14}" for size in SIZES)
    print(f"{'ours (naive), error in %':<24}{header}")
    for (draft, material), by_size in seen.items():
        errors = ((_mean(found, "ours"), _mean(found, "naive")) for found in by_size.values())
        cells = "".join(f"{100 * ours:>8.1f} ({100 * naive:>3.0f})" for ours, naive in errors)
        print(f"{draft + ', ' + material:<24}{cells}")
    tables = (
        ("mean error (largest), %", _mean, 1),
        ("radiance (most off), %", _radiance, 1),
        ("frames (most)", _frames, 0),
    )
    for title, number, digits in tables:
        print(f"\n{title:<24}{header}")
        for way in WAYS:
            cells = (
                _cell([number(by_size[size], way) for by_size in seen.values()], digits)
                for size in SIZES
            )
            print(f"{way:<24}{''.join(cells)}")
    faults = list(_faults(seen))
    _left_out(wi, wo)
    print("\n".join(faults) if faults else "every goal is met")
    sys.exit(1 if faults else 0)


def _cell(numbers: list[float], digits: int) -> str:
    """Return the mean of the cases, and the one farthest from 0; a share is in %."""
    scale = 100 if digits else 1
    far = max(numbers, key=abs)
    return f"{scale * np.mean(numbers):>7.{digits}f} ({scale * far:>4.{digits}f})"


def _faults(seen: dict[tuple[str, str], dict[str, list[Seen]]]) -> list[str]:
    """Return the goals that are missed, and print how far each way of `SHADED` is."""
    tiles = {way: {case: _mean(s["tile"], way) for case, s in seen.items()} for way in WAYS}
    faults = []
    print(f"\n{'goals':<46}{'goal':>7}" + "".join(f"{way:>16}" for way in SHADED))
    for name, goal, number in (
        ("tile, mean error of the cases", TILE_MEAN,
         lambda way: float(np.mean(list(tiles[way].values())))),
        ("tile, largest error", TILE_MOST, lambda way: max(tiles[way].values())),
        ("tile, largest share of naive, glossy", OF_NAIVE,
         lambda way: max(tiles[way][c] / tiles["naive"][c] for c in seen if c[1] != MATTE)),
        ("tile, mean radiance, most off", RADIANCE,
         lambda way: max(abs(_radiance(s["tile"], way)) for s in seen.values())),
        *(
            (f"{size} threads, largest error", LEVEL_MOST,
             lambda way, size=size: max(_mean(s[size], way) for s in seen.values()))
            for size in LEVELS
        ),
    ):  # fmt: skip
        found = {way: number(way) for way in SHADED}
        print(f"{name:<46}{goal:>7.2f}" + "".join(_judged(x, goal) for x in found.values()))
        faults += [f"missed by {way}: {name}" for way, x in found.items() if x > goal]
    return faults


def _judged(value: float, goal: float) -> str:
    return f"{value:>9.3f} {'met' if value <= goal else 'missed':>6}"


def _left_out(wi: Values, wo: Values) -> None:
    """Print what the mixing of unlike yarns costs."""
    flat, textured = (yarn.optics for yarn in read_preset("satin_lining").yarns)
    mixed = _cloth(_draft("twill:2/2", stripes=True), "polyester", optics=(flat, textured))
    opposed = _cloth(_draft("plain", stripes=True), "crepe_de_chine", twist=(1, -1))
    print()
    for name, cloth in (("flat and textured ends", mixed), ("crepe picks S, Z", opposed)):
        texels = np.concatenate(_everything(cloth))
        truth = _truth(cloth, texels, wi, wo)
        each = [_footprint(maps, texels) for maps in cloth.maps]
        one = [_of_mean_optics(footprint) for footprint in each]
        still = [_untwisted(footprint) for footprint in each]
        ways = {"naive": _naive(cloth, texels, wi, wo), "ours": evaluate(wi, wo, each, FULL)}
        ways["with the mean of the optics"] = evaluate(wi, wo, one, FULL)
        ways["with the mean of the twist"] = evaluate(wi, wo, still, FULL)
        found = Seen(truth, ways, {})
        errors = ", ".join(f"{way} {100 * found.error(way):.1f}" for way in ways)
        print(f"{name}, tile, error in %: {errors}")


def _draft(name: str, *, stripes: bool = False) -> Draft:
    if name == "damask 60":
        return _damask()
    draft = make_draft(name)
    if not stripes:
        return draft
    up = tiled(draft.drawdown(), 4, 4)
    turn = np.arange(4) % 2
    return from_drawdown(up, turn, 2 + turn, np.repeat(draft.palette, 2, 0))


def _damask() -> Draft:
    """60 threads both ways: quarters of 5-end satin and sateen, and stripes of two colors."""
    satin = make_draft("satin:5:2").drawdown()
    face, back = tiled(satin, 30, 30), tiled(~satin, 30, 30)
    up = np.block([[face, back], [back, face]])
    stripe = (np.arange(60) // 6 % 2).astype(np.int32)
    palette = np.array([[0.75, 0.6, 0.3], [0.2, 0.3, 0.6], [0.7, 0.7, 0.65]])
    return from_drawdown(up, stripe, np.full(60, 2, np.int32), palette)


def _cloth(
    draft: Draft,
    preset: str,
    *,
    optics: Sequence[Optics] = (),
    twist: Sequence[float] = (),
) -> Cloth:
    """Weave and synthesize; `optics` and `twist` are of the ends' and picks' yarns in turn."""
    made = weave(draft, read_preset(preset))
    yarns = list(made.yarns)
    if optics:
        yarns[:2] = (replace(y, optics=o) for y, o in zip(yarns[:2], optics, strict=True))
    if twist:
        yarns[2:] = (
            replace(y, twist_angle=sign * abs(y.twist_angle))
            for y, sign in zip(yarns[2:], twist, strict=True)
        )
    made = replace(made, yarns=tuple(yarns))
    width, height = made.repeat_mm
    pitch = min(width / made.ends, height / made.picks)
    textures = synthesize(made, resolution=round(PER_THREAD * max(width, height) / pitch))
    maps = moment_maps(made, textures, width=textures.width, height=textures.height)
    texels = {name: np.asarray(array, float) for name, array in textures.whole().items()}
    return Cloth(made, texels, maps)


def _measured(cloth: Cloth, wi: Values, wo: Values, windows: int) -> dict[str, list[Seen]]:
    rng = np.random.default_rng(0)
    found: dict[str, list[Seen]] = {}
    for name, size in SIZES.items():
        places = (
            [_everything(cloth)]
            if size is None
            else [_window(cloth, size, rng) for _ in range(windows)]
        )
        found[name] = [_seen(cloth, place, wi, wo) for place in places]
    return found


def _window(cloth: Cloth, size: tuple[float, float], rng: np.random.Generator) -> list[Values]:
    """Return texels (N, 2), rows and columns, of the quarters of a window on the cloth."""
    high, wide = cloth.texels["opacity"].shape[:2]
    rows = max(2, round(size[1] * high / cloth.made.picks))
    columns = max(2, round(size[0] * wide / cloth.made.ends))
    most = MOST_TEXELS if max(size) < 16 else MOST_OF_TILE
    return _quarters(rng.integers((high, wide)), (rows, columns), (high, wide), most)


def _everything(cloth: Cloth) -> list[Values]:
    size = cloth.texels["opacity"].shape[:2]
    return _quarters(np.zeros(2, int), size, size, MOST_OF_TILE)


def _quarters(
    place: Values, size: tuple[int, ...], tile: tuple[int, ...], most: int
) -> list[Values]:
    """Return texels of a window's quarters: all, or an even choice (Roberts' R2 sequence)."""
    if size[0] * size[1] <= most:
        inside = np.stack(np.divmod(np.arange(size[0] * size[1]), size[1]), -1)
    else:
        steps = np.array([0.7548776662466927, 0.5698402909980532])
        inside = ((0.5 + np.arange(most)[:, None] * steps) % 1 * size).astype(int)
    far = inside >= np.asarray(size) / 2
    quarter = 2 * far[:, 0] + far[:, 1]
    return [((inside + place) % tile)[quarter == q] for q in range(4)]


def _seen(cloth: Cloth, quarters: list[Values], wi: Values, wo: Values) -> Seen:
    texels = np.concatenate(quarters)
    yarns = np.unique(_at(cloth, texels, "yarn_id"))
    found = {"naive": _naive(cloth, texels, wi, wo), "vMF": _vmf(cloth, texels, wi, wo)}
    frames = {"naive": 1.0, "vMF": float(SPREAD * np.count_nonzero(yarns >= 0))}
    for name, (nodes, taps) in SHADED.items():
        places = [q for q in quarters if len(q)] if taps else [texels]
        prints = [[_footprint(maps, place) for maps in cloth.maps] for place in places]
        values = [evaluate(wi, wo, systems, nodes) for systems in prints]
        shares = [len(place) / len(texels) for place in places]
        found[name] = np.einsum("q,qpc->pc", shares, values)
        frames[name] = sum(_strands(one, wi, wo, nodes) for systems in prints for one in systems)
    return Seen(_truth(cloth, texels, wi, wo), found, frames)


def _strands(footprint: Footprint, wi: Values, wo: Values, nodes: Nodes) -> float:
    """Return how many strands of a footprint a pair of directions sees on average."""
    moments = np.asarray(footprint.moments, float)
    if not moments[:3].any():
        return 0.0
    side = np.where(wi[:, 2] * wo[:, 2] < 0, -1.0, 1.0)
    if footprint.weft:
        wi, wo = (np.stack([-w[:, 1], w[:, 0], w[:, 2]], -1) for w in (wi, wo))
    each = strands(wi, wo, side, moments, footprint.section, nodes)
    return float(sum((strand.weight > 0).mean() for strand in each))


def _at(cloth: Cloth, texels: Values, name: str) -> Values:
    return cloth.texels[name][texels[:, 0], texels[:, 1]]


def _truth(cloth: Cloth, texels: Values, wi: Values, wo: Values) -> Values:
    """Return the mean over the texels, light only where yarn and cloth agree on its side."""
    yarn = _at(cloth, texels, "yarn_id")[:, 0]
    total = np.zeros((len(wi), 3))
    for index in np.unique(yarn[yarn >= 0]).astype(int):
        own = texels[yarn == index]
        optics = cloth.made.yarns[index].optics
        n, t = (_at(cloth, own, name)[:, None] for name in ("normal", "tangent"))
        total += _sum(wi, wo, n, t, optics, _at(cloth, own, "base_color"),
                      _at(cloth, own, "opacity"))  # fmt: skip
    return total / len(texels)


def _sum(
    wi: Values, wo: Values, n: Values, t: Values, optics: Optics, color: Values, weight: Values
) -> Values:
    """Return the sum over frames (N, 1, 3) of weight (N, 1) times value, (P, 3)."""
    n = n / np.linalg.norm(n, axis=-1, keepdims=True)
    t = t - n * dot(n, t)[..., None]
    t = t / np.linalg.norm(t, axis=-1, keepdims=True)
    value = exact(wi, wo, n, t, parameters(optics)._replace(A=color[:, None]))
    front = dot(facing(np.broadcast_to(n, value.shape), wi), wo) > 0
    return np.asarray(np.einsum("n,npc->pc", weight[:, 0], value * front[..., None]))


def _naive(cloth: Cloth, texels: Values, wi: Values, wo: Values) -> Values:
    weight = _at(cloth, texels, "opacity")
    n, t, color = (
        (_at(cloth, texels, name) * weight).sum(0)[None] / max(weight.sum(), 1e-9)
        for name in ("normal", "tangent", "base_color")
    )
    yarn = _at(cloth, texels, "yarn_id")[:, 0].astype(int)
    kinds = [cloth.made.yarns[index].optics for index in yarn[yarn >= 0]]
    if not kinds:
        return np.zeros((len(wi), 3))
    return _sum(wi, wo, n[:, None], t[:, None], _mean_optics(kinds), color, weight.mean(0)[None])


def _vmf(cloth: Cloth, texels: Values, wi: Values, wo: Values) -> Values:
    """Return the value of normals spread around their mean, κ = r (3 − r²) / (1 − r²)."""
    total = np.zeros((len(wi), 3))
    system, yarn = (_at(cloth, texels, name)[:, 0] for name in ("system", "yarn_id"))
    for index in np.unique(yarn[yarn >= 0]).astype(int):
        own = texels[yarn == index]
        weight = _at(cloth, own, "opacity")
        axis = np.array([(0.0, 1.0, 0.0), (1.0, 0.0, 0.0)])[int(system[yarn == index][0])]
        mean = (_at(cloth, own, "normal") * weight).sum(0) / weight.sum()
        color = (_at(cloth, own, "base_color") * weight).sum(0) / weight.sum()
        normals = _spread(mean, SPREAD)[:, None]
        share = np.full((SPREAD, 1), weight.sum() / (SPREAD * len(texels)))
        along = np.broadcast_to(axis, normals.shape)
        total += _sum(wi, wo, normals, along, cloth.made.yarns[index].optics,
                      np.tile(color, (SPREAD, 1)), share)  # fmt: skip
    return total


def _spread(mean: Values, count: int) -> Values:
    """Return `count` vectors that a von Mises–Fisher lobe of that mean spreads."""
    r = min(float(np.linalg.norm(mean)), 1 - 1e-6)
    kappa = r * (3 - r * r) / (1 - r * r)
    u = (np.arange(count) + 0.5) / count
    z = 1 + np.log(u + (1 - u) * np.exp(-2 * kappa)) / kappa
    turn, level = np.pi * (3 - np.sqrt(5)) * np.arange(count), np.sqrt(np.maximum(1 - z * z, 0))
    axis = mean / np.linalg.norm(mean)
    side = np.cross(axis, (0.0, 1.0, 0.0) if abs(axis[1]) < 0.9 else (1.0, 0.0, 0.0))
    side /= np.linalg.norm(side)
    around = np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * np.cross(axis, side)
    return np.asarray(z[:, None] * axis + level[:, None] * around)


def _footprint(maps: MomentMaps, texels: Values) -> Footprint:
    """Return the mean of the moments of the texels: they are linear."""
    row, column = texels.T
    moments, albedo, share = (
        array[row, column].mean(0, dtype=float).astype(np.float32)
        for array in (maps.moments, maps.albedo, maps.share)
    )
    return Footprint(maps.weft, maps.section, moments, albedo, share, maps.kinds)


def _mean(found: list[Seen], way: str) -> float:
    return float(np.mean([one.error(way) for one in found if one.truth.any()]))


def _radiance(found: list[Seen], way: str) -> float:
    total = sum(float(one.truth.sum()) for one in found)
    return sum(float(one.found[way].sum()) for one in found) / total - 1


def _frames(found: list[Seen], way: str) -> float:
    return float(np.mean([one.frames[way] for one in found]))


def _mean_optics(kinds: Sequence[Optics]) -> Optics:
    names = ("eta", "k_d", "k_s", "gamma_s", "gamma_v", "tau")
    return Optics(**{name: float(np.mean([getattr(o, name) for o in kinds])) for name in names})


def _of_mean_optics(footprint: Footprint) -> Footprint:
    weights = np.rint(1000 * footprint.share / footprint.share.sum()).astype(int)
    kinds = [o for o, n in zip(footprint.kinds, weights, strict=True) for _ in range(n)]
    total = footprint.share.sum()[None]
    return replace(footprint, share=total, kinds=(_mean_optics(kinds),))


def _untwisted(footprint: Footprint) -> Footprint:
    moments = footprint.moments.copy()
    moments[11] = moments[10] ** 2 / moments[:3].sum()
    return replace(footprint, moments=moments)


if __name__ == "__main__":
    main()
