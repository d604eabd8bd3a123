"""The cloth by its texels: lookup and lobes of one yarn at each hit, in Mitsuba's terms.

Import this module after `weaveusd.render.variant.prepare`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import drjit as dr
import mitsuba as mi

from weaveusd.render import lobes, sampling
from weaveusd.render.optics import YARN_INPUTS
from weaveusd.render.packing import COLOR, COMPONENTS, FRAME, OPACITY, YARN

REFLECTION, TRANSMISSION, NULL = 0, 1, 2
"""Indices of the components."""


class Cloth:
    """Lookup and lobes in Mitsuba's terms; the plugin class hands its calls to this one."""

    def __init__(
        self, packed: Any, optics: Any, repeats: tuple[float, float], gaussian: bool
    ) -> None:
        if len(packed.shape) != 3 or packed.shape[2] != COMPONENTS:
            raise ValueError(f"packed: has shape {packed.shape}, expected (H, W, {COMPONENTS})")
        if len(optics.shape) != 2 or optics.shape[0] != len(YARN_INPUTS):
            raise ValueError(f"optics: has shape {optics.shape}, expected ({len(YARN_INPUTS)}, n)")
        kind = mi.Texture2f16 if isinstance(packed, mi.TensorXf16) else mi.Texture2f
        self.texture = kind(
            packed,
            use_accel=False,
            filter_mode=dr.FilterMode.Nearest,
            wrap_mode=dr.WrapMode.Repeat,
        )
        # The yarn's index is bounded where it is used: an optimizer may have moved the texels.
        self.optics = {name: optics[i].array for i, name in enumerate(YARN_INPUTS)}
        self.repeats = mi.ScalarVector2f(*repeats)
        self.gaussian = gaussian
        # Opaque values keep kernels alike, so that other cloths reuse them.
        dr.make_opaque(self.optics)

    def texel(self, si: Any, active: Any) -> list[Any]:
        """Return the packed values at the interaction."""
        uv = mi.Point2f(si.uv.x * self.repeats.x, si.uv.y * self.repeats.y)
        return [mi.Float(number) for number in self.texture.eval(uv, active)]

    def yarn(
        self, si: Any, texel: Sequence[Any], active: Any
    ) -> tuple[lobes.LobeParameters, Any, Any]:
        """Return the optics, and normal and tangent in the shading frame."""
        flip = mirroring(si)
        normal, tangent = _frame(texel[FRAME : FRAME + 3])
        last = mi.UInt32(len(self.optics["eta"]) - 1)
        index = dr.minimum(mi.UInt32(dr.maximum(texel[YARN], 0) + 0.5), last)
        color = mi.Color3f(*texel[COLOR : COLOR + 3])
        optics = {name: _gather(self.optics[name], index, active) for name in YARN_INPUTS}
        yarn = lobes.LobeParameters(color, **optics, gaussian=self.gaussian)
        return yarn, flip * normal, flip * tangent

    def opacity(self, si: Any, active: Any) -> Any:
        """Return the share of the interaction that is yarn."""
        return self.texel(si, active)[OPACITY]

    def through(self, si: Any, active: Any) -> Any:
        """Return what passes between the yarns."""
        return mi.Color3f(dr.select(active, 1 - self.opacity(si, active), 0))

    def color(self, si: Any, active: Any) -> Any:
        """Return about what share of light comes back."""
        texel = self.texel(si, active)
        return mi.Color3f(*texel[COLOR : COLOR + 3]) * texel[OPACITY]

    def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any) -> tuple[Any, Any]:
        """Return value times cosine, and density; both 0 where the side rule forbids `wo`."""
        texel = self.texel(si, active)
        yarn, normal, tangent = self.yarn(si, texel, active)
        fibre = lobes.fibre(si.wi, normal, tangent)
        direction = fibre.direction(wo)
        allowed = active & allowed_sides(ctx, si.wi, wo, direction)
        opacity = texel[OPACITY]
        value = lobes.value(yarn, fibre, direction) * opacity
        pdf = sampling.density(asked_yarn(ctx, yarn), fibre, direction) * lobes_share(ctx, opacity)
        return dr.select(allowed, value, 0), dr.select(allowed, pdf, 0)

    def sample(self, ctx: Any, si: Any, choice: Any, point: Any, active: Any) -> tuple[Any, Any]:
        """Return a sample and its weight: of the null component in gaps, else of the lobes."""
        texel = self.texel(si, active)
        yarn, normal, tangent = self.yarn(si, texel, active)
        opacity = texel[OPACITY]
        share = lobes_share(ctx, opacity)
        passes = choice >= share
        choice = dr.clip(choice / dr.maximum(share, lobes.TINY), 0, 0.99999994)

        fibre = lobes.fibre(si.wi, normal, tangent)
        asked = asked_yarn(ctx, yarn)
        direction = sampling.sample(asked, fibre, choice, point)
        value = lobes.value(yarn, fibre, direction)
        pdf = sampling.density(asked, fibre, direction)
        wo = fibre.vector(direction)
        allowed = active & allowed_sides(ctx, si.wi, wo, direction) & (pdf > 0)
        bs = sample_record(si.wi, wo, passes, share, dr.select(allowed, pdf * share, 0))

        # Where every event was enabled, share and opacity are one and cancel.
        weight = value * (opacity / dr.maximum(pdf * share, 1e-20))
        weight = dr.select(passes, 0, dr.select(allowed, weight, 0))
        weight = dr.select(passes & active, mi.Color3f(gap_weight(share, opacity)), weight)
        return bs, weight


