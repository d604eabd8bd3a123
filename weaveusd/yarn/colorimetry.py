"""Measured colors to linear Rec.709, through colour-science.

Observer: CIE 1931, 2°. Adaptation: the Bradford transform to Rec.709's white, D65 at
(0.3127, 0.3290). Importing this module is cheap; colour-science is imported by its functions.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from weaveusd.yarn.model import RGB

OBSERVER = "CIE 1931 2 Degree Standard Observer"
ADAPTATION = "Bradford"
VISIBLE_NM = (360, 780)
"""Wavelengths that are integrated, in steps of 1 nm."""


def linear_from_lab(lab: tuple[float, float, float], illuminant: str) -> RGB:
    """Return linear Rec.709 of CIE L*a*b* under `illuminant`, "D50" or "D65"; not clipped."""
    colour = _colour()
    white = colour.CCS_ILLUMINANTS[OBSERVER][illuminant]
    return _linear(colour, colour.Lab_to_XYZ(lab, white), white)


def linear_from_reflectance(wavelengths_nm: Sequence[float], reflectance: Sequence[float]) -> RGB:
    """Return linear Rec.709 of an evenly spaced spectrum, seen under D65; not clipped.

    Between samples Sprague's interpolation (CIE 167:2005), beyond them the last sample. A
    perfect diffuser is white, (1, 1, 1), and a gray one is as gray as its reflectance.
    """
    colour = _colour()
    first, last = VISIBLE_NM
    shape = colour.SpectralShape(first, last, 1)
    observer = colour.MSDS_CMFS[OBSERVER].copy().align(shape)
    light = colour.SDS_ILLUMINANTS["D65"].copy()
    light = light.interpolate(colour.SpectralShape(light.shape.start, last, 1)).align(shape)
    nm = np.arange(first, last + 1)
    factor = np.interp(nm, *_sampled(colour, wavelengths_nm, reflectance))
    weight = observer.values * light.values[:, None]
    white = weight.sum(0) / weight[:, 1].sum()
    xyz = factor @ weight / weight[:, 1].sum()
    return _linear(colour, xyz, colour.XYZ_to_xy(white))


def delta_e_2000(first: RGB, second: RGB) -> float:
    """Return the CIEDE2000 difference of two colors in linear Rec.709."""
    colour = _colour()
    space = colour.RGB_COLOURSPACES["ITU-R BT.709"]
    # Beyond the spectral locus the lightness can be negative; Lab is defined from 0 on.
    lab = [
        colour.XYZ_to_Lab(np.maximum(colour.RGB_to_XYZ(c, space), 0), space.whitepoint)
        for c in (first, second)
    ]
    return float(colour.delta_E(*lab, method="CIE 2000"))


def _sampled(
    colour: Any, wavelengths_nm: Sequence[float], reflectance: Sequence[float]
) -> tuple[Any, Any]:
    """Return the spectrum at every nanometre from its first sample to its last."""
    nm = np.asarray(wavelengths_nm)
    every = np.arange(np.ceil(nm[0]), np.floor(nm[-1]) + 1)
    curve = colour.SpragueInterpolator(nm, np.asarray(reflectance))
    return every, np.clip(curve(every), 0, 1)


def _linear(colour: Any, xyz: Any, white_xy: Any) -> RGB:
    rgb = colour.XYZ_to_RGB(
        xyz,
        colour.RGB_COLOURSPACES["ITU-R BT.709"],
        illuminant=white_xy,
        chromatic_adaptation_transform=ADAPTATION,
    )
    r, g, b = (float(v) for v in rgb)
    return r, g, b


def _colour() -> Any:
    """Return colour-science without its remark on plots, and without its print options."""
    with warnings.catch_warnings(), np.printoptions():
        warnings.filterwarnings("ignore", '"(Matplotlib|SciPy)" related API features')
        import colour
    return colour
