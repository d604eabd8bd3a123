"""What the cloth costs and how noisy it is, beside materials that everybody knows.

    python benchmarks/shading.py [--full]

Cost: the same scene with another material each time, all textures of a silk satin in use; the
processor time of all threads, in interleaved runs, after the kernels are compiled.
Noise: variance of one sample of reflected light, BSDF sampling alone, for the yarns of every
preset where they lie in their cloth, against cosine sampling about the yarn's own normal that
chooses the side as ours does. `--full` adds the sizes of the thesis's table 6.1, half an hour.
The exit status is 1 when two samplers disagree on the mean, never for the time.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from weaveusd.cloth.weave import weave
from weaveusd.draft.make import make_draft
from weaveusd.render import variant
from weaveusd.shading.normalization import normalization
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.model import Optics
from weaveusd.yarn.recipe import preset_names, read_preset

variant.prepare(variant.LLVM)

import drjit as dr  # noqa: E402
import mitsuba as mi  # noqa: E402

from weaveusd.render import lobes, sampling  # noqa: E402
from weaveusd.render.bsdf import cloth_bsdf_dict  # noqa: E402
from weaveusd.render.exact import Cloth  # noqa: E402

CELLS = 352
"""Of the drape along a side: 2 · 352² = 247 808 triangles, as in the thesis."""

PASS = 1 << 22
"""Samples of one pass."""

REPEATS = 40.0
ROUGHNESS = 0.4
PLAIN = "diffuse, textured"
FLAT = {"silk/warp_1", "silk/weft_2", "polyester/warp_1", "polyester/weft_2", "satin_lining/warp_1"}
"""Flat silk and flat polyester: a sample of theirs has to be worth three of a cosine."""

VIEWS, SAMPLES = 2048, 512
SKY, BOX = 0.2, 20.0
TURNS = {"dome": 1, "studio": 4}


def woven(
    preset: str, notation: str, resolution: int
) -> tuple[dict[str, Any], dict[str, Any], Any]:
    """Return the channels, the shader's inputs and the names of the yarns of a woven preset."""
    cloth = weave(make_draft(notation), read_preset(preset))
    inputs = [
        {**{name: getattr(y.optics, name) for name in Optics.__slots__}, "normalization": _n_v(y)}
        for y in cloth.yarns
    ]
    columns = {name: [row[name] for row in inputs] for name in inputs[0]}
    channels = dict(synthesize(cloth, resolution=resolution).whole())
    return channels, columns, [f"{preset}/{y.name}" for y in cloth.yarns]


def _n_v(yarn: Any) -> float:
    o = yarn.optics
    return normalization(o.eta, o.k_d, o.k_s, o.gamma_s, o.gamma_v)


# --- Cost ----------------------------------------------------------------------------------------


def drape(bsdf: dict[str, Any]) -> Any:
    """Return a draped cloth with a bump and folds, texture coordinates 0…1."""
    grid = np.linspace(-1, 1, CELLS + 1, dtype=np.float32)
    x, y = np.meshgrid(grid, grid)
    z = 0.35 * np.exp(-3 * (x * x + y * y)) + 0.06 * np.sin(7 * x + 2 * y) * np.cos(5 * y) - 0.6
    corner = np.arange((CELLS + 1) ** 2).reshape(CELLS + 1, CELLS + 1)
    a, b, c, d = (corner[i : i + CELLS, j : j + CELLS] for i in (0, 1) for j in (0, 1))
    faces = np.stack((a, b, d, a, d, c), -1).reshape(-1, 3)
    props = mi.Properties()
    props["mesh_bsdf"] = mi.load_dict(bsdf, parallel=False)
    mesh = mi.Mesh(
        "cloth", x.size, len(faces), props=props,
        has_vertex_normals=True, has_vertex_texcoords=True,
    )  # fmt: skip
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = np.stack((0.8 * x, z, -0.8 * y), -1).ravel()
    parameters["vertex_texcoords"] = (np.stack((x, y), -1) * 0.5 + 0.5).ravel()
    parameters["faces"] = faces.astype(np.uint32).ravel()
    parameters.update()
    mesh.recompute_vertex_normals()
    return mesh


def cornell_box(bsdf: dict[str, Any], size: int) -> Any:
    """Return Mitsuba's Cornell box with the drape in it instead of its boxes."""
    scene = mi.cornell_box()
    del scene["small-box"], scene["large-box"]
    scene["sensor"]["film"] |= {"width": size, "height": size}
    return mi.load_dict(scene | {"drape": drape(bsdf)}, parallel=False)


def under_a_dome(bsdf: dict[str, Any], size: int) -> Any:
    """Return the drape alone under a white sky, filling the picture, light reflected once."""
    look = mi.ScalarTransform4f().look_at([0, 0.6, 1.2], [0, -0.5, 0], [0, 1, 0])
    film = {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}}
    return mi.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2},
        "sensor": {"type": "perspective", "fov": 40, "to_world": look, "film": film},
        "sky": {"type": "constant"},
        "drape": drape(bsdf),
    }, parallel=False)  # fmt: skip


