"""What a U3M says about a cloth that is no picture: thickness, weight, fibres, construction."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.cloth import measures
from weaveusd.cloth.floats import longest_float
from weaveusd.export.attributes import tidy

if TYPE_CHECKING:
    from weaveusd.cloth.model import Bools, Weave

FIBRES = {
    "abaca": "Abaca", "acetate": "Acetate", "acrylic": "Acrylic", "alpaca": "Alpaca",
    "angora": "Angora", "aramid": "Aramid", "camel": "Camelhair", "cashmere": "Cashmere",
    "cotton": "Cotton", "cupro": "Cupro", "elastane": "Elastane", "flax": "Linen",
    "hemp": "Hemp", "jute": "Jute", "linen": "Linen", "lyocell": "Lyocell",
    "modacrylic": "Modacrylic", "modal": "Modal", "mohair": "Mohair", "nylon": "Nylon",
    "polyamide": "Polyamid", "polyester": "Polyester", "polyethylene": "Polyethylene",
    "polypropylene": "Polypropylen", "ramie": "Ramie", "rayon": "Rayon", "silk": "Silk",
    "spandex": "Spandex", "triacetate": "Triacetate", "viscose": "Rayon", "wool": "Wool",
}  # fmt: skip
"""U3M's names of fibres, with its spelling, by ours."""

MOST_DOBBY_SHAFTS = 32
"""Shafts of a loom with a dobby; what needs more is woven on a jacquard."""


def physics(weave: Weave, shafts: int) -> dict[str, Any]:
    """Return the object `physics` of a U3M 1.1: mm, g/m², shares of the weight, construction."""
    return {
        "thickness": tidy(measures.thickness_mm(weave)),
        "weight": tidy(measures.areal_density_g_m2(weave)),
        "devices": {"fab": "null"},
        "composition": {"parts": composition(weave)},
        "material_type": {"type": "Woven", "name": None},
        "construction": construction(weave.warp_up, shafts),
    }


def composition(weave: Weave) -> list[dict[str, Any]]:
    """Return the fibres with their shares of the weight, the heaviest first; they add up to 1.

    Shares have four digits; what rounding leaves goes to the heaviest.
    """
    width, height = weave.repeat_mm
    crimp = measures.crimps(weave)
    grams: dict[str, float] = {}
    for threads, length in ((weave.warp_yarn, height), (weave.weft_yarn, width)):
        for index, count in enumerate(np.bincount(threads, minlength=len(weave.yarns))):
            yarn = weave.yarns[index]
            mass = yarn.tex * (1 + crimp[index]) * length * int(count)
            grams[yarn.fibre] = grams.get(yarn.fibre, 0.0) + mass
    whole = sum(grams.values())
    # In ten thousandths, so that they add up exactly.
    shares = {fibre: round(1e4 * mass / whole) for fibre, mass in grams.items() if mass > 0}
    heaviest = max(shares, key=lambda fibre: (shares[fibre], fibre))
    shares[heaviest] += 10_000 - sum(shares.values())
    ordered = sorted(shares.items(), key=lambda item: (-item[1], item[0]))
    return [_part(fibre, share / 1e4) for fibre, share in ordered if share]


def construction(warp_up: Bools, shafts: int) -> dict[str, Any]:
    """Return the construction of a drawdown (picks, ends) in the words of U3M 1.1.

    Twills and satins are told from how the ties move from thread to thread; `Twill` alone is one
    that turns, as in herringbone. What is neither plain, twill nor satin is `Dobby`, or `Jacquard`
    where it needs more than `MOST_DOBBY_SHAFTS`.
    """
    kind = _regular(warp_up) or ("Dobby" if shafts <= MOST_DOBBY_SHAFTS else "Jacquard")
    return {"type": kind, "name": None}


def _regular(warp_up: Bools) -> str | None:
    if longest_float(warp_up) == 1:
        return "Plain weave"
    steps = [_steps(warp_up[row - 1], warp_up[row]) for row in range(len(warp_up))]
    one = set.intersection(*steps)
    if 1 in one:
        return "Twill - right hand (Z)"
    if -1 in one:
        return "Twill - left hand (S)"
    if any(abs(step) >= 2 for step in one) and _ties(warp_up) == 1:
        return "Satin"
    columns = [_steps(warp_up[:, end - 1], warp_up[:, end]) for end in range(warp_up.shape[1])]
    if _is_reversed_twill(steps) or _is_reversed_twill(columns):
        return "Twill"
    return None


def _is_reversed_twill(steps: list[set[int]]) -> bool:
    """Whether the diagonal goes on over half of the threads and turns or breaks at the others."""
    return all(steps) and 2 * sum(bool(step & {1, -1}) for step in steps) >= len(steps)


def _steps(before: Bools, after: Bools) -> set[int]:
    """Return every cyclic shift, -n/2 to n/2, that turns `before` into `after`."""
    count = len(before)
    shifts = range(-(count // 2), count // 2 + 1)
    return {step for step in shifts if np.array_equal(np.roll(before, step), after)}


def _ties(warp_up: Bools) -> int:
    """Return how often a pick binds in its shortest period: the fewer of ups and downs."""
    row = warp_up[0]
    count = len(row)
    period = next(n for n in range(1, count + 1) if np.array_equal(np.roll(row, n), row))
    up = int(row[:period].sum())
    return min(up, period - up)


def _part(fibre: str, ratio: float) -> dict[str, Any]:
    known = FIBRES.get(fibre.lower())
    return {"ratio": ratio, "type": known or "other", "name": None if known else fibre}
