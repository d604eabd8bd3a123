"""FLIP, the difference of two pictures as an eye sees it that flips between them.

LDR-FLIP after Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images", with
the paper's constants. Pictures are (H, W, 3) linear Rec.709, 1 being white.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

PIXELS_PER_DEGREE = 67.0
"""A screen 0.7 m wide of 3840 pixels, seen from 0.7 m."""

_TO_XYZ = np.array(
    [
        [10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794],
        [2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897],
        [1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382],
    ]
)
"""Linear Rec.709 to CIE XYZ, from the chromaticities of ITU-R BT.709."""

_WHITE = _TO_XYZ.sum(axis=1)

# Sensitivity to contrast of achromatic, red to green and blue to yellow: a1, b1, a2, b2.
_CSF = ((1.0, 0.0047, 0.0, 1e-5), (1.0, 0.0053, 0.0, 1e-5), (34.1, 0.04, 13.5, 0.025))
_WIDEST = 0.04

_Q_COLOR, _Q_FEATURE = 0.7, 0.5
_P_C, _P_T = 0.4, 0.95
_FEATURE_WIDTH = 0.082


def flip(reference: Any, test: Any) -> Doubles:
    """Return the FLIP map (H, W), 0 for equal and 1 for the largest difference."""
    pair = [_opponent(np.clip(np.asarray(p, np.float64), 0, 1)) for p in (reference, test)]
    colors = [_hunt(_filtered(p)) for p in pair]
    color = _redistributed(_hyab(*colors) ** _Q_COLOR)
    lights = [(p[..., 0] + 16) / 116 for p in pair]
    feature = np.maximum(
        *(np.abs(_features(lights[0], kind) - _features(lights[1], kind)) for kind in (0, 1))
    )
    feature = (feature / math.sqrt(2)) ** _Q_FEATURE
    return np.asarray(color ** (1 - feature))


def _opponent(rgb: Doubles) -> Doubles:
    """Return Y, Cx and Cz, in which the eye's sensitivity is stated."""
    x, y, z = np.moveaxis(rgb @ _TO_XYZ.T / _WHITE, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def _filtered(opponent: Doubles) -> Doubles:
    """Return linear Rec.709 as it is after the eye has lost what is too fine for it."""
    radius = math.ceil(3 * math.sqrt(_WIDEST / (2 * math.pi**2)) * PIXELS_PER_DEGREE)
    squared = _grid(radius)[2] / PIXELS_PER_DEGREE**2
    seen = []
    for channel, (a1, b1, a2, b2) in enumerate(_CSF):
        kernel = sum(
            a * math.sqrt(math.pi / b) * np.exp(-(math.pi**2) * squared / b)
            for a, b in ((a1, b1), (a2, b2))
        )
        seen.append(_convolved(opponent[..., channel], kernel / np.sum(kernel)))
    y = (seen[0] + 16) / 116
    xyz = np.stack([y + seen[1] / 500, y, y - seen[2] / 200], axis=-1) * _WHITE
    return np.asarray(np.clip(xyz @ np.linalg.inv(_TO_XYZ).T, 0, 1))


def _hunt(rgb: Doubles) -> Doubles:
    """Return CIE Lab in which dark colors have less chroma."""
    x, y, z = np.moveaxis(_lab_curve(rgb @ _TO_XYZ.T / _WHITE), -1, 0)
    light = 116 * y - 16
    return np.stack([light, 0.01 * light * 500 * (x - y), 0.01 * light * 200 * (y - z)], axis=-1)


def _lab_curve(t: Doubles) -> Doubles:
    delta = 6 / 29
    return np.where(t > delta**3, np.cbrt(t), t / (3 * delta**2) + 4 / 29)


def _hyab(one: Doubles, other: Doubles) -> Doubles:
    light, a, b = np.moveaxis(one - other, -1, 0)
    return np.asarray(np.abs(light) + np.hypot(a, b))


def _redistributed(difference: Doubles) -> Doubles:
    """Return differences of color, 0 to 1, most of the range for the smaller ones."""
    green, blue = _hunt(np.array([0.0, 1.0, 0.0])), _hunt(np.array([0.0, 0.0, 1.0]))
    largest = float(_hyab(green, blue)) ** _Q_COLOR
    knee = _P_C * largest
    above = _P_T + (difference - knee) / (largest - knee) * (1 - _P_T)
    return np.asarray(np.where(difference < knee, _P_T / knee * difference, above))


def _features(light: Doubles, kind: int) -> Doubles:
    """Return how strong the edges, or for `kind` 1 the points, of a picture are."""
    deviation = 0.5 * _FEATURE_WIDTH * PIXELS_PER_DEGREE
    x, _, squared = _grid(math.ceil(3 * deviation))
    bell = np.exp(-squared / (2 * deviation**2))
    kernel = (x**2 / deviation**2 - 1) * bell if kind else -x * bell
    up, down = kernel > 0, kernel < 0
    kernel[up] /= kernel[up].sum()
    kernel[down] /= -kernel[down].sum()
    return np.hypot(_convolved(light, kernel), _convolved(light, kernel.T))


def _grid(radius: int) -> tuple[Doubles, Doubles, Doubles]:
    """Return x, y and x² + y² of a square of pixels around its middle."""
    y, x = np.mgrid[-radius : radius + 1, -radius : radius + 1].astype(np.float64)
    return x, y, x**2 + y**2


def _convolved(values: Doubles, kernel: Any) -> Doubles:
    """Return `values` (H, W) under an odd, square `kernel`; borders are repeated outwards."""
    radius = len(kernel) // 2
    padded = np.pad(values, radius, mode="edge")
    shape = tuple(side + 2 * radius for side in padded.shape)
    spectrum = np.fft.rfft2(padded, shape) * np.fft.rfft2(kernel, shape)
    whole = np.fft.irfft2(spectrum, shape)
    height, width = values.shape
    return np.asarray(whole[2 * radius : 2 * radius + height, 2 * radius : 2 * radius + width])
