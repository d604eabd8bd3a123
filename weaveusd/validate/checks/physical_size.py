"""Whether the textures have the size on the cloth that the attributes state."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from pxr import Gf, UsdShade

from weaveusd.contract import SHADER_UV_SCALE
from weaveusd.validate.checks.shader import input_value
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

SCALE = Code("uv-scale", Status.FAIL, "The texture scale is not one repeat of the cloth.")
SETT = Code("sett-disagrees", Status.FAIL, "Threads, sett and size of the repeat disagree.")

MM_PER_METER = 1000.0
MM_PER_CM = 10.0
TOLERANCE = 1e-5


@check(
    id="shader/physical-size",
    why="Texture coordinates are metres of cloth: a wrong scale is cloth of another sett.",
    needs=("material", "shader"),
    codes=(SCALE, SETT),
)
def physical_size(asset: OpenAsset) -> Iterator[Finding]:
    """The texture scale is one repeat, and the repeat holds its threads at the sett."""
    repeat = asset.cloth("repeatWidth"), asset.cloth("repeatHeight")
    if not all(isinstance(size, float) and size > 0 for size in repeat):
        return
    expected = [MM_PER_METER / size for size in repeat]
    interface = UsdShade.Material(asset.material).GetInput(SHADER_UV_SCALE)
    places = {
        f"{asset.shader.GetPath()}.inputs:{SHADER_UV_SCALE}": input_value(
            asset.shader, SHADER_UV_SCALE
        ),
        f"{asset.material.GetPath()}.inputs:{SHADER_UV_SCALE}": interface and interface.Get(),
    }
    for where, value in places.items():
        if value is None:
            continue
        if not isinstance(value, (Gf.Vec2f, Gf.Vec2d)) or not _close(value, expected):
            yield SCALE(f"is {value}, expected ({expected[0]:g}, {expected[1]:g})", where)

    for threads, sett, size in (
        ("ends", "endsPerCm", "repeatWidth"),
        ("picks", "picksPerCm", "repeatHeight"),
    ):
        count, density = asset.cloth(threads), asset.cloth(sett)
        if (
            count
            and density
            and asset.cloth(size)
            and not _close([MM_PER_CM * count / density], [asset.cloth(size)])
        ):
            yield SETT(
                f"{count} {threads} at {density:g}/cm make {MM_PER_CM * count / density:g} mm, "
                f"but weave:{size} is {asset.cloth(size):g}",
                str(asset.material.GetPath()),
            )


def _close(values: Iterable[float], expected: list[float]) -> bool:
    return all(
        math.isclose(number, target, rel_tol=TOLERANCE)
        for number, target in zip(values, expected, strict=True)
    )
