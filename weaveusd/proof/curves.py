"""What a yarn scatters, cut by a plane or seen from above: the numbers behind the figures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from weaveusd.shading import laws, microcylinder, published

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from weaveusd.proof.subjects import Subject

    Doubles = NDArray[np.float64]

Plane = Literal["along", "across"]
"""The plane of the normal and the fibre, or the one of the normal across the fibre."""

ALBEDO = 0.5
"""Gray of every yarn that is drawn, so that their lobes compare."""

STEPS = 1440
"""Directions around a plane, a quarter of a degree apart."""


@dataclass(frozen=True, slots=True)
class Form:
    """Which BSDF is drawn: Cauchy or Gaussian lobes, ours or as published without masking."""

    gaussian: bool = False
    published: bool = False

    @property
    def name(self) -> str:
        """Name for legends and files."""
        return ("Gaussian" if self.gaussian else "Cauchy") + (
            ", as published" if self.published else ""
        )


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """Value times cosine in 1/sr, (…) each: what comes from the surface, and from the volume."""

    surface: Doubles
    volume: Doubles

    @property
    def total(self) -> Doubles:
        """All that comes."""
        return np.asarray(self.surface + self.volume)


def parts(subject: Subject, form: Form, wi: ArrayLike, wo: ArrayLike) -> Parts:
    """Return what a flat yarn of albedo `ALBEDO` sends from `wo` to `wi`, (…, 3) each.

    The frame is that of `weaveusd.shading.laws`.
    """
    params = subject.parameters(ALBEDO, gaussian=form.gaussian)
    black_and_gray = params._replace(A=np.array([0.0, ALBEDO]))
    frame = (wi, wo, laws.NORMAL, laws.ALONG, black_and_gray)
    if form.published:
        profile: published.Profile = "gaussian" if form.gaussian else "cauchy"
        value = published.evaluate(*frame, profile=profile)
    else:
        value = microcylinder.evaluate(*frame)
    return Parts(value[..., 0], value[..., 1] - value[..., 0])


def around(plane: Plane, angle: ArrayLike) -> Doubles:
    """Return the unit vectors (…, 3) of a plane at `angle` (…) in radians to the normal."""
    angle = np.asarray(angle, float)
    zero = np.zeros_like(angle)
    if plane == "along":
        return np.stack([zero, np.sin(angle), np.cos(angle)], axis=-1)
    return np.stack([np.sin(angle), zero, np.cos(angle)], axis=-1)


def cut(subject: Subject, form: Form, plane: Plane, angle: float) -> tuple[Doubles, Parts]:
    """Return angles (`STEPS` + 1,) from -π to π and what is scattered there, seen from `angle`."""
    angles = np.linspace(-np.pi, np.pi, STEPS + 1)
    return angles, parts(subject, form, around(plane, angle), around(plane, angles))


def from_above(
    subject: Subject, form: Form, angle: float, size: int, *, below: bool = False
) -> Doubles:
    """Return a picture (size, size) of a hemisphere; NaN outside of it.

    The distance from the middle is the angle to the normal, 90° at the rim; the fibre runs from
    left to right. The viewer is inclined by `angle` along the fibre, to the left. `below` is the
    hemisphere that is reached through the yarn, seen through it.
    """
    line = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = line[None, :], -line[:, None]
    from_normal = np.hypot(x, y) * (np.pi / 2)
    turn = np.arctan2(y, x)
    up = np.cos(from_normal) * (-1 if below else 1)
    wo = np.stack(
        [np.sin(from_normal) * np.sin(turn), -np.sin(from_normal) * np.cos(turn), up], axis=-1
    )
    total = parts(subject, form, around("along", angle), wo).total
    return np.where(from_normal < np.pi / 2, total, np.nan)
