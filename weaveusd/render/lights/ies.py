"""Photometric files of lamps: IES LM-63, as ShapingAPI names them.

Angles are those of type C photometry: vertical 0° is straight down, here the light's -Z;
horizontal 0° lies on the light's -X and 90° on its -Y, as in OpenUSD's reference renderer.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from pxr import Ar

from weaveusd.errors import StageError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

MAX_BYTES = 4 << 20
MAX_VALUES = 1 << 18
"""Intensities in one file."""

STEPS_OFF, STEPS_ABOUT = 361, 721
"""Directions of a sampled profile: every half degree off the axis and about it."""

_HEMISPHERE_RAD = math.pi / 2 + 0.1
"""Profiles of no greater vertical range are taken as those of half a sphere."""


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """Luminous intensity of a lamp, in candela."""

    vertical_deg: Doubles  # (V,) rising, 0…180
    horizontal_deg: Doubles  # (H,) rising over 360, or one that stands for all
    candela: Doubles  # (H, V)

    @property
    def mean(self) -> float:
        """Return the mean intensity over the sphere, or over the half that the file covers.

        Intensity is linear between two angles a < b, so that it counts at a by
        ``cos a - (sin b - sin a) / (b - a)`` and at b by ``(sin b - sin a) / (b - a) - cos b``.
        """
        up, about = np.radians(self.vertical_deg), np.radians(self.horizontal_deg)
        slope = np.diff(np.sin(up)) / np.diff(up)
        by_angle = self.candela[:, :-1] @ (np.cos(up[:-1]) - slope)
        by_angle += self.candela[:, 1:] @ (slope - np.cos(up[1:]))
        if about.size == 1:
            flux = 2 * math.pi * by_angle[0]
        else:
            flux = (np.diff(about) * (by_angle[1:] + by_angle[:-1]) / 2).sum()
        whole = up[-1] - up[0] > _HEMISPHERE_RAD
        return float(flux) / (math.pi * (4 if whole else 2))


def read_profile(path: str, where: str) -> Profile:
    """Return the profile in the file at a resolved path, which may lie in a usdz package.

    Raises
    ------
    StageError
        When the file is none of LM-63 with type C photometry, or larger than `MAX_BYTES`.
    """
    asset = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(path))
    if not asset:
        raise StageError(f"{where}: {path} cannot be opened")
    if asset.GetSize() > MAX_BYTES:
        raise StageError(f"{where}: {path} has {asset.GetSize()} bytes, at most {MAX_BYTES}")
    text = bytes(asset.GetBuffer() or b"").decode("latin-1")  # an empty file has no buffer
    try:
        return parse(text)
    except ValueError as error:
        raise StageError(f"{where}: {path}: {error}") from None


def parse(text: str) -> Profile:
    """Return the profile in the text of a file.

    Raises
    ------
    ValueError
        One line that says what was found and what was expected.
    """
    _, tilt, tail = text.partition("TILT=")
    if not tilt:
        raise ValueError("is no IES file: it lacks the line TILT=")
    kind, _, body = tail.partition("\n")
    words = iter(body.replace(",", " ").split())
    if kind.strip().upper() == "INCLUDE":
        # How the lamp dims when it is tilted: its geometry, then two lists.
        _numbers(words, 1, "tilt geometry")
        _numbers(words, 2 * _count(words, "tilt angles"), "tilt")
    elif kind.strip().upper() != "NONE":
        raise ValueError(f"has TILT={kind.strip()[:40]}, expected NONE or INCLUDE")
    _lamps, _lumens, multiplier = _numbers(words, 3, "lamps, lumens and multiplier")
    verticals, horizontals = _count(words, "vertical"), _count(words, "horizontal")
    if not (verticals >= 2 and horizontals >= 1 and verticals * horizontals <= MAX_VALUES):
        raise ValueError(
            f"has {verticals} x {horizontals} angles, expected 2 x 1 to {MAX_VALUES} in all"
        )
    photometry, *_ = _numbers(words, 5, "photometry, units and size")
    if photometry != 1:
        raise ValueError(f"has photometry of type {photometry:g}, expected 1 (type C)")
    ballast, factor, _watts = _numbers(words, 3, "ballast factors and watts")
    vertical = _angles(words, verticals, 180.0, "vertical")
    horizontal = _angles(words, horizontals, 360.0, "horizontal")
    candela = _numbers(words, verticals * horizontals, "candela").reshape(horizontals, verticals)
    scaled = candela * (multiplier * ballast * factor)
    if scaled.min() < 0 or not np.isfinite(scaled).all():
        raise ValueError("has a negative intensity, expected 0 or more")
    return Profile(vertical, *_whole_turn(horizontal, scaled))


def sampled(profile: Profile, angle_scale: float, *, normalize: bool) -> NDArray[np.float32]:
    """Return intensities (`STEPS_OFF`, `STEPS_ABOUT`), from 0° to 180° and from 0° to 360°.

    `angle_scale` stretches the angle off the axis: from 0° where positive, θ / s, and from 180°
    where negative, (θ - π) / -s + π. Beyond the file's angles there is no light. `normalize`
    divides by `Profile.mean`, as OpenUSD's reference renderer does.
    """
    theta = np.linspace(0.0, 180.0, STEPS_OFF)
    if angle_scale > 0:
        theta = theta / angle_scale
    elif angle_scale < 0:
        theta = (theta - 180.0) / -angle_scale + 180.0
    rows = np.stack(
        [
            np.interp(theta, profile.vertical_deg, row, left=0.0, right=0.0)
            for row in profile.candela
        ]
    )
    about = np.linspace(0.0, 360.0, STEPS_ABOUT)
    if profile.horizontal_deg.size == 1:
        table = np.repeat(rows.T, STEPS_ABOUT, axis=1)
    else:
        start = profile.horizontal_deg[:-1]
        table = np.stack([np.interp(about, start, row[:-1], period=360.0) for row in rows.T])
    mean = profile.mean
    if normalize and mean > 0:
        table = table / mean
    return np.ascontiguousarray(table, np.float32)


def _whole_turn(horizontal: Doubles, candela: Doubles) -> tuple[Doubles, Doubles]:
    """Return angles that span 360°, mirrored as the file's first and last angle say."""
    ends = (horizontal[0], horizontal[-1])
    if horizontal.size == 1:
        return horizontal, candela
    if ends not in ((0.0, 90.0), (0.0, 180.0), (0.0, 360.0), (90.0, 270.0)):
        raise ValueError(
            f"has horizontal angles {ends[0]:g} to {ends[1]:g}, expected 0 to 90, 180 or 360"
        )
    while horizontal[-1] - horizontal[0] < 360:
        horizontal, candela = _mirrored(horizontal, candela)
    return horizontal, candela


