"""Standard shaders fitted to a cloth, and how far from it they stay (physics.md G).

What is fitted is the reflectance of the whole tile: the mean over its texels, each in its own
frame, since the standard networks read the same normals and directions of fibres as the exact
one. A standard shader has a diffuse base in the yarn's color and one mirror-like lobe of GGX.
The lobe's roughnesses are searched on a grid; the weight of the base and the reflectance F0, in
which the tile's reflectance is nearly linear, follow by least squares within their bounds. Half
of the pairs of directions are fitted, the error is that of the other half.

From afar a renderer's maps have one texel for the tile: one lobe about the cloth's own normal has
to stand for all yarns. It is searched on the same grid, its fibres along warp or weft, and none
sharper than the sharpest yarn's; F0 and the base are constants of a network and stay the yarns'.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.shading.directions import pairs
from weaveusd.shading.lobe import albedos
from weaveusd.shading.material import FitErrors, FitsAfar, StandardFit, StandardFits
from weaveusd.shading.tile import Part, flat_part, mean_color, tile_parts

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from weaveusd.cloth.model import Weave
    from weaveusd.shading.fibre import Doubles
    from weaveusd.shading.measured import Measured, Texels
    from weaveusd.yarn.model import System

    Bools = NDArray[np.bool_]

ALONG = tuple(round(0.06 ** (1 - k / 11), 4) for k in range(12))
ACROSS = (0.4, 0.6, 0.8, 1.0)
EVEN = tuple(alpha for alpha in ALONG if alpha > 0.15)
ALPHAS = tuple((b, t) for t in ACROSS for b in ALONG if b < t) + tuple((a, a) for a in EVEN)
"""Roughnesses (along, across) that are tried."""

F0_LIMITS = 0.02, 0.25
"""Those of indices of refraction of 1.33 and 3, between which standard shaders mean the same."""

BLACK = 1e-3
"""Least mean reflectance that errors are relative to, in 1/sr."""

FIBRES: dict[System, tuple[float, float, float]] = {"warp": (0, 1, 0), "weft": (1, 0, 0)}
"""Directions of the fibres of a lobe that stands for the whole tile."""

PAIRS = 768
SWEEPS = 2
DIGITS = 4
"""Digits of what is published, so that a machine's last bit does not reach a file."""


@dataclass(frozen=True, slots=True)
class Solution:
    """What stands in for a tile: F0, weight of the base, and what they reflect, (P, 3) in 1/sr."""

    f0: float
    base: float
    value: Doubles


