"""What an asset says of its yarns, for the levels of its cloth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Usd

from weaveusd.contract import CLOTH_NAMESPACE, YARN_NAMESPACE
from weaveusd.render.distance_levels import Levels, make_levels
from weaveusd.render.distance_moments import Threads

if TYPE_CHECKING:
    from numpy.typing import NDArray

FLATTEST, ROUNDEST = 0.02, 5.0
"""Limits of thickness over width within which a yarn has levels."""

MOST_CROSSINGS = 1 << 20


def distant_levels(
    material: Usd.Prim, arrays: Mapping[str, NDArray[Any]], optics: NDArray[np.float32]
) -> Levels | None:
    """Return the levels of a cloth whose material prim says enough of its yarns, else None.

    A cloth without attributes has none, nor has one with yarns of different optics in one
    system: what is far from another in a cell would be mixed. It is shown by its texels, which
    is right at any distance. `arrays` and `optics` are as in `make_levels`.
    """
    threads = _threads(material, optics.shape[1])
    crossings = [_count(material, name) for name in ("picks", "ends")]
    if threads is None or None in crossings:
        return None
    for system in (False, True):
        own = optics[:, threads.is_weft == system]
        if own.size and np.ptp(own, axis=1).max() > 1e-6:
            return None
    picks, ends = (int(count or 1) for count in crossings)
    return make_levels(arrays, optics, threads, (picks, ends))


def _threads(material: Usd.Prim, yarns: int) -> Threads | None:
    names = _value(material, f"{CLOTH_NAMESPACE}:yarns")
    if names is None or np.ndim(names) != 1 or len(names) != yarns:
        return None
    systems, flatness = [], []
    for name in names:
        stated = [
            _value(material, f"{YARN_NAMESPACE}:{name}:{what}")
            for what in ("system", "width", "height")
        ]
        system, width, height = stated
        numbers = isinstance(width, float) and isinstance(height, float)
        if system not in ("warp", "weft") or not numbers or not width > 0:
            return None
        systems.append(system == "weft")
        flatness.append(height / width)
    if not all(FLATTEST <= ratio <= ROUNDEST for ratio in flatness):
        return None
    return Threads(np.array(systems, bool), np.array(flatness, np.float32))


def _count(material: Usd.Prim, name: str) -> int | None:
    value = _value(material, f"{CLOTH_NAMESPACE}:{name}")
    return value if isinstance(value, int) and 1 <= value <= MOST_CROSSINGS else None


def _value(prim: Usd.Prim, name: str) -> Any:
    attribute = prim.GetAttribute(name) if prim else None
    return attribute.Get() if attribute else None