def materials(names: tuple[str, ...] = ()) -> dict[str, dict[str, Any]]:
    """Return the materials compared, all of one color; only those named where names are given."""
    channels, inputs, _ = woven("silk", "satin:5:2", 1024)
    repeat = mi.ScalarTransform4f().scale([REPEATS, REPEATS, 1])
    color = {
        "type": "bitmap", "bitmap": mi.Bitmap(np.ascontiguousarray(channels["base_color"])),
        "raw": True, "filter_type": "nearest", "to_uv": repeat,
    }  # fmt: skip
    gray = {"type": "rgb", "value": float(channels["base_color"].mean())}

    def two_sided(**inside: Any) -> dict[str, Any]:
        return {"type": "twosided", "inside": inside}

    made = {
        "diffuse": two_sided(type="diffuse", reflectance=gray),
        PLAIN: two_sided(type="diffuse", reflectance=color),
        "roughconductor": two_sided(type="roughconductor", alpha=ROUGHNESS**2),
        "principled": two_sided(type="principled", base_color=color, roughness=ROUGHNESS),
        "cloth": cloth_bsdf_dict(channels, inputs, (REPEATS, REPEATS), dtype=np.float16),
        "cloth, float32": cloth_bsdf_dict(channels, inputs, (REPEATS, REPEATS)),
    }
    return {name: bsdf for name, bsdf in made.items() if not names or name in names}


def seconds(scenes: dict[str, Any], spp: int, runs: int) -> dict[str, np.ndarray]:
    """Return the processor seconds of every run of each scene, taken in turns, kernels compiled."""
    times: dict[str, list[float]] = {name: [] for name in scenes}
    for run in range(-1, runs):
        for name, scene in scenes.items():
            start = time.process_time()
            dr.eval(mi.render(scene, spp=spp, seed=run + 1))
            dr.sync_thread()
            if run >= 0:
                times[name].append(time.process_time() - start)
    return {name: np.array(found) for name, found in times.items()}


def cost(make: Callable[..., Any], title: str, runs: int) -> None:
    """Print what a picture of 256² with 8 samples costs with each material."""
    found = seconds({k: make(bsdf, 256) for k, bsdf in materials().items()}, 8, runs)
    print(f"\n{title}, 256², 8 samples: least time, ratios of the median run")
    print(f"{'material':>20}{'ms':>8}{'× diffuse':>12}{'× textured':>12}")
    for name, times in found.items():
        ratios = (np.median(times / found[other]) for other in ("diffuse", PLAIN))
        columns = "".join(f"{ratio:>12.2f}" for ratio in ratios)
        print(f"{name:>20}{times.min() * 1e3:>8.0f}{columns}", flush=True)


