"""The mathematics of the layered surface: coat, anisotropic mirror, diffuse base.

Import this module after `weaveusd.render.variant.prepare`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from weaveusd.render.mirror_albedo import COSINES, ROUGHNESSES, ggx_albedo

HIGHLIGHT, BASE, THROUGH = 0, 1, 2
"""Indices of the components."""

MIN_ALPHA = 2e-3
"""Smoother mirrors are shown as this one: single precision resolves no narrower highlight."""

FULL_FRESNEL = 50.0
"""F90 fades where F0 is below 1/50, as nothing reflects without an interface."""

_EPSILON = 1e-4


@dataclass(slots=True)
class _Point:
    """The surface at an interaction: frame in the shading frame, weights of the layers."""

    frame: Any
    alpha: Any  # (2)
    mirror_0: Any  # reflectance of the highlight along its half vector
    mirror_90: Any
    diffuse: Any
    through: Any
    coat: Any  # weight
    coat_0: Any
    coat_90: Any
    coat_alpha: Any
    below_coat: Any
    share: tuple[Any, Any, Any, Any]  # of samples: coat, highlight, diffuse, through


class Layers:
    """The BSDF's mathematics; the plugin class hands its calls to this one."""

    def __init__(self, textures: dict[str, Any], clear: bool) -> None:
        self.textures, self.clear = textures, clear
        self.albedo = mi.Texture2f(
            mi.TensorXf(ggx_albedo()), use_accel=False, wrap_mode=dr.WrapMode.Clamp
        )

    def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any) -> tuple[Any, Any]:
        """Return value times cosine, and density, for a direction in the shading frame."""
        wi, wo = self._upright(si.wi, si.wi), self._upright(wo, si.wi)
        active = active & (wi.z > 0) & (wo.z > 0)
        point = self._point(ctx, si, wi, active)
        value, pdf = self._lobes(point, wi, wo)
        good = active & (pdf > 0)
        return dr.select(good, value, 0), dr.select(good, pdf, 0)

    def through(self, si: Any, active: Any) -> Any:
        """Return what goes straight through."""
        if not self.clear:
            return mi.Color3f(0)
        point = self._point(mi.BSDFContext(), si, self._upright(si.wi, si.wi), active)
        return dr.select(active, point.through, 0)

    def sample(self, ctx: Any, si: Any, choice: Any, place: Any, active: Any) -> tuple[Any, Any]:
        """Return a direction and its weight: one lobe is drawn, all are counted."""
        wi = self._upright(si.wi, si.wi)
        active = active & (wi.z > 0)
        point = self._point(ctx, si, wi, active)
        to_coat, to_mirror, to_diffuse, _ = point.share
        frame, view = point.frame, point.frame.to_local(wi)

        coat, _ = _ggx(point.coat_alpha, point.coat_alpha).sample(view, place)
        mirror, _ = _ggx(point.alpha.x, point.alpha.y).sample(view, place)
        ends = (to_coat, to_coat + to_mirror, to_coat + to_mirror + to_diffuse)
        is_coat = choice < ends[0]
        is_diffuse = (choice >= ends[1]) & (choice < ends[2])
        passes = (choice >= ends[2]) & mi.Bool(self.clear)
        scatters = (choice < ends[2]) | mi.Bool(not self.clear)
        half = dr.select(is_coat, coat, mirror)
        reflected = mi.Vector3f(half * (2 * dr.dot(view, half)) - view)
        local = dr.select(is_diffuse, mi.warp.square_to_cosine_hemisphere(place), reflected)
        wo = frame.to_world(local)
        value, pdf = self._lobes(point, wi, wo)
        good = active & scatters & (wo.z > 0) & (pdf > 0)

        bs = mi.BSDFSample3f()
        bs.wo = dr.select(passes, -si.wi, self._upright(wo, si.wi))
        bs.eta = 1.0
        bs.pdf = dr.select(passes, point.share[3], dr.select(good, pdf, 0))
        kind = dr.select(
            is_diffuse,
            mi.UInt32(int(mi.BSDFFlags.DiffuseReflection)),
            mi.UInt32(int(mi.BSDFFlags.GlossyReflection)),
        )
        bs.sampled_type = dr.select(passes, mi.UInt32(int(mi.BSDFFlags.Null)), kind)
        index = dr.select(is_diffuse, mi.UInt32(BASE), mi.UInt32(HIGHLIGHT))
        bs.sampled_component = dr.select(passes, mi.UInt32(THROUGH), index)
        weight = dr.select(good, value / dr.maximum(pdf, 1e-20), 0)
        straight = point.through / dr.maximum(point.share[3], 1e-12)
        return bs, dr.select(passes & active, straight, weight)

    def _upright(self, direction: Any, wi: Any) -> Any:
        """Return a direction as seen from the side of `wi`, where the surface has two sides."""
        if not self.clear:
            return direction
        up = dr.select(wi.z < 0, -1.0, 1.0)
        return mi.Vector3f(direction.x, direction.y, direction.z * up)

    def _point(self, ctx: Any, si: Any, wi: Any, active: Any) -> _Point:
        color, number = self._color, self._number
        metal = dr.clip(number("metalness", si, active), 0, 1)
        base = dr.clip(color("base_color", si, active), 0, 1)
        f0 = dr.clip(color("f0", si, active), 0, 1)
        f90 = dr.clip(color("f90", si, active), 0, 1) * dr.minimum(f0 * FULL_FRESNEL, 1)
        frame = self._frame(si, wi, active)
        cosine = dr.maximum(dr.dot(wi, frame.n), _EPSILON)
        rough = color("alpha", si, active)
        alpha = mi.Vector2f(*(dr.clip(rough[k], MIN_ALPHA, 1) for k in range(2)))
        a, b = self._stretched(cosine, alpha)

        # Light that is scattered between the facets again is added to the single mirror (Turquin
        # 2019); a stretched one loses another share, so it gets less of it and never too much.
        evenness = dr.minimum(alpha.x, alpha.y) / dr.maximum(alpha.x, alpha.y)
        lost = evenness * (1 - a - b) / dr.maximum(a + b, 0.1)
        f0_all, base_all = f0 * (1 + f0 * lost), base * (1 + base * lost)
        f90_all = f90 * (1 + f0 * lost)
        metal_90 = dr.clip(color("metal_f90", si, active), 0, 1) * (1 + base * lost)
        mirror_0 = dr.lerp(f0_all, base_all, metal)
        mirror_90 = dr.lerp(f90_all, metal_90, metal)
        below = 1 - dr.minimum(f0_all * a + f90_all * b, 1)
        opaque = dr.clip(number("opacity", si, active), 0, 1) if self.clear else mi.Float(1)
        diffuse = base * (1 - metal) * below * opaque
        through = (1 - metal) * below * (1 - opaque)

        coat = dr.clip(number("coat", si, active), 0, 1)
        coat_0 = dr.clip(number("coat_f0", si, active), 0, 1)
        coat_90 = dr.minimum(coat_0 * FULL_FRESNEL, 1)
        coat_alpha = dr.clip(number("coat_alpha", si, active), MIN_ALPHA, 1)
        coat_a, coat_b = self._tabulated(cosine, coat_alpha)
        tint = dr.lerp(mi.Color3f(1), dr.clip(color("coat_color", si, active), 0, 1), coat)
        coat_albedo = coat * (coat_0 * coat_a + coat_90 * coat_b)
        below_coat = tint * (1 - coat_albedo)

        glossy = mi.Float(ctx.is_enabled(mi.BSDFFlags.GlossyReflection, HIGHLIGHT))
        rest = mi.Float(ctx.is_enabled(mi.BSDFFlags.DiffuseReflection, BASE))
        null = mi.Float(self.clear and ctx.is_enabled(mi.BSDFFlags.Null, THROUGH))
        coat, mirror_0, mirror_90 = coat * glossy, mirror_0 * glossy, mirror_90 * glossy
        diffuse, through = diffuse * rest, below_coat * through * null
        weights = (
            coat_albedo * glossy,
            dr.mean(below_coat * (mirror_0 * a + mirror_90 * b)),
            dr.mean(below_coat * diffuse),
            dr.mean(through),
        )
        total = dr.maximum(sum(weights), 1e-12)
        share = tuple(w / total for w in weights)
        return _Point(
            frame, alpha, mirror_0, mirror_90, diffuse, through, coat, coat_0, coat_90,
            coat_alpha, below_coat, (share[0], share[1], share[2], share[3]),
        )  # fmt: skip

    def _lobes(self, point: _Point, wi: Any, wo: Any) -> tuple[Any, Any]:
        """Return value times cosine and density of all that is scattered."""
        view, light = point.frame.to_local(wi), point.frame.to_local(wo)
        seen = (view.z > 0) & (light.z > 0)
        half = dr.normalize(view + light)
        along = dr.dot(view, half)
        schlick = dr.power(dr.clip(1 - along, 0, 1), 5)

        coat, coat_pdf = _mirror(_ggx(point.coat_alpha, point.coat_alpha), view, light, half)
        coat = coat * point.coat * dr.lerp(point.coat_0, point.coat_90, schlick)
        mirror, mirror_pdf = _mirror(_ggx(point.alpha.x, point.alpha.y), view, light, half)
        glossy = dr.lerp(point.mirror_0, point.mirror_90, schlick) * mirror
        cosine = dr.maximum(light.z, 0) * dr.inv_pi
        value = coat + point.below_coat * (glossy + point.diffuse * cosine)
        to_coat, to_mirror, to_diffuse, _ = point.share
        pdf = to_coat * coat_pdf + to_mirror * mirror_pdf + to_diffuse * cosine
        return dr.select(seen, value, 0), dr.select(seen, pdf, 0)

    def _frame(self, si: Any, wi: Any, active: Any) -> Any:
        """Return normal and tangent in the shading frame.

        The frame's t is n × s: where texture coordinates are mirrored, it runs against growing
        t of the texture. A normal that is turned away from `wi` is bent until it is not.
        """
        mirrored = dr.dot(si.sh_frame.t, si.dp_dv) < 0
        flip = mi.Vector3f(1, dr.select(mirrored, -1.0, 1.0), 1)
        normal = mi.Vector3f(0, 0, 1)
        if "normal" in self.textures:
            normal = flip * mi.Vector3f(self._color("normal", si, active))
            normal = dr.select(dr.squared_norm(normal) > 1e-8, normal, mi.Vector3f(0, 0, 1))
            normal = dr.normalize(normal)
            short = dr.maximum(_EPSILON * 10 - dr.dot(normal, wi), 0)
            normal = dr.normalize(normal + wi * short)
        tangent = mi.Vector3f(1, 0, 0)
        if "tangent" in self.textures:
            tangent = flip * mi.Vector3f(self._color("tangent", si, active))
        flat = tangent - normal * dr.dot(tangent, normal)
        spare = mi.coordinate_system(normal)[0]
        flat = dr.select(dr.squared_norm(flat) > 1e-8, flat, spare)
        s = dr.normalize(flat)
        return mi.Frame3f(s, dr.cross(normal, s), normal)

    def _stretched(self, cosine: Any, alpha: Any) -> tuple[Any, Any]:
        """Return the shares of F0 and F90 by the one of two roughnesses that loses less light.

        So no stretched highlight reflects more than it receives; it may reflect less.
        """
        a, b = self._tabulated(cosine, alpha.x)
        other_a, other_b = self._tabulated(cosine, alpha.y)
        less = a + b < other_a + other_b
        return dr.select(less, other_a, a), dr.select(less, other_b, b)

    def _tabulated(self, cosine: Any, alpha: Any) -> tuple[Any, Any]:
        """Return the shares of F0 and F90 in the albedo of a mirror."""
        u = (cosine * (COSINES - 1) + 0.5) / COSINES
        v = (dr.sqrt(alpha) * (ROUGHNESSES - 1) + 0.5) / ROUGHNESSES
        a, b = self.albedo.eval(mi.Point2f(u, v))
        return a, b

    def _color(self, name: str, si: Any, active: Any) -> Any:
        return self.textures[name].eval_3(si, active)

    def _number(self, name: str, si: Any, active: Any) -> Any:
        return self.textures[name].eval_1(si, active)


def _ggx(alpha_u: Any, alpha_v: Any) -> Any:
    return mi.MicrofacetDistribution(mi.MicrofacetType.GGX, alpha_u, alpha_v, True)


def _mirror(facets: Any, view: Any, light: Any, half: Any) -> tuple[Any, Any]:
    """Return D G2 / (4 cos θi) and the density of sampling visible normals.

    G2 is Smith's, correlated by height: ``1 / (1/G1(i) + 1/G1(o) - 1)``.
    """
    cosine = dr.maximum(view.z, _EPSILON)
    g_in = dr.maximum(facets.smith_g1(view, half), 1e-9)
    g_out = facets.smith_g1(light, half)
    g2 = g_in * g_out / (g_in + g_out - g_in * g_out)
    value = facets.eval(half) * g2 / (4 * cosine)
    pdf = facets.pdf(view, half) / (4 * dr.maximum(dr.dot(view, half), _EPSILON))
    return value, pdf
