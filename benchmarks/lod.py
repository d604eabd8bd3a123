"""Cloth from 0.3 to 30 m: `--lod auto` against all texels, error, noise, cost and moiré.

    python benchmarks/lod.py [--spp 2048] [--figure docs/figures/lod_distances.png]

A drape of shot silk, published as an asset, is rendered with pixels of 0.9 mrad (a lens of 40° on
768 pixels) at five distances: 16 samples a pixel of `auto` and of `full` against `--spp` of `full`.
A flat sheet that recedes to the horizon is looked at for moiré: the spectrum of what a picture
differs by from the reference has no line that noise has not. Costs are processor times, the least
of several turns of both. The exit status is 1 when a goal is missed.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import flip_evaluator
import numpy as np

from weaveusd import pipeline
from weaveusd.render import variant

variant.prepare(variant.LLVM)

import mitsuba as mi  # noqa: E402
from pxr import Usd, UsdShade  # noqa: E402

from weaveusd.contract import CLOTH_SHADER_ID  # noqa: E402
from weaveusd.export.images import write_png8  # noqa: E402
from weaveusd.render.cloth import translate  # noqa: E402
from weaveusd.render.distance_cloth import seen_by, with_view  # noqa: E402
from weaveusd.render.model import Losses  # noqa: E402
from weaveusd.render.textures import to_srgb  # noqa: E402
from weaveusd.render.trace import trace  # noqa: E402
from weaveusd.stage import open_stage  # noqa: E402

DRAFT = Path(__file__).parents[1] / "examples" / "drafts" / "twill_2_2.wif"
PRESET = "shot_silk"
DISTANCES_M = (0.3, 1.0, 3.0, 10.0, 30.0)
PIXEL = 0.9e-3
"""Radians that a pixel sees."""

SIDE = 96
FEW = 16
TRIALS = 4
COST_SPP, COST_TURNS = 144, 8
WORST_MEAN, FEWER_SAMPLES, MOST_COST = 0.03, 8.0, 1.1
GOALS_AT = 10.0
MOIRE = float(np.log(SIDE * SIDE / 2 / 0.01))
"""A line of noise is as strong as this, over the mean, in one spectrum of a hundred."""

CELLS = 160
DRAPE_M, SHEET_M = 0.6, 400.0


def cloth(entry: Path, *, levels: bool) -> dict[str, Any]:
    """Return the published cloth's BSDF, st in metres."""
    stage = open_stage(entry)
    for prim in stage.Traverse():
        shader = UsdShade.Shader(prim)
        if shader and shader.GetIdAttr().Get() == CLOTH_SHADER_ID:
            return translate(shader, Usd.TimeCode.Default(), Losses(), levels=levels)[0]
    raise SystemExit(f"{entry}: no cloth")


def mesh(bsdf: dict[str, Any], side_m: float, cells: int, depth: float) -> Any:
    """Return a square cloth about the origin, y up, with folds of a depth, st in metres."""
    grid = np.linspace(-0.5, 0.5, cells + 1)
    x, z = np.meshgrid(grid, grid)
    y = depth * (np.exp(-12 * (x * x + z * z)) + 0.2 * np.sin(28 * x + 8 * z) * np.cos(20 * z))
    corner = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = (corner[i : i + cells, j : j + cells] for i in (0, 1) for j in (0, 1))
    faces = np.stack((a, d, b, a, c, d), -1).reshape(-1, 3)
    props = mi.Properties()
    props["mesh_bsdf"] = mi.load_dict(bsdf, parallel=False)
    made = mi.Mesh(
        "cloth", x.size, len(faces), props=props,
        has_vertex_normals=True, has_vertex_texcoords=True,
    )  # fmt: skip
    parameters = mi.traverse(made)
    parameters["vertex_positions"] = (np.stack((x, y, z), -1) * side_m).ravel()
    parameters["vertex_texcoords"] = (np.stack((x, -z), -1) * side_m).ravel()
    parameters["faces"] = faces.astype(np.uint32).ravel()
    parameters.update()
    made.recompute_vertex_normals()
    return made