def _mirrored(horizontal: Doubles, candela: Doubles) -> tuple[Doubles, Doubles]:
    """Return angles and rows continued by their mirror image at the last angle."""
    back = 2 * horizontal[-1] - horizontal[-2::-1]
    return np.concatenate([horizontal, back]), np.concatenate([candela, candela[-2::-1]])


def _angles(words: Iterator[str], count: int, limit: float, what: str) -> Doubles:
    angles = _numbers(words, count, f"{what} angles")
    if (np.diff(angles) <= 0).any() or angles[0] < 0 or angles[-1] > limit:
        raise ValueError(f"has {what} angles that do not rise from 0 to {limit:g}")
    return angles


def _count(words: Iterator[str], what: str) -> int:
    number = float(_numbers(words, 1, f"number of {what} angles")[0])
    if not (0 <= number <= MAX_VALUES and number == int(number)):
        raise ValueError(f"has {number:g} {what} angles, expected a whole number")
    return int(number)


def _numbers(words: Iterator[str], count: int, what: str) -> Doubles:
    """Return the next `count` numbers; their count is bounded before this is called."""
    found = []
    for _ in range(count):
        word = next(words, None)
        if word is None:
            raise ValueError(f"ends within its {what}")
        try:
            found.append(float(word))
        except ValueError:
            raise ValueError(f"has {word[:20]!r} in its {what}, expected a number") from None
    values = np.array(found)
    if not np.isfinite(values).all():
        raise ValueError(f"has a value in its {what} that is no finite number")
    return values
