"""Moment maps by NumPy, as plainly as they are defined, which the compiled loop is held to."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weaveusd.synth import moments as m
from weaveusd.synth.boxes import reduced
from weaveusd.synth.kinds import kinds_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from weaveusd.cloth.model import Weave
    from weaveusd.synth.model import Band
    from weaveusd.synth.moments import Section

    Doubles = NDArray[np.float64]
    Floats32 = NDArray[np.float32]


def channels(
    band: Band, weave: Weave, width: int, height: int, gains: Sequence[float] | None = None
) -> tuple[Doubles, Doubles]:
    """Return moments, albedo and shares of warp and weft side by side, (height, width, c) each.

    `band` is all of the textures of `weave`.
    """
    yarn = np.maximum(band["yarn_id"][..., 0], 0).astype(np.intp)
    gain = np.ones(len(weave.yarns)) if gains is None else np.asarray(gains)
    out = []
    for weft, section in enumerate(m.sections(weave)):
        kinds = kinds_of(weave, weft=bool(weft))
        moments = texel_moments(band, section, weft=bool(weft))
        a = moments[..., [m.FLAT, m.RISING, m.FALLING]].sum(-1)
        albedo = (
            np.minimum(band["base_color"].astype(float) * gain[yarn][..., None], 1) * a[..., None]
        )
        of_kind = np.array(kinds.of_yarn)[yarn][..., None] == np.arange(len(kinds.optics))
        whole = np.concatenate([moments, albedo, a[..., None] * of_kind], -1)
        out.append(reduced(whole, width, height))
    warp, weft_channels = out
    return warp, weft_channels


def texel_moments(band: Band, section: Section, *, weft: bool) -> Doubles:
    """Return the moments (rows, width, 12) of single texels, 0 where the other system is.

    `band` holds `normal`, `tangent`, `opacity` and `system`. The yarn's frame is found back from
    the normal, n ∝ (ρ sin v, sin u cos v, cos u cos v) with ρ = b/a, and the fibre,
    t = cos ψ T − sin ψ T_v (physics.md C), turned so that ψ lies within ±90°.
    """
    n_x, n_y, n_z = _in_yarn_frame(band["normal"], weft)
    t_x, t_y, t_z = _in_yarn_frame(band["tangent"], weft)
    up = np.sqrt(n_y * n_y + n_z * n_z)
    scale = 1 / np.maximum(up, 1e-12)
    sin_u, cos_u = n_y * scale, n_z * scale
    flat = section.flatness * up
    x = n_x / np.sqrt(n_x * n_x + flat * flat)
    k = section.curvature
    s = sin_u * (1 + k * np.sqrt(np.maximum(1 - x * x, 0))) / (1 + k)
    forward = np.where(t_y * cos_u - t_z * sin_u < 0, -1.0, 1.0)
    p = -forward * (t_x * up - n_x * (t_y * sin_u + t_z * cos_u))

    a = np.where(band["system"][..., 0] == float(weft), band["opacity"][..., 0], 0).astype(float)
    rising, falling = a * (s > m.STRAIGHT), a * (s < -m.STRAIGHT)
    out = np.empty((*a.shape, m.MOMENTS))
    out[..., m.RISING], out[..., m.FALLING] = rising, falling
    out[..., m.FLAT] = a - rising - falling
    out[..., m.RISING_S], out[..., m.RISING_SS] = rising * s, rising * s * s
    out[..., m.FALLING_S], out[..., m.FALLING_SS] = falling * s, falling * s * s
    out[..., m.ACROSS], out[..., m.ASIDE], out[..., m.ACROSS_XX] = a * x, a * np.abs(x), a * x * x
    out[..., m.TWIST], out[..., m.TWIST_PP] = a * p, a * p * p
    return out


def _in_yarn_frame(vectors: Floats32, weft: bool) -> tuple[Doubles, Doubles, Doubles]:
    """Return components across the yarn, along it and out of the cloth."""
    x, y, z = (vectors[..., i].astype(float) for i in range(3))
    return (-y, x, z) if weft else (x, y, z)
