"""The cloth as a Mitsuba BSDF: the plugin `weaveusd_cloth`.

Import this module after `weaveusd.render.variant.prepare`; call `register` before a scene with
the plugin is loaded. Every texel gives a yarn's frame, color and yarn; the yarn gives its optics.
Gaps between yarns let light pass straight, as Mitsuba's `mask` does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

import mitsuba as mi
import numpy as np

from weaveusd import contract
from weaveusd.render.distance_cloth import (
    EVERYTHING_NEAR,
    DistantCloth,
    View,
    distant_properties,
)
from weaveusd.render.distance_levels import Levels
from weaveusd.render.exact import Cloth
from weaveusd.render.optics import YARN_INPUTS, yarn_table
from weaveusd.render.packing import pack
from weaveusd.render.plugin import plugin_base

if TYPE_CHECKING:
    from numpy.typing import NDArray


def cloth_bsdf_dict(
    arrays: Mapping[str, NDArray[Any]],
    yarn_inputs: Mapping[str, Sequence[float]],
    uv_scale: tuple[float, float],
    *,
    gaussian: bool = False,
    dtype: type[np.floating[Any]] = np.float32,
) -> dict[str, Any]:
    """Return the dictionary from which `mi.load_dict` makes a cloth out of arrays in memory.

    Parameters
    ----------
    arrays
        Channel name to (H, W, components) array, row 0 at v = 0: `normal`, `tangent`,
        `base_color`, `opacity` and `yarn_id`, the last as index with `contract.GAP` in gaps.
        These are the channels of a `TextureSet`, read as a whole.
    yarn_inputs
        `contract.SHADER_YARN_INPUTS`, one value for each yarn; angles in radians.
    uv_scale
        Repeats of the textures in one unit of the texture coordinates.
    gaussian
        Whether lobes are Gaussians with the widths as standard deviations, the reference option,
        instead of Cauchy lobes. The normalization has to be that of the lobes chosen.
    dtype
        Of the texels in memory: float32, or float16 for half the memory.

    Raises
    ------
    ValueError
        When a channel or an input is missing, has the wrong shape, or leaves its range.
    """
    optics = yarn_table(yarn_inputs)
    packed, _ = pack(arrays, optics.shape[1], dtype)
    return packed_bsdf_dict(packed, optics, uv_scale, gaussian=gaussian)


def packed_bsdf_dict(
    packed: NDArray[np.floating[Any]],
    optics: NDArray[np.float32],
    uv_scale: tuple[float, float],
    *,
    gaussian: bool = False,
    levels: Levels | None = None,
    view: View = EVERYTHING_NEAR,
) -> dict[str, Any]:
    """Return the dictionary for what `pack` and `yarn_table` return.

    With `levels` the cloth is shaded by them where `view` sees it from afar; `with_view` gives a
    cloth another view. The lobes of levels are Cauchy, and a scalar variant has none.
    """
    if levels is not None and gaussian:
        raise ValueError("levels: need Cauchy lobes")
    if not all(np.isfinite(s) and s > 0 for s in uv_scale):
        raise ValueError(f"uv_scale: is {tuple(uv_scale)}, expected two positive numbers")
    register()
    return {
        "type": contract.CLOTH_SHADER_ID,
        "packed": (mi.TensorXf16 if packed.dtype == np.float16 else mi.TensorXf)(packed),
        "optics": mi.TensorXf(optics),
        "repeats_u": float(uv_scale[0]),
        "repeats_v": float(uv_scale[1]),
        "gaussian": gaussian,
        **({} if levels is None else distant_properties(levels, optics, view)),
    }


def register() -> None:
    """Make the plugin known to the active variant."""
    _register(mi.variant())


@cache
def _register(variant: str) -> None:
    mi.register_bsdf(contract.CLOTH_SHADER_ID, _plugin_class(variant))


def _plugin_class(variant: str) -> type:
    """Return the plugin's class: it derives from the BSDF of one variant."""

    class ClothBSDF(plugin_base()):  # type: ignore[misc]
        """Mitsuba's side of `Cloth` for the variant of its creation."""

        def __init__(self, props: Any) -> None:
            repeats = (props["repeats_u"], props["repeats_v"])
            texels = (props["packed"], props["optics"], repeats, props["gaussian"])
            self.cloth = DistantCloth(props, *texels) if "cells" in props else Cloth(*texels)
            sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            varying = sides | mi.BSDFFlags.SpatiallyVarying | mi.BSDFFlags.Anisotropic
            reflection = mi.BSDFFlags.GlossyReflection | varying
            transmission = mi.BSDFFlags.GlossyTransmission | varying
            null = mi.BSDFFlags.Null | sides | mi.BSDFFlags.SpatiallyVarying
            super().__init__(props, self.cloth, (reflection, transmission, null))

        def eval_diffuse_reflectance(self, si: Any, active: Any = True) -> Any:
            return self.cloth.color(si, active)

        def traverse(self, callback: Any) -> None:
            smooth = mi.ParamFlags.Differentiable
            callback.put("packed", self.cloth.texture.tensor(), smooth)
            for name in YARN_INPUTS:
                callback.put(name, self.cloth.optics[name], smooth)

        def parameters_changed(self, keys: list[str]) -> None:
            if not keys or "packed" in keys:
                self.cloth.texture.update_inplace()

        def to_string(self) -> str:
            height, width, _ = self.cloth.texture.tensor().shape
            yarns = len(self.cloth.optics["eta"])
            return f"ClothBSDF[{width} x {height} texels, {yarns} yarns, {variant}]"

    return ClothBSDF
