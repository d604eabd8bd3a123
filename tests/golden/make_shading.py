"""Write `shading.json`: values of the cloth BSDF, found without any code of weaveusd.

    python tests/golden/make_shading.py

Formulas are evaluated one case at a time from their angles, in plain Python; N_V and the
directional albedos come from SciPy's adaptive quadrature and its bounded search. A test holds
`weaveusd.shading` to the file, a slow one holds the file to this script.
"""

from __future__ import annotations

import json
import math
from functools import cache
from itertools import pairwise
from pathlib import Path
from random import Random
from typing import Any

from scipy.integrate import quad
from scipy.optimize import minimize_scalar

FILE = Path(__file__).with_name("shading.json")
GRAZING = math.pi / 2 - 1e-3
QUARTER = math.pi / 2

# eta, k_d, k_s, gamma_s and gamma_v in degrees: the published optics, then those of the presets.
OPTICS = {
    "linen": (1.46, 0.3, 1.0, 12, 24),
    "crepe flat": (1.345, 0.2, 1.0, 5, 10),
    "crepe twisted": (1.345, 0.3, 1.0, 18, 32),
    "polyester flat": (1.539, 0.1, 1.0, 2.5, 5),
    "polyester twisted": (1.539, 0.7, 1.0, 30, 60),
    "shot warp": (1.345, 0.1, 1.0, 4, 8),
    "shot weft": (1.345, 0.1, 1.0, 5, 10),
    "velvet": (1.46, 0.1, 1.0, 6, 12),
    "a dull surface": (1.46, 0.1, 0.5, 6, 12),
    "canvas": (1.55, 0.4, 1.0, 16, 32),
    "cotton": (1.55, 0.4, 1.0, 15, 30),
    "oxford": (1.55, 0.4, 1.0, 14, 28),
    "poplin": (1.55, 0.4, 1.0, 13, 26),
    "gabardine": (1.56, 0.4, 1.0, 13, 26),
    "wool": (1.56, 0.4, 1.0, 14, 28),
}


def fresnel(cosine: float, eta: float) -> float:
    c = min(abs(cosine), 1.0)
    inside = math.sqrt(1 - (1 - c * c) / eta**2)
    s = (c - eta * inside) / (c + eta * inside)
    p = (eta * c - inside) / (eta * c + inside)
    return (s * s + p * p) / 2


def density(gamma: float, x: float, gaussian: bool) -> float:
    if gaussian:
        return math.exp(-((x / gamma) ** 2) / 2) / (gamma * math.sqrt(2 * math.pi))
    return 1 / (math.pi * gamma * (1 + (x / gamma) ** 2))


def lobe(ti: float, to: float, gamma: float, gaussian: bool) -> float:
    flattest = max(math.cos(ti), math.cos(to))
    return density(gamma, (ti + to) / 2, gaussian) / (2 * flattest**2)


def f_r(ti: float, to: float, pd: float, o: tuple[float, ...], gaussian: bool) -> float:
    eta, _, k_s, gamma_s, _ = o
    half = math.cos(pd / 2)
    scale = 3 / (4 * math.sqrt(2))
    reflected = fresnel(math.cos((ti - to) / 2) * half, eta)
    return k_s * scale * reflected * half * lobe(ti, to, gamma_s, gaussian)


def f_v(ti: float, to: float, o: tuple[float, ...], gaussian: bool) -> float:
    """The volume lobe of both sides together."""
    eta, k_d, _, _, gamma_v = o
    through = (1 - fresnel(math.cos(ti), eta)) * (1 - fresnel(math.cos(to), eta))
    even = 0.5 / (math.cos(ti) + math.cos(to))
    return 0.5 * through * ((1 - k_d) * lobe(ti, to, gamma_v, gaussian) + k_d * even)


def over_inclination(integrand: Any, ti: float, gamma: float) -> float:
    """The integral over θo, split at the kinks and around the lobe's peak."""
    spread = [-ti + sign * k * gamma for sign in (-1, 1) for k in (0.5, 2, 8)]
    borders = sorted({min(max(b, -QUARTER), QUARTER) for b in (*spread, -ti, ti, -9, 9)})
    return sum(quad(integrand, a, b, epsabs=1e-12, epsrel=1e-11, limit=400)[0]
               for a, b in pairwise(borders))  # fmt: skip


def surface_albedo(ti: float, o: tuple[float, ...], gaussian: bool) -> float:
    def ring(to: float) -> float:
        def spoke(phi: float) -> float:
            return f_r(ti, to, phi, o, gaussian) * math.cos(phi)

        across = 2 * quad(spoke, 0, QUARTER, epsabs=1e-13, epsrel=1e-11)[0]
        return across * math.cos(to) ** 2

    return over_inclination(ring, ti, o[3])


def volume_albedo(ti: float, o: tuple[float, ...], gaussian: bool) -> float:
    def ring(to: float) -> float:
        return f_v(ti, to, o, gaussian) * 2 * math.cos(to) ** 2

    return over_inclination(ring, ti, o[4])