def fit_standard(
    weave: Weave, texels: Sequence[Texels | None], measured: Sequence[Measured]
) -> StandardFits:
    """Return the standard shaders that come closest to the exact cloth, and their errors.

    `texels` are those of each yarn (see `measured.texels_of`), in the order of `weave.yarns`.
    """
    wi, wo = pairs(PAIRS)
    parts, owner = tile_parts(weave, texels, measured, wi, wo, ALPHAS)
    tile = Tile(parts, np.arange(PAIRS) // 4 % 2 == 0, ALPHAS)
    every = range(len(ALPHAS))
    equal = [index for index, (along, across) in enumerate(ALPHAS) if along == across]

    isotropic, _ = tile.shared(equal)
    even, preview = tile.each(isotropic, equal)
    together, standard = tile.shared(every)
    chosen, openpbr = tile.each(together, every)

    color = mean_color(weave, texels)
    flat = {s: flat_part(color, np.array(f, float), wi, wo, ALPHAS) for s, f in FIBRES.items()}
    wide = {s: tile.standing_in(part, openpbr, _no_sharper(chosen)) for s, part in flat.items()}
    fibres = min(wide, key=lambda system: tile.misfit(wide[system][1].value))
    far, openpbr_afar = wide[fibres]
    rounder = [k for k in _no_sharper(even) if k in equal]
    round_, preview_afar = tile.standing_in(flat[fibres], preview, rounder)
    solutions = openpbr, standard, preview, openpbr_afar, preview_afar
    return StandardFits(
        together=_fit(together, standard),
        yarns=_of_yarns(owner, chosen, together, openpbr),
        isotropic=_fit(isotropic, preview),
        isotropic_yarns=_of_yarns(owner, even, isotropic, preview),
        afar=FitsAfar(_fit(far, openpbr_afar), fibres, _fit(round_, preview_afar)),
        errors=FitErrors(*map(tile.error, solutions)),
    )


def _no_sharper(chosen: Sequence[int]) -> list[int]:
    """Return the candidates that are no sharper than the sharpest of `chosen`: bends widen."""
    least = min(ALPHAS[k][0] for k in chosen)
    return [k for k, (along, _) in enumerate(ALPHAS) if along >= least]


def _of_yarns(
    owner: Sequence[int | None], chosen: Sequence[int], unseen: int, solution: Solution
) -> tuple[StandardFit, ...]:
    """Return the fit of each yarn: that of its part, or `unseen` where no texel shows it."""
    return tuple(_fit(unseen if k is None else chosen[k], solution) for k in owner)


def _fit(choice: int, solution: Solution) -> StandardFit:
    along, across = ALPHAS[choice]
    return StandardFit(along, across, round(solution.f0, DIGITS), round(solution.base, DIGITS))


class Tile:
    """The parts of a tile, which pairs are fitted, and the search for what fits them.

    `fitted` (P,) are the pairs that are fitted; `alphas` the candidates (along, across) that the
    parts were made with.
    """

    def __init__(
        self, parts: Sequence[Part], fitted: Bools, alphas: Sequence[tuple[float, float]]
    ) -> None:
        self.parts, self.fitted = parts, fitted
        self.exact: Doubles = np.sum([part.exact for part in parts], 0)
        # Without weights nothing but the highlight's peak would count.
        mean = max(float(self.exact[fitted].mean()), BLACK)
        self.weight = fitted[:, None] / (self.exact + mean)
        found = [albedos(round((along * across) ** 0.5, DIGITS)) for along, across in alphas]
        self.albedo = np.array(found)  # (A, 2, 16): a and b in E = a F0 + b

    def error(self, solution: Solution) -> float:
        """Return Σ |f̂ − f| / Σ f over the pairs that were not fitted."""
        return round(self._off(solution.value, ~self.fitted), 3)

    def shared(self, candidates: Sequence[int]) -> tuple[int, Solution]:
        """Return the candidate that fits best where all parts have the same lobe."""
        solutions = [(k, self.solve([k] * len(self.parts))) for k in candidates]
        return min(solutions, key=lambda found: self.misfit(found[1].value))

    def each(self, start: int, candidates: Sequence[int]) -> tuple[list[int], Solution]:
        """Return a candidate for each part, found in turns, beginning with `start` for all.

        What follows by least squares after a turn may be a worse fit than before it: the best of
        all counts.
        """
        chosen = [start] * len(self.parts)
        solution = self.solve(chosen)
        best = list(chosen), solution
        for _ in range(SWEEPS):
            for index, part in enumerate(self.parts):
                f0, base = solution.f0, solution.base
                own = self.of_part(part, f0, base)
                others = solution.value - own[chosen[index]]
                misfits = {k: self.misfit(others + own[k]) for k in candidates}
                chosen[index] = min(misfits, key=misfits.__getitem__)
                solution = self.solve(chosen)
                if self.misfit(solution.value) < self.misfit(best[1].value):
                    best = list(chosen), solution
        return best

    def standing_in(
        self, flat: Part, solution: Solution, candidates: Sequence[int]
    ) -> tuple[int, Solution]:
        """Return the candidate with which `flat` comes closest to the tile; `solution` has F0."""
        values = self.of_part(flat, solution.f0, solution.base)
        best = min(candidates, key=lambda k: self.misfit(values[k]))
        return best, Solution(solution.f0, solution.base, values[best])

    def solve(self, chosen: Sequence[int]) -> Solution:
        """Return the weight of the base and F0 that fit best with these lobes.

        The base receives what the lobe leaves of the light, which takes a few rounds.
        """
        lobe = sum(part.lobe[k] for part, k in zip(self.parts, chosen, strict=True))
        edge = sum(part.edge[k] for part, k in zip(self.parts, chosen, strict=True))
        direct, rim = np.asarray(lobe)[:, None], np.asarray(edge)[:, None]
        f0, base = F0_LIMITS[0], 1.0
        for _ in range(3):
            diffuse = np.sum(
                [
                    np.einsum("s,spc->pc", self._left(f0)[k], part.diffuse)
                    for part, k in zip(self.parts, chosen, strict=True)
                ],
                0,
            )
            base, f0 = _bounded(diffuse, direct - rim, self.exact - rim, self.weight)
        return Solution(f0, base, base * diffuse + f0 * (direct - rim) + rim)

    def of_part(self, part: Part, f0: float, base: float) -> Doubles:
        """Return what `part` reflects with every candidate, (A, P, 3)."""
        diffuse = np.einsum("as,spc->apc", self._left(f0), part.diffuse)
        shine = f0 * part.lobe + (1 - f0) * part.edge
        return np.asarray(base * diffuse + shine[..., None])

    def _left(self, f0: float) -> Doubles:
        """Return what each candidate leaves to the base, by the viewer's cosine, (A, 16)."""
        return np.asarray(1 - f0 * self.albedo[:, 0] - self.albedo[:, 1])

    def misfit(self, value: Doubles) -> float:
        """Return the error of the fitted pairs, to so many digits that machines agree on it."""
        return round(self._off(value, self.fitted), 9)

    def _off(self, value: Doubles, where: Bools) -> float:
        off = np.abs(value - self.exact)[where].mean()
        return float(off / max(float(self.exact[where].mean()), BLACK))


def _bounded(a: Doubles, b: Doubles, y: Doubles, weight: Doubles) -> tuple[float, float]:
    """Return x and z for which x a + z b comes closest to y, within 0…1 and `F0_LIMITS`.

    Of a convex problem in a box the best point is the free one, or on the border of one bound
    that it breaks with the other number free within its own.
    """
    least, most = F0_LIMITS
    aa, ab, bb = (float(np.sum(weight * p * q)) for p, q in ((a, a), (a, b), (b, b)))
    ay, by = float(np.sum(weight * a * y)), float(np.sum(weight * b * y))

    def of_x(x: float) -> float:
        return float(np.clip((by - ab * x) / max(bb, 1e-30), least, most))

    def of_z(z: float) -> float:
        return float(np.clip((ay - ab * z) / max(aa, 1e-30), 0, 1))

    det = aa * bb - ab * ab
    if det > 1e-12 * aa * bb:
        x, z = (ay * bb - by * ab) / det, (by * aa - ay * ab) / det
        if 0 <= x <= 1 and least <= z <= most:
            return x, z
    corners = [(0.0, of_x(0)), (1.0, of_x(1)), (of_z(least), least), (of_z(most), most)]
    return min(
        corners,
        key=lambda p: aa * p[0] ** 2 + 2 * ab * p[0] * p[1] + bb * p[1] ** 2
        - 2 * ay * p[0] - 2 * by * p[1],
    )  # fmt: skip
