"""Cost and noise of surfaces as stages bring them, beside Mitsuba's own BSDFs.

One scene, a ball under a sky and a lamp, in one run: every surface is rendered warm and in turn,
and the least CPU time of its turns counts. `layered` is what UsdPreviewSurface, OpenPBR and the
others become; `principled` and `roughconductor` are Mitsuba's. The metals must agree.

    python benchmarks/materials.py [--turns 7] [--size 256] [--spp 32]
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import numpy as np

from weaveusd.render import variant

GRAY, METAL, AGREEMENT = (0.5, 0.4, 0.3), (0.9, 0.7, 0.4), 0.01


def main() -> None:
    """Measure and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--turns", type=int, default=7)
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--spp", type=int, default=32)
    given = parser.parse_args()
    variant.prepare(variant.LLVM)

    scenes = {name: _scene(bsdf, given.size) for name, bsdf in _surfaces().items()}
    seconds: dict[str, list[float]] = {name: [] for name in scenes}
    pictures: dict[str, list[Any]] = {name: [] for name in scenes}
    for turn in range(given.turns + 1):
        for name, scene in scenes.items():
            begin = time.process_time()
            picture = _render(scene, given.spp, turn)
            if turn:  # the first one compiles
                seconds[name].append(time.process_time() - begin)
                pictures[name].append(picture)
    means = {name: np.mean(p, axis=0) for name, p in pictures.items()}
    print(f"{'surface':<34}{'CPU s':>8}{'/ diffuse':>11}{'variance':>11}{'mean':>8}")
    for name in scenes:
        least = min(seconds[name])
        noise = np.var(pictures[name], axis=0, ddof=1).mean()
        ratio = least / min(seconds["diffuse"])
        print(f"{name:<34}{least:>8.3f}{ratio:>11.2f}{noise:>11.2e}{means[name].mean():>8.4f}")
    ours, theirs = means["layered metal"].mean(), means["roughconductor"].mean()
    difference = abs(ours / theirs - 1)
    print(f"metals agree within {difference:.2%}, expected at most {AGREEMENT:.0%}")
    if difference > AGREEMENT:
        raise SystemExit("the metals do not agree")


def _surfaces() -> dict[str, Any]:
    gray, metal = ({"type": "rgb", "value": list(c)} for c in (GRAY, METAL))
    bumps = np.random.default_rng(0).random((512, 512, 3), np.float32) * 0.5 + 0.25
    return {
        "diffuse": {"type": "diffuse", "reflectance": gray},
        "principled": {"type": "principled", "base_color": gray, "roughness": 0.4, "eta": 1.5},
        "principled, coated": {
            "type": "principled", "base_color": gray, "roughness": 0.4, "clearcoat": 1.0,
        },
        "roughconductor": {
            "type": "roughconductor", "material": "none", "alpha": 0.05,
            "distribution": "ggx", "specular_reflectance": metal,
        },
        "layered": _layered({}),
        "layered, coated": _layered({"coat": (1.0,)}),
        "layered, four textures": _layered({}, bumps),
        "layered metal": _layered(
            {"metalness": (1.0,), "base_color": METAL, "metal_f90": METAL, "alpha": (0.05, 0.05)}
        ),
    }  # fmt: skip


def _layered(values: dict[str, Any], texels: Any = None) -> dict[str, Any]:
    import mitsuba as mi

    from weaveusd.render.fields import Fields, Sampling
    from weaveusd.render.layered import layered_bsdf
    from weaveusd.render.rasters import Raster
    from weaveusd.render.surface import Surface

    fields = Fields()
    plain = {
        "base_color": GRAY, "metalness": (0,), "metal_f90": (1, 1, 1), "f0": (0.04,) * 3,
        "f90": (1, 1, 1), "alpha": (0.16, 0.16), "coat": (0,), "coat_f0": (0.04,),
        "coat_alpha": (0.01,), "coat_color": (1, 1, 1), "opacity": (1,), "emission": (0, 0, 0),
        "transmission": (0,), "transmission_color": (1, 1, 1),
    }  # fmt: skip
    made = {name: fields.constant(*v) for name, v in (plain | values).items()}
    if texels is not None:
        st = fields.primvar("st", fields.constant(0, 0))
        for k, name in enumerate(("base_color", "alpha", "coat", "coat_color")):
            raster = Raster(mi.TensorXf(np.roll(texels, k)))
            picture = fields.picture(Sampling(raster, ("repeat", "repeat")), st)
            made[name] = fields.pick(picture, *range(made[name].width))
    surface = Surface(ior=1.5, thin_walled=False, **made)
    return layered_bsdf(surface, "st")


def _scene(bsdf: dict[str, Any], size: int) -> Any:
    import mitsuba as mi

    transform = mi.ScalarTransform4f
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 4},
            "sensor": {
                "type": "perspective", "fov": 30,
                "to_world": transform().look_at((0, 0, 5), (0, 0, 0), (0, 1, 0)),
                "film": {"type": "hdrfilm", "width": size, "height": size,
                         "rfilter": {"type": "box"}},
            },
            "sky": {"type": "constant", "radiance": 0.5},
            "lamp": {
                "type": "rectangle", "emitter": {"type": "area", "radiance": 20.0},
                "to_world": transform().look_at((3, 3, 3), (0, 0, 0), (0, 1, 0)),
            },
            "ball": {"type": "sphere", "bsdf": bsdf},
        },
        parallel=False,
    )  # fmt: skip


def _render(scene: Any, spp: int, seed: int) -> Any:
    import mitsuba as mi

    return np.array(mi.render(scene, spp=spp, seed=seed), np.float64)


if __name__ == "__main__":
    main()
