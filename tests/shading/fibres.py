"""Fibres for the tests of the reference: the optics of every preset, each way to scatter once."""

from __future__ import annotations

import numpy as np

from weaveusd.shading.microcylinder import Parameters
from weaveusd.yarn.recipe import preset_names, read_preset

UP = np.array([0.0, 0.0, 1.0])
ALONG = np.array([0.0, 1.0, 0.0])

OPTICS = {
    f"{name}/{yarn.name}": yarn.optics
    for name in reversed(preset_names())
    for yarn in read_preset(name).yarns
}
# Yarns that scatter alike are one case.
OPTICS = {key: optics for optics, key in {o: k for k, o in OPTICS.items()}.items()}


def parameters(
    key: str, tau: float | None = None, albedo: float = 1.0, gaussian: bool = False
) -> Parameters:
    o = OPTICS[key]
    tau = o.tau if tau is None else tau
    return Parameters(o.eta, o.k_d, o.k_s, o.gamma_s, o.gamma_v, tau, np.full(3, albedo), gaussian)


def unit(*v: float) -> np.ndarray:
    return np.array(v) / np.linalg.norm(v)