def thesis_table(sizes: tuple[int, ...], samples: tuple[int, ...]) -> None:
    """Print the rows of the thesis's table 6.1: the box with cloth over the same with diffuse."""
    print(f"\nCornell box, {2 * CELLS**2} triangles of cloth; the thesis has 1.18")
    print(f"{'picture':>10}{'samples':>9}{'diffuse, s':>12}{'cloth, s':>10}{'ratio':>8}")
    bsdfs = materials(("diffuse", "cloth"))
    for size in sizes:
        scenes = {name: cornell_box(bsdf, size) for name, bsdf in bsdfs.items()}
        for spp in samples:
            # In passes, so that whatever else the machine does meets both alike.
            passes = max(1, spp * size * size // PASS)
            diffuse, cloth = (t.sum() for t in seconds(scenes, spp // passes, passes).values())
            row = f"{diffuse:>12.1f}{cloth:>10.1f}{cloth / diffuse:>8.2f}"
            print(f"{size:>9}²{spp:>9}{row}", flush=True)


# --- Noise ---------------------------------------------------------------------------------------


def dome(_: Any, __: int) -> Any:
    """Return the radiance of a white sky."""
    return mi.Float(1)


def studio(w: Any, turn: int) -> Any:
    """Return the radiance of a gray room with three soft boxes, turned by quarters of a circle."""
    for _ in range(turn):
        w = mi.Vector3f(-w.y, w.x, w.z)
    radiance = mi.Float(SKY)
    for axis, half_angle in (((0.5, 0.3, 0.8), 14), ((-0.7, 0.5, 0.4), 10), ((0.2, -0.9, 0.3), 18)):
        box = dr.normalize(mi.Vector3f(*axis))
        radiance = dr.select(dr.dot(w, box) > np.cos(np.radians(half_angle)), BOX, radiance)
    return radiance


def by_cosine(yarn: Any, fibre: Any, choice: Any, point: Any) -> tuple[Any, Any]:
    """Return a direction by cosine sampling about the yarn's normal, and its density."""
    share = sampling.shares(yarn, fibre)
    across = share.cosine_across + share.volume_across
    w = mi.warp.square_to_cosine_hemisphere(point)
    height = dr.select(choice < across, -w.z, w.z)
    wo = fibre.n * height + fibre.b * w.x + fibre.t * w.y
    return wo, w.z / np.pi * dr.select(choice < across, across, 1 - across)


def by_lobes(yarn: Any, fibre: Any, choice: Any, point: Any) -> tuple[Any, Any]:
    """Return a direction by the cloth's own sampling, and its density."""
    direction = sampling.sample(yarn, fibre, choice, point)
    return fibre.vector(direction), sampling.density(yarn, fibre, direction)


def moments(cloth: Any, si: Any, draw: Callable[..., Any], seed: int) -> dict[str, Any]:
    """Return mean and variance of one sample at every view (VIEWS,), under each light."""
    count = dr.width(si)
    rng = mi.PCG32(size=count, initstate=seed)
    choice, point = rng.next_float32(), mi.Point2f(rng.next_float32(), rng.next_float32())
    yarn, normal, tangent = cloth.yarn(si, cloth.texel(si, True), True)
    wo, density = draw(yarn, lobes.fibre(si.wi, normal, tangent), choice, point)
    value = dr.mean(cloth.eval_pdf(mi.BSDFContext(), si, wo, True)[0])
    weight = dr.select(density > 0, value / dr.maximum(density, 1e-20), 0)
    found = {}
    for light in (dome, studio):
        turns = [
            np.array(weight * light(wo, turn), np.float64).reshape(-1, SAMPLES)
            for turn in range(TURNS[light.__name__])
        ]
        mean, var = ([f(radiance) for radiance in turns] for f in (_mean, _variance))
        found[light.__name__] = np.mean(mean, 0), np.mean(var, 0)
    return found


def _mean(samples: np.ndarray) -> np.ndarray:
    return samples.mean(axis=1)


def _variance(samples: np.ndarray) -> np.ndarray:
    return samples.var(axis=1, ddof=1)


def views(seed: int) -> Any:
    """Return interactions all over a cloth, seen as the parts of a sphere are: SAMPLES of each."""
    rng = np.random.default_rng(seed)
    si = dr.zeros(mi.SurfaceInteraction3f, VIEWS * SAMPLES)
    chosen = np.repeat(rng.random((4, VIEWS)).astype(np.float32), SAMPLES, axis=1)
    si.wi = mi.warp.square_to_cosine_hemisphere(mi.Point2f(chosen[:2]))
    si.uv = mi.Point2f(chosen[2:])
    si.sh_frame = mi.Frame3f(mi.Vector3f(0, 0, 1))
    si.sh_frame.s, si.sh_frame.t = mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0)
    si.dp_du, si.dp_dv = mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0)
    return si


def cloths() -> Iterator[tuple[Any, list[str]]]:
    """Yield each preset's cloth and the names of its yarns, optics met before left out."""
    met = set()
    for preset in preset_names():
        recipe = read_preset(preset)
        if {y.optics for y in recipe.yarns} <= met:
            continue
        met |= {y.optics for y in recipe.yarns}
        channels, inputs, names = woven(preset, recipe.weave or "plain", 256)
        props = cloth_bsdf_dict(channels, inputs, (1.0, 1.0))
        yield Cloth(props["packed"], props["optics"], (1.0, 1.0), False), names


def noise() -> bool:
    """Print the variance of our sampling over that of cosine sampling; return if means agree."""
    lights = (dome.__name__, studio.__name__)
    print("\nvariance of a sample over that of cosine sampling: of all views / of the median view")
    print(f"{'yarn':>26}" + "".join(f"{light:>16}" for light in lights) + "   albedo  deviation")
    agree = True
    for cloth, names in cloths():
        si = views(1)
        ours, cosine = (moments(cloth, si, draw, 2) for draw in (by_lobes, by_cosine))
        index = np.array(cloth.texel(si, True)[-1])[::SAMPLES]
        for number, name in enumerate(names):
            chosen = index == number
            if not chosen.any():
                continue
            line = ""
            for light in lights:
                (mean, var), (mean_c, var_c) = (m[light] for m in (ours, cosine))
                # The mean over views settles as their variances say.
                error = np.sqrt(np.sum((var + var_c)[chosen]) / SAMPLES)
                agree &= bool(abs(np.sum((mean - mean_c)[chosen])) < 5 * error)
                ratio = np.sum(var[chosen]) / np.sum(var_c[chosen])
                lit = chosen & (var_c > 0)
                line += f"{ratio:>9.2f} /{np.median(var[lit] / var_c[lit]):>5.2f}"
                loud = ratio > (1 / 3 if name in FLAT and light == "dome" else 1)
                line += " !" if loud else "  "
            mean, var = ours["dome"]
            albedo = mean[chosen].mean()
            line += f"{albedo:>9.2f}{np.sqrt(var[chosen].mean()) / albedo:>9.2f}"
            print(f"{name:>26}{line}", flush=True)
    return agree


def main() -> int:
    """Print the tables; return 1 when two samplers disagree."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--full", action="store_true", help="the thesis's sizes and more runs")
    full = parser.parse_args().full
    agree = noise()
    cost(under_a_dome, "drape under a dome, one bounce", 25 if full else 11)
    cost(cornell_box, "drape in a Cornell box", 15 if full else 5)
    thesis_table((512, 1024) if full else (512,), (32, 256) if full else (32,))
    if not agree:
        print("the samplers disagree on the mean", file=sys.stderr)
    return 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main())
