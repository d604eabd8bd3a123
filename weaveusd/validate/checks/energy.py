"""Whether any yarn sends back more light than it receives."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from weaveusd.contract import SHADER_YARN_INPUTS
from weaveusd.validate.checks.optics import OPEN_LIMITS
from weaveusd.validate.checks.shader import ATTRIBUTES
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.scattering import YarnOptics, scattered

GAINED = Code("energy-gained", Status.FAIL, "A white yarn sends back more light than it receives.")
OTHER = Code(
    "normalization-disagrees",
    Status.FAIL,
    "The stated normalization is not the one that follows from the other numbers.",
)

LIMIT = 1.002
"""Shares of light are integrated to a thousandth."""

TOLERANCE = 0.005
"""Largest relative error of N_V; its maxima are looked for at whole degrees."""

INCLINATIONS_DEG = (*range(0, 90, 6), 87, 89)
AZIMUTHS_DEG = (0, 60, 88)
GRAZING_DEG = 89.94


@check(
    id="optics/energy",
    why="A yarn that makes light brightens with every bounce, and no furnace is white.",
    needs=("material",),
    codes=(GAINED, OTHER),
)
def energy(asset: OpenAsset) -> Iterator[Finding]:
    """No yarn, were it white, sends back more light than it receives, from any angle."""
    where = str(asset.material.GetPath())
    for optics, yarns in yarns_by_optics(asset).items():
        who = ", ".join(yarns[:8])
        shares = {
            (theta, phi): sum(scattered(optics, math.radians(theta), math.radians(phi)))
            for theta in INCLINATIONS_DEG
            for phi in AZIMUTHS_DEG
        }
        worst = max(shares, key=lambda angle: shares[angle])
        if shares[worst] > LIMIT:
            yield GAINED(
                f"{who}, were it white, sends back {shares[worst]:.1%} of the light at "
                f"{worst[0]}° along and {worst[1]}° around the fibre",
                where,
            )
        expected = _normalization(optics)
        if not math.isclose(optics.normalization, expected, rel_tol=TOLERANCE):
            yield OTHER(f"of {who} is {optics.normalization:g}, expected {expected:.5g}", where)


def _normalization(optics: YarnOptics) -> float:
    """Return N_V = (1 − max E_R) / max E_V, the maxima over the inclination (docs/bsdf.md)."""
    angles = np.radians([*range(0, 89, 2), 89, 89.5, 89.8, GRAZING_DEG])
    shares = [scattered(replace(optics, normalization=1.0), float(angle)) for angle in angles]
    surface, volume = (max(lobe) for lobe in zip(*shares, strict=True))
    return float((1 - surface) / max(volume, 1e-9))


def yarns_by_optics(asset: OpenAsset) -> dict[YarnOptics, list[str]]:
    """Return the yarns of each kind of optics, those left out whose numbers are undefined."""
    names: dict[YarnOptics, list[str]] = {}
    for yarn in asset.yarns:
        if (optics := yarn_optics_of(asset, yarn)) is not None:
            names.setdefault(optics, []).append(yarn)
    return names


def yarn_optics_of(asset: OpenAsset, yarn: str) -> YarnOptics | None:
    """Return the optics that the attributes of `yarn` state; None where they are undefined."""
    stated = {name: asset.yarn(yarn, ATTRIBUTES[name]) for name in SHADER_YARN_INPUTS}
    for name, value in stated.items():
        low, high = OPEN_LIMITS.get(ATTRIBUTES[name], (-math.inf, math.inf))
        if not (isinstance(value, float) and np.isfinite(value) and low < value < high):
            return None  # attribute/optics or attribute/yarns reports it
    return YarnOptics(**stated)