def sensor(eye: tuple[float, float, float], target: tuple[float, float, float]) -> dict[str, Any]:
    """Return a camera with pixels of `PIXEL` radians."""
    return {
        "type": "perspective",
        "fov": float(np.degrees(2 * np.arctan(PIXEL * SIDE / 2))),
        "near_clip": 0.01,
        "far_clip": 1e4,
        "to_world": mi.ScalarTransform4f().look_at(list(eye), list(target), [0, 1, 0]),
        "film": {
            "type": "hdrfilm", "width": SIDE, "height": SIDE,
            "rfilter": {"type": "box"}, "component_format": "float32",
        },
    }  # fmt: skip


def scene(
    bsdf: dict[str, Any], eye: dict[str, Any], side_m: float, depth: float, sky: bool = True
) -> Any:
    """Return a cloth under a lamp of 3° far away, and a dim sky."""
    seen = with_view(bsdf, seen_by(mi.load_dict(eye, parallel=False)))
    lamp = np.array((0.5, 0.8, 0.35)) / np.linalg.norm((0.5, 0.8, 0.35)) * 2000
    return mi.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 3},
        "sensor": eye,
        **({"sky": {"type": "constant", "radiance": 0.25}} if sky else {}),
        "lamp": {"type": "sphere", "center": lamp.tolist(), "radius": 52.0,
                 "emitter": {"type": "area", "radiance": 1200.0}},
        "cloth": mesh(seen, side_m, CELLS, depth),
    }, parallel=False)  # fmt: skip


def at_distance(bsdf: dict[str, Any], metres: float, sky: bool = True) -> Any:
    """Return the drape seen from so far, 40° above its plane."""
    x, y, z = np.array((0.25, np.sin(0.7), np.cos(0.7))) * metres / np.linalg.norm((0.25, 1.0))
    return scene(bsdf, sensor((x, y + 0.06, z), (0, 0.06, 0)), DRAPE_M, 0.2, sky)


def receding(bsdf: dict[str, Any]) -> Any:
    """Return a sheet that fills the picture's lower part up to the horizon."""
    return scene(bsdf, sensor((0.0, 0.05, 0.0), (0.13, 0.038, -1.0)), SHEET_M, 0.0)


def averaged(of: Any, spp: int, seed: int) -> np.ndarray:
    """Return a picture in double precision."""
    return np.asarray(trace(of, (SIDE, SIDE), spp, seed), np.float64)


def rel_mse(picture: np.ndarray, reference: np.ndarray) -> float:
    """Return the mean of the squared error over the squared reference, 1 % of its mean added."""
    return float(
        np.mean((picture - reference) ** 2 / (reference**2 + 0.01 * reference.mean() ** 2))
    )


def flip(picture: np.ndarray, reference: np.ndarray) -> float:
    """Return the mean LDR FLIP of the pictures as shown, 0 for equal ones."""
    shown = (np.ascontiguousarray(display(p), np.float32) for p in (reference, picture))
    return float(flip_evaluator.evaluate(*shown, "LDR", False, True)[1])


def display(picture: np.ndarray) -> np.ndarray:
    """Return sRGB values 0…1, a little exposed down."""
    return to_srgb((picture * 0.6).astype(np.float32))


def peak(difference: np.ndarray) -> float:
    """Return the strongest line of the spectrum over its mean, each frequency ring apart."""
    window = np.hanning(SIDE)[:, None] * np.hanning(SIDE)[None, :]
    power = np.abs(np.fft.fft2(difference.mean(-1) * window)) ** 2
    ring = np.hypot(*np.meshgrid(*[np.fft.fftfreq(SIDE)] * 2)).round(2)
    means = np.array([power[ring == r].mean() for r in np.unique(ring)])
    return float((power / means[np.searchsorted(np.unique(ring), ring)])[ring > 0.03].max())