def largest(albedo: Any) -> float:
    grid = [GRAZING * k / 24 for k in range(25)]
    best = max(grid, key=albedo)
    around = (max(best - GRAZING / 24, 0), min(best + GRAZING / 24, GRAZING))
    found = minimize_scalar(lambda t: -albedo(t), bounds=around, method="bounded",
                            options={"xatol": 1e-7})  # fmt: skip
    return max(-found.fun, albedo(best))


@cache
def normalization(o: tuple[float, ...], gaussian: bool) -> float:
    surface = largest(lambda ti: surface_albedo(ti, o, gaussian))
    return (1 - surface) / largest(lambda ti: volume_albedo(ti, o, gaussian))


def angles(w: list[float], n: list[float], t: list[float]) -> tuple[float, float]:
    b = [n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2], n[0] * t[1] - n[1] * t[0]]
    return math.asin(max(-1, min(1, along(w, t)))), math.atan2(along(w, b), along(w, n))


def along(a: list[float], b: list[float]) -> float:
    return math.fsum(x * y for x, y in zip(a, b, strict=True))


def published(ti: float, to: float, pi: float, po: float, pd: float,
              o: tuple[float, ...], kind: str) -> dict[str, float]:  # fmt: skip
    eta, k_d, k_s, gamma_s, gamma_v = o
    ci, co = math.cos(ti), math.cos(to)

    def g(gamma: float) -> float:
        tails = math.pi / (2 * math.atan(math.pi / (4 * gamma))) if kind == "cauchy_cut" else 1
        return tails * density(gamma, (ti + to) / 2, kind == "gaussian")

    steep = math.cos((ti - to) / 2) ** 2
    half = math.cos(pd / 2)
    through = (1 - fresnel(ci, eta)) * (1 - fresnel(co, eta))
    lit, seen = max(0.0, math.cos(pi)), max(0.0, math.cos(po))
    u = math.exp(-(pd**2) / (2 * math.radians(20) ** 2))
    return {
        "f_s": k_s * fresnel(math.sqrt(steep) * half, eta) * half * g(gamma_s) / steep,
        "f_v": through * ((1 - k_d) * g(gamma_v) + k_d) / ((ci + co) * steep),
        "M": (1 - u) * lit * seen + u * min(lit, seen),
    }


def case(rng: Random, name: str, gaussian: bool, tau: float, kind: str) -> dict[str, Any]:
    def unit() -> list[float]:
        v = [rng.gauss(0, 1) for _ in range(3)]
        return [x / math.sqrt(along(v, v)) for x in v]

    eta, k_d, k_s, *degrees = OPTICS[name]
    o = (eta, k_d, k_s, *map(math.radians, degrees))
    n, v = unit(), unit()
    v = [x - along(n, v) * y for x, y in zip(v, n, strict=True)]
    t = [x / math.sqrt(along(v, v)) for x in v]
    wi, wo = unit(), unit()
    facing = n if along(n, wi) > 0 else [-x for x in n]
    (ti, pi), (to, po) = angles(wi, facing, t), angles(wo, facing, t)
    pd = math.remainder(pi - po, 2 * math.pi)
    same = along(facing, wo) > 0
    albedo = [rng.random() for _ in range(3)]
    surface = f_r(ti, to, pd, o, gaussian) if same else 0.0
    volume = (1 - tau if same else tau) * f_v(ti, to, o, gaussian)
    n_v = normalization(o, gaussian)
    cosine = abs(along(facing, wo))
    return {
        "optics": name, "gaussian": gaussian, "eta": eta, "k_d": k_d, "k_s": k_s,
        "gamma_s": o[3], "gamma_v": o[4], "tau": tau, "A": albedo,
        "n": n, "t": t, "wi": wi, "wo": wo,
        "f_R": surface, "f_V": volume, "N_V": n_v,
        "eval": [(surface + a * n_v * volume) * cosine for a in albedo],
        "published": {"kind": kind, **published(ti, to, pi, po, pd, o, kind)},
    }  # fmt: skip


def albedos(name: str, gaussian: bool) -> dict[str, Any]:
    eta, k_d, k_s, *degrees = OPTICS[name]
    o = (eta, k_d, k_s, *map(math.radians, degrees))
    inclinations = [0.0, 0.6, 1.2, 1.5]
    return {
        "optics": name, "gaussian": gaussian, "inclination": inclinations,
        "E_R": [surface_albedo(ti, o, gaussian) for ti in inclinations],
        "E_V": [volume_albedo(ti, o, gaussian) for ti in inclinations],
    }  # fmt: skip


def values() -> dict[str, Any]:
    rng = Random(1)
    kinds = ("gaussian", "cauchy", "cauchy_cut")
    pairs = [(name, gaussian) for gaussian in (False, True) for name in OPTICS]
    return {
        "cases": [
            case(rng, name, gaussian, tau, kinds[k % 3])
            for k, (name, gaussian) in enumerate(pairs)
            for tau in (0.0, 0.3)
        ],
        "albedos": [albedos(name, gaussian) for name, gaussian in pairs],
    }


if __name__ == "__main__":
    FILE.write_text(json.dumps(values(), indent=1) + "\n")
