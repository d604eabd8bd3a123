"""What copies cost: written out into one mesh, and as instances of Mitsuba's.

Both make the same scenes from the same stage, and their pictures are compared. Times are those of
the process, first picture and compilation included; every count is a scene never compiled before.

    .venv/bin/python benchmarks/copies.py
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

from weaveusd.stage import require

COUNTS = (4, 16, 48, 96)
SIZE, SPP = 32, 64


def main() -> None:
    """Print one row for each number of copies."""
    from weaveusd.render.variant import prepare

    require()
    print(f"variant {prepare(None)}, {SIZE} x {SIZE} pixels, {SPP} samples")
    print(f"{'copies':>8} {'written out':>12} {'instances':>12} {'ratio':>7} {'difference':>11}")

    from weaveusd.render import assembly

    usual = assembly.MAX_PRIMITIVES
    with tempfile.TemporaryDirectory() as folder:
        picture(Path(folder), 2)  # what every first picture of a process costs
        for count in COUNTS:
            flat, first = picture(Path(folder), count)
            assembly.MAX_PRIMITIVES = 0
            shared, second = picture(Path(folder), count)
            assembly.MAX_PRIMITIVES = usual
            apart = float(np.abs(flat - shared).mean())
            if apart > 0.02:
                raise SystemExit(f"{count} copies: the pictures differ by {apart:.3f}")
            times = f"{first:>10.2f} s {second:>10.2f} s {second / first:>7.1f}"
            print(f"{count:>8} {times} {apart:>11.4f}")


def picture(folder: Path, count: int) -> tuple[np.ndarray, float]:
    """Return the picture of `count` copies of a cube, and the seconds it took."""
    from pxr import Gf, Usd, UsdGeom, UsdLux

    from weaveusd.render.trace import trace
    from weaveusd.render.translate import translate

    stage = Usd.Stage.CreateNew(str(folder / f"{count}-{time.time_ns()}.usda"))
    crowd = UsdGeom.PointInstancer.Define(stage, "/Crowd")
    UsdGeom.Cube.Define(stage, "/Crowd/Cube")
    crowd.CreatePrototypesRel().SetTargets(["/Crowd/Cube"])
    crowd.CreateProtoIndicesAttr([0] * count)
    places = np.random.default_rng(count).uniform(-20, 20, (count, 3))
    crowd.CreatePositionsAttr([Gf.Vec3f(*map(float, place)) for place in places])
    UsdLux.DomeLight.Define(stage, "/Dome")
    begin = time.process_time()
    scene = translate(stage, width=SIZE, height=SIZE).scene
    image = trace(scene, (SIZE, SIZE), SPP, seed=1)
    return image, time.process_time() - begin


if __name__ == "__main__":
    main()
