"""Cloths for the tests of the BSDF: the published optics, and arrays of one texel or more."""

from __future__ import annotations

from typing import Any

import numpy as np

from weaveusd import contract

# eta, k_d, gamma_s and gamma_v in degrees, N_V
PRESETS: dict[str, tuple[float, float, float, float, float]] = {
    "linen": (1.46, 0.3, 12, 24, 1.8608),
    "crepe flat": (1.345, 0.2, 5, 10, 1.1962),
    "crepe twisted": (1.345, 0.3, 18, 32, 2.0650),
    "polyester flat": (1.539, 0.1, 2.5, 5, 0.9109),
    "polyester twisted": (1.539, 0.7, 30, 60, 2.0436),
    "shot warp": (1.345, 0.1, 4, 8, 1.0426),
    "shot weft": (1.345, 0.1, 5, 10, 1.1490),
    "velvet": (1.46, 0.1, 6, 12, 1.2750),
}


def optics(*presets: str, tau: float = 0.0, k_s: float = 1.0) -> dict[str, list[float]]:
    """Return the shader's inputs for yarns of the given presets."""
    rows = [PRESETS[name] for name in presets]
    return {
        "eta": [r[0] for r in rows],
        "k_d": [r[1] for r in rows],
        "k_s": [k_s] * len(rows),
        "gamma_s": [float(np.radians(r[2])) for r in rows],
        "gamma_v": [float(np.radians(r[3])) for r in rows],
        "tau": [tau] * len(rows),
        "normalization": [r[4] for r in rows],
    }


def plain_arrays(
    normal: Any = (0, 0, 1), tangent: Any = (0, 1, 0), color: float = 0.5, size: int = 1
) -> dict[str, Any]:
    """Return channels that are the same at every texel, of yarn 0."""
    n = np.asarray(normal, np.float32)
    n = n / np.linalg.norm(n)
    t = np.asarray(tangent, np.float32)
    t = t - n * float(n @ t)
    t = t / np.linalg.norm(t)
    return {
        "normal": np.tile(n, (size, size, 1)),
        "tangent": np.tile(t, (size, size, 1)),
        "base_color": np.full((size, size, 3), color, np.float32),
        "opacity": np.ones((size, size, 1), np.float32),
        "yarn_id": np.zeros((size, size, 1), np.float32),
    }


def with_gaps(arrays: dict[str, Any], gaps: Any) -> dict[str, Any]:
    """Return the channels with gaps where the mask (H, W) is true."""
    opened = {name: value.copy() for name, value in arrays.items()}
    opened["opacity"][gaps] = 0
    opened["yarn_id"][gaps] = contract.GAP
    return opened


def direction(theta: float, phi: float) -> list[float]:
    """Return the unit vector at these angles in degrees, theta from the normal."""
    t, p = np.radians(theta), np.radians(phi)
    return [float(np.sin(t) * np.cos(p)), float(np.sin(t) * np.sin(p)), float(np.cos(t))]
