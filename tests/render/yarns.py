"""Yarns for the tests of the lobes: random frames, directions and optics."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.render.cloths import PRESETS
from weaveusd.render import lobes

KEYS = ("eta", "k_d", "k_s", "gamma_s", "gamma_v", "tau", "N_V")


def unit(vectors: Any) -> Any:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def cases(count: int, seed: int = 7) -> dict[str, Any]:
    """Random frames, directions and optics, in double precision."""
    rng = np.random.default_rng(seed)
    n = unit(rng.normal(size=(count, 3)))
    t = rng.normal(size=(count, 3))
    t = unit(t - n * np.sum(n * t, axis=1, keepdims=True))
    rows = np.array(list(PRESETS.values()))[np.arange(count) % len(PRESETS)]
    return {
        "n": n,
        "t": t,
        "wi": unit(rng.normal(size=(count, 3))),
        "wo": unit(rng.normal(size=(count, 3))),
        "A": rng.uniform(0, 1, (count, 3)),
        "eta": rows[:, 0],
        "k_d": rows[:, 1],
        "k_s": rng.uniform(0, 1, count),
        "gamma_s": np.radians(rows[:, 2]),
        "gamma_v": np.radians(rows[:, 3]),
        "tau": np.where(np.arange(count) % 2, 0.3, 0.0),
        "N_V": rows[:, 4],
    }


def arguments(mi: Any, c: dict[str, Any], *, gaussian: bool = False) -> tuple[Any, ...]:
    """The cases as Dr.Jit arrays: wi, wo, n, t, parameters."""

    def vector(key: str) -> Any:
        return mi.Vector3f(np.asarray(c[key], np.float32).T)

    yarn = lobes.LobeParameters(
        mi.Color3f(np.asarray(c["A"], np.float32).T),
        *(mi.Float(np.asarray(c[key], np.float32)) for key in KEYS),
        gaussian=gaussian,
    )
    return vector("wi"), vector("wo"), vector("n"), vector("t"), yarn


def preset_yarn(
    mi: Any, preset: str, *, tau: float = 0.0, color: Any = 0.5, gaussian: bool = False
) -> lobes.LobeParameters:
    """A yarn of the published optics; the color may be an array."""
    eta, k_d, gamma_s, gamma_v, n_v = PRESETS[preset]
    numbers = (eta, k_d, 1.0, np.radians(gamma_s), np.radians(gamma_v), tau, n_v)
    return lobes.LobeParameters(mi.Color3f(color), *map(mi.Float, numbers), gaussian=gaussian)
