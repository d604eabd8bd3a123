"""The checks behind `weaveusd lobes --check`: every law, for every yarn and angle, in numbers.

The yarn lies flat, white (A = 1) for energy and gray for what is sampled. The viewer stands in
the plane of the fibre and the normal, inclined by the angle: on the inclination all lobes depend.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.proof.golden import golden_error
from weaveusd.proof.subjects import Subject, inclinations, shader_inputs
from weaveusd.shading import laws
from weaveusd.shading.microcylinder import evaluate

if TYPE_CHECKING:
    from numpy.typing import NDArray

ANGLES = (0.0, 30.0, 60.0, 80.0, 88.0)
"""Inclinations to the plane across the fibre at which everything is checked, in degrees."""

QUICK_ANGLES = (30.0, 80.0)

SAMPLES, QUICK_SAMPLES = 200_000, 50_000
"""Samples of each chi² test."""

GRAY = 0.5
"""Albedo while sampling is tested: both lobes take part."""

DENSITY_LIMIT = 1e-5
"""How far ∫ pdf may be from 1: the quadrature's own error."""

SINGLE_DENSITY_LIMIT = 1e-4
"""The same for Dr.Jit: single precision."""

ALBEDO_LIMIT = 1 + 1e-6
RECIPROCITY_LIMIT = 1e-9
GOLDEN_LIMIT = 1e-7

SINGLE_LIMIT = 2e-4, 1e-3
"""Relative error of single precision, up to `STEEP` and beyond."""

STEEP = math.radians(80)

_PAIRS = 2048


@dataclass(frozen=True, slots=True)
class Row:
    """What one yarn does at one angle; see docs/bsdf.md for each number's meaning."""

    yarns: tuple[str, ...]
    angle_deg: float
    density_front: float
    density_back: float
    p_value: float
    reflected: float
    transmitted: float
    reciprocity: float
    single: float  # Dr.Jit against NumPy, relative
    golden: float | None  # NumPy against golden values, relative; None where there are none
    faults: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return the row as JSON types."""
        return {
            "yarns": list(self.yarns),
            "angle_deg": self.angle_deg,
            "pdf_front": self.density_front,
            "pdf_back": self.density_back,
            "chi2_p": self.p_value,
            "reflected": self.reflected,
            "transmitted": self.transmitted,
            "reciprocity": self.reciprocity,
            "drjit": self.single,
            "golden": self.golden,
            "faults": list(self.faults),
        }


def check(
    subjects: Sequence[Subject],
    angles_deg: Sequence[float] = ANGLES,
    *,
    gaussian: bool = False,
    samples: int = SAMPLES,
) -> tuple[Row, ...]:
    """Return a row for every subject and angle; a row without faults keeps every law.

    Raises
    ------
    InputError
        An angle is beyond ±89.9°.
    RendererUnavailableError
        Mitsuba or its LLVM is missing.
    """
    from weaveusd.render import variant

    variant.prepare()
    angles = inclinations(angles_deg)
    trials = len(subjects) * len(angles)
    return tuple(
        row
        for subject in subjects
        for row in _rows(subject, angles, gaussian=gaussian, samples=samples, trials=trials)
    )


def _rows(
    subject: Subject, angles: Sequence[float], *, gaussian: bool, samples: int, trials: int
) -> Iterator[Row]:
    from weaveusd.render import probe

    white, gray = (subject.parameters(albedo, gaussian=gaussian) for albedo in (1.0, GRAY))
    bsdf = probe.one_texel(shader_inputs(gray), color=GRAY, gaussian=gaussian)
    least = probe.least_p_value(trials)
    against_golden = golden_error(subject.optics, gaussian=gaussian)
    reciprocity = laws.reciprocity_error(gray)
    for theta in angles:
        wi = laws.direction(theta, 0.0)
        density = laws.density_integral(gray, theta)
        nodes, weights = laws.sphere(theta, gray)
        in_single = float(np.sum(probe.densities(bsdf, wi, nodes) * weights))
        sampled = probe.chi_square(bsdf, wi.tolist(), samples=samples)
        albedo = laws.directional_albedo(white, theta)
        wo = _directions()
        single = _relative(
            probe.values(bsdf, wi, wo)[:, :1], evaluate(wi, wo, laws.NORMAL, laws.ALONG, gray)
        )
        wrong = {
            "∫pdf is not 1": not abs(density.whole - 1) <= DENSITY_LIMIT,
            "∫pdf of Dr.Jit is not 1": not abs(in_single - 1) <= SINGLE_DENSITY_LIMIT,
            f"chi² p below {least:.2g}": not sampled.p_value >= least,
            sampled.fault: bool(sampled.fault),
            "more light than comes in": not albedo.whole <= ALBEDO_LIMIT,
            "not reciprocal": not reciprocity <= RECIPROCITY_LIMIT,
            "Dr.Jit differs": not single <= SINGLE_LIMIT[abs(theta) > STEEP],
            "golden values differ": not (against_golden or 0.0) <= GOLDEN_LIMIT,
        }
        yield Row(
            yarns=subject.yarns,
            angle_deg=round(math.degrees(theta), 6),
            density_front=density.front,
            density_back=density.back,
            p_value=sampled.p_value,
            reflected=albedo.front,
            transmitted=albedo.back,
            reciprocity=reciprocity,
            single=single,
            golden=against_golden,
            faults=tuple(fault for fault, found in wrong.items() if found),
        )


def _directions() -> NDArray[np.float64]:
    """Return directions on both sides, even in φ and θ, the latter up to `STEEP`."""
    rng = np.random.default_rng(1)
    theta, phi = rng.uniform(-STEEP, STEEP, _PAIRS), rng.uniform(-np.pi, np.pi, _PAIRS)
    return laws.direction(theta, phi)


def _relative(found: NDArray[np.float64], expected: NDArray[np.float64]) -> float:
    """Return the largest relative error; where both are 0 there is none."""
    error = np.abs(found - expected)
    return float(np.max(error / np.maximum(np.abs(expected), 1e-9)))
