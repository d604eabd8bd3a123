"""The exact network: one shader with the textures and the optics of every yarn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from weaveusd.contract import (
    CLOTH_SHADER_ID,
    MITSUBA_CONTEXT,
    SHADER_FILES,
    SHADER_UV_SCALE,
    SHADER_VARNAME,
    SHADER_YARN_ARRAYS,
    kinds_input,
    moment_input,
    section_input,
)
from weaveusd.export.attributes import tidy
from weaveusd.export.files import CLOTH_ITSELF
from weaveusd.export.layers import connect, define_shader, interface_input

if TYPE_CHECKING:
    from pxr import Sdf

    from weaveusd.contract import ColorSpace
    from weaveusd.export.files import LookFiles
    from weaveusd.export.moments import SystemMaps
    from weaveusd.shading.material import ClothMaterial


def define_mitsuba_network(
    material: Sdf.PrimSpec,
    optics: Mapping[str, Sequence[float]],
    moments: Sequence[SystemMaps],
    color_space: ColorSpace = "lin_rec709",
    files: LookFiles = CLOTH_ITSELF,
) -> None:
    """Define the exact cloth shader on `outputs:mitsuba:surface` of `material`.

    `optics` holds a value for each yarn under each name of `contract.SHADER_YARN_ARRAYS`.
    `moments` tells of the moment maps of each system. The inputs of the base color and of the
    maps of albedo state `color_space`, unless it is Rec.709, which is meant where none is stated.

    Raises
    ------
    ValueError
        `material` lacks the public inputs of texture coordinates, or `optics` an input.
    """
    if set(optics) != set(SHADER_YARN_ARRAYS):
        raise ValueError(f"expected the optics {sorted(SHADER_YARN_ARRAYS)}, got {sorted(optics)}")
    if len({len(values) for values in optics.values()}) != 1:
        raise ValueError("expected as many values of every optic as there are yarns")
    inputs: dict[str, tuple[str, object]] = {
        SHADER_UV_SCALE: ("float2", interface_input(material, SHADER_UV_SCALE)),
        SHADER_VARNAME: ("string", interface_input(material, SHADER_VARNAME)),
    }
    for name, file in SHADER_FILES.items():
        inputs[name] = ("asset", files.anchored(file))
    for name in SHADER_YARN_ARRAYS:
        inputs[name] = ("float[]", [tidy(value) for value in optics[name]])
    for maps in moments:
        for name, file in zip(maps.names, maps.files, strict=True):
            inputs[moment_input(maps.system, name)] = ("asset", files.anchored(file))
        section = tidy(maps.flatness), tidy(maps.curvature)
        inputs[section_input(maps.system)] = ("float2", section)
        inputs[kinds_input(maps.system)] = ("int[]", maps.kinds)
    surface = define_shader(
        material, "MitsubaSurface", CLOTH_SHADER_ID, inputs, ("surface", "token")
    )
    if color_space != "lin_rec709":
        for name in ("base_color_file", *(moment_input(m.system, "albedo") for m in moments)):
            color = surface.GetPrimPath().AppendProperty(f"inputs:{name}")
            material.layer.GetAttributeAtPath(color).colorSpace = color_space
    connect(material, f"outputs:{MITSUBA_CONTEXT}:surface", "token", surface)


def optics_of(material: ClothMaterial) -> dict[str, tuple[float, ...]]:
    """Return the values of `contract.SHADER_YARN_ARRAYS`, in the order of the yarn ids."""
    yarns = material.weave.yarns
    return {
        "eta": tuple(yarn.optics.eta for yarn in yarns),
        "k_d": tuple(yarn.optics.k_d for yarn in yarns),
        "k_s": tuple(yarn.optics.k_s for yarn in yarns),
        "gamma_s": tuple(yarn.optics.gamma_s for yarn in yarns),
        "gamma_v": tuple(yarn.optics.gamma_v for yarn in yarns),
        "tau": tuple(yarn.optics.tau for yarn in yarns),
        "normalization": material.normalization,
        "albedo_gain": tuple(yarn.gain for yarn in material.measured),
    }
