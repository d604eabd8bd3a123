"""A plugin answers Mitsuba with what scatters behind it, in every variant."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from weaveusd.render import variant


class Even:
    """A quarter of all light in every direction, a half straight on."""

    def sample(self, ctx: Any, si: Any, choice: Any, point: Any, active: Any) -> tuple[Any, Any]:
        import mitsuba as mi

        bs = mi.BSDFSample3f()
        bs.pdf = 0.5 * point.y
        return bs, mi.Color3f(choice)

    def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any) -> tuple[Any, Any]:
        import drjit as dr
        import mitsuba as mi

        return mi.Color3f(dr.select(active, 0.25, 0)), mi.Float(0.125 * wo.z)

    def through(self, si: Any, active: Any) -> Any:
        import mitsuba as mi

        return mi.Color3f(0.5)


@pytest.mark.parametrize("name", [variant.LLVM, "scalar_rgb"])
def test_every_call_reaches_what_scatters(mi: Any, name: str) -> None:
    import drjit as dr

    from weaveusd.render.plugin import plugin_base

    mi.set_variant(name)
    lobes = (mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide, mi.BSDFFlags.Null)
    plugin = plugin_base()
    mi.register_bsdf("even", lambda props: plugin(props, Even(), lobes))
    bsdf = mi.load_dict({"type": "even"})
    ctx, si, up = mi.BSDFContext(), dr.zeros(mi.SurfaceInteraction3f), mi.Vector3f(0, 0, 1)

    def number(value: Any) -> float:
        return float(np.mean(np.array(value)))

    assert number(bsdf.eval(ctx, si, up)) == 0.25
    assert number(bsdf.eval(ctx, si, up, False)) == 0
    assert number(bsdf.pdf(ctx, si, up)) == 0.125
    assert [number(v) for v in bsdf.eval_pdf(ctx, si, up)] == [0.25, 0.125]
    assert number(bsdf.eval_null_transmission(si)) == 0.5
    bs, weight = bsdf.sample(ctx, si, 0.5, mi.Point2f(0, 0.5))
    assert (number(bs.pdf), number(weight)) == (0.25, 0.5)
    assert bsdf.component_count() == 2
    assert bsdf.flags() == int(lobes[0] | lobes[1])