def mirroring(si: Any) -> Any:
    """Return what takes vectors of the cloth's frame to the shading frame, as a product.

    That frame's t is n × s: where the texture is mirrored, it runs against growing v.
    """
    mirrored = dr.dot(si.sh_frame.t, si.dp_dv) < 0
    return mi.Vector3f(1, dr.select(mirrored, -1.0, 1.0), 1)


def gap_weight(share: Any, opacity: Any) -> Any:
    """Return the weight of a sample that passes, where `share` is the probability of the lobes."""
    return dr.select(share < 1, (1 - opacity) / dr.maximum(1 - share, lobes.TINY), 0)


def sample_record(wi: Any, wo: Any, passes: Any, share: Any, pdf: Any) -> Any:
    """Return Mitsuba's record of a sample: straight on where it `passes`, else `wo`, of the lobes.

    `share` is the probability of the lobes, `pdf` their density at `wo`, that probability included.
    """
    reflected = wo.z * wi.z > 0
    bs = mi.BSDFSample3f()
    bs.wo = dr.select(passes, -wi, wo)
    bs.pdf = dr.select(passes, 1 - share, pdf)
    bs.eta = 1.0
    lobe = dr.select(
        reflected,
        mi.UInt32(int(mi.BSDFFlags.GlossyReflection)),
        mi.UInt32(int(mi.BSDFFlags.GlossyTransmission)),
    )
    bs.sampled_type = dr.select(passes, mi.UInt32(int(mi.BSDFFlags.Null)), lobe)
    component = dr.select(reflected, mi.UInt32(REFLECTION), mi.UInt32(TRANSMISSION))
    bs.sampled_component = dr.select(passes, mi.UInt32(NULL), component)
    return bs


def _frame(vector: Sequence[Any]) -> tuple[Any, Any]:
    """Return the normal and the tangent of a packed frame."""
    x, y, z = vector
    w = dr.safe_sqrt(1 - dr.square(x) - dr.square(y) - dr.square(z))
    normal = mi.Vector3f(
        2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (dr.square(x) + dr.square(y))
    )
    tangent = mi.Vector3f(
        2 * (x * y - w * z), 1 - 2 * (dr.square(x) + dr.square(z)), 2 * (y * z + w * x)
    )
    return normal, tangent


def allowed_sides(ctx: Any, wi: Any, wo: Any, direction: lobes.Direction) -> Any:
    """Return where `wo` lies on an enabled side on which yarn and surface agree."""
    reflected = wo.z * wi.z > 0
    enabled = dr.select(reflected, mi.Bool(_reflects(ctx)), mi.Bool(_transmits(ctx)))
    return enabled & (reflected == (direction.cos_phi > 0)) & (wo.z * wi.z != 0)


def asked_yarn(ctx: Any, yarn: lobes.LobeParameters) -> lobes.LobeParameters:
    """Return the yarn to sample: where one side is asked for, the other gets no samples."""
    if _reflects(ctx) == _transmits(ctx):
        return yarn
    if _reflects(ctx):
        return replace(yarn, tau=mi.Float(0))
    return replace(yarn, tau=mi.Float(1), k_s=mi.Float(0))


def lobes_share(ctx: Any, opacity: Any) -> Any:
    """Return the probability of a sample of the lobes, the rest being one of the gaps."""
    if not ctx.is_enabled(mi.BSDFFlags.Null, NULL):
        return mi.Float(1)
    return opacity if _reflects(ctx) or _transmits(ctx) else mi.Float(0)


def _reflects(ctx: Any) -> bool:
    return bool(ctx.is_enabled(mi.BSDFFlags.GlossyReflection, REFLECTION))


def _transmits(ctx: Any) -> bool:
    return bool(ctx.is_enabled(mi.BSDFFlags.GlossyTransmission, TRANSMISSION))


def _gather(values: Any, index: Any, active: Any) -> Any:
    if dr.is_jit_v(values):
        return dr.gather(mi.Float, values, index, active)
    return values[int(index)]  # Dr.Jit gathers no scalars