def cost(full: Any, auto: Any) -> float:
    """Return the processor time of auto over that of full, the least of turns of both."""
    least = [float("inf")] * 2
    for turn in range(COST_TURNS + 1):
        for k, of in enumerate((full, auto)):
            begin = time.process_time()
            trace(of, (SIDE, SIDE), COST_SPP, turn)
            spent = time.process_time() - begin
            if turn:  # the first compiles
                least[k] = min(least[k], spent)
    return least[1] / least[0]


def judged(what: str, found: float, limit: float, *, at_least: bool = False) -> bool:
    """Print whether a goal is met, and return it."""
    met = found >= limit if at_least else found <= limit
    sign = "at least" if at_least else "at most"
    print(f"{what}: {found:.3g}, goal {sign} {limit:g}: {'met' if met else 'MISSED'}")
    return met


def main() -> int:
    """Print the tables, and write the figure where one is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--spp", type=int, default=2048, help="samples a pixel of references")
    parser.add_argument("--figure", type=Path, help="PNG to write the pictures to")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as root:
        done = pipeline.publish(DRAFT, preset=PRESET, root=root)
        bsdfs = [cloth(Path(done.asset.entry), levels=levels) for levels in (False, True)]
    print(f"{'distance':>9} {'mean':>7} {'relMSE full':>12} {'auto':>8} {'auto, all':>10}"
          f" {'FLIP full':>10} {'auto':>7} {'fewer samples':>14} {'cost':>6}")  # fmt: skip
    columns, worst, costs, saved = [], 0.0, {}, {}
    for metres, sky in (*((metres, True) for metres in DISTANCES_M), (10.0, False)):
        full, auto = (at_distance(bsdf, metres, sky) for bsdf in bsdfs)
        reference = averaged(full, asked.spp, 1)
        converged = averaged(auto, asked.spp, 2)
        few = [[averaged(of, FEW, 10 + k) for k in range(TRIALS)] for of in (full, auto)]
        errors = [float(np.mean([rel_mse(p, reference) for p in pictures])) for pictures in few]
        flips = [float(np.mean([flip(p, reference) for p in pictures])) for pictures in few]
        mean = converged.mean() / reference.mean() - 1
        worst = max(worst, abs(mean))
        costs[metres, sky], saved[metres, sky] = cost(full, auto), errors[0] / errors[1]
        where = f"{metres:5.1f} m{' ' if sky else '*'}"
        print(f"{where:>9} {mean:+7.3f} {errors[0]:12.4f} {errors[1]:8.4f}"
              f" {rel_mse(converged, reference):10.5f} {flips[0]:10.4f} {flips[1]:7.4f}"
              f" {saved[metres, sky]:14.1f} {costs[metres, sky]:6.2f}", flush=True)  # fmt: skip
        if sky:
            columns.append(np.concatenate([few[0][0], few[1][0], reference]))
    print("* under the lamp alone")
    full, auto = (receding(bsdf) for bsdf in bsdfs)
    reference = averaged(full, asked.spp, 1)
    sheets = (averaged(full, FEW, 7), averaged(auto, FEW, 7), averaged(auto, asked.spp, 9))
    lines = [peak(sheet - reference) for sheet in sheets]
    errors = [rel_mse(sheet, reference) for sheet in sheets]
    for name, line, error in zip(("full", "auto", "auto, all"), lines, errors, strict=True):
        print(f"receding sheet, {name}: strongest line over its ring's mean {line:.1f}, "
              f"relMSE {error:.5f}")  # fmt: skip
    if asked.figure:
        strip = np.concatenate(columns, axis=1).repeat(2, 0).repeat(2, 1)
        write_png8(asked.figure, np.rint(display(strip) * 255).astype(np.uint8))
    goals = [
        judged("difference of the mean, largest", worst, WORST_MEAN),
        judged(f"fewer samples at {GOALS_AT:g} m", saved[GOALS_AT, True], FEWER_SAMPLES,
               at_least=True),
        judged("cost of a sample, largest", max(costs.values()), MOST_COST),
        judged("strongest line of auto over its ring's mean", max(lines[1:]), MOIRE),
    ]  # fmt: skip
    return int(not all(goals))


if __name__ == "__main__":
    sys.exit(main())
