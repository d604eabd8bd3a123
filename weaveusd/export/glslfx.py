"""The cloth shader for Storm as a glslfx file: ours, anisotropic, with the optics of each yarn."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from weaveusd.contract import SHADER_YARN_ARRAYS
from weaveusd.stage import schema_dir

FIRST_OPTICS = ("eta", "k_d", "k_s", "gamma_s")
SECOND_OPTICS = ("gamma_v", "tau", "normalization", "albedo_gain")
"""The optics of a yarn, as the two vectors that the shader asks for."""

GLSLFX_INPUTS: dict[str, tuple[str, list[float]]] = {
    "base_color": ("vec3", [0.5, 0.5, 0.5]),
    "normal": ("vec3", [0.0, 0.0, 1.0]),
    "fibre": ("vec3", [0.0, 1.0, 0.0]),
    "opacity": ("float", [1.0]),
    "yarn_id": ("float", [0.0]),
    "st": ("vec2", [0.0, 0.0]),
}
"""Inputs of the shader: type in GLSL and value where nothing is connected."""

_HELPERS = "$TOOLS/hdSt/shaders/surfaceHelpers.glslfx"


def glslfx_text(optics: Mapping[str, Sequence[float]]) -> str:
    """Return the glslfx file of a cloth whose yarns have the given `optics`, by yarn id.

    `optics` holds a value for each yarn under each name of `contract.SHADER_YARN_ARRAYS`. The
    shader reads the optics by yarn id, since Storm hands arrays to no shader; its BSDF is the
    source that the MaterialX node includes.

    Raises
    ------
    ValueError
        `optics` lacks an input.
    """
    if set(optics) != set(SHADER_YARN_ARRAYS):
        raise ValueError(f"expected the optics {sorted(SHADER_YARN_ARRAYS)}, got {sorted(optics)}")
    sections = {
        "Weaveusd.Yarns": _lookup("first", FIRST_OPTICS, optics)
        + "\n"
        + _lookup("second", SECOND_OPTICS, optics),
        "Weaveusd.Cloth": _source("materialx/weaveusd_cloth.glsl"),
        "Weaveusd.Surface": _source("glslfx/weaveusd_cloth_surface.glsl"),
    }
    configuration: dict[str, Any] = {
        # Gaps are cut out, so that cloth needs no sorting.
        "metadata": {"materialTag": "masked"},
        "parameters": {
            name: {"type": kind, "default": value if len(value) > 1 else value[0]}
            for name, (kind, value) in GLSLFX_INPUTS.items()
        },
        "techniques": {
            "default": {
                "surfaceShader": {"source": ["SurfaceHelpers.TangentSpace", *sections]},
            }
        },
    }
    parts = ["-- glslfx version 0.1", f"#import {_HELPERS}", "-- configuration"]
    parts.append(json.dumps(configuration, indent=4))
    for name, text in sections.items():
        parts += [f"-- glsl {name}", text]
    return "\n\n".join(part.strip("\n") for part in parts) + "\n"


def _lookup(name: str, inputs: Sequence[str], optics: Mapping[str, Sequence[float]]) -> str:
    """Return a function from the yarn id to four optics; gaps get those of the first yarn."""
    rows = [f"vec4({', '.join(_number(optics[i][k]) for i in inputs)})" for k in _yarns(optics)]
    lines = [f"// {', '.join(inputs)} of the yarn with this id, which counts from 1."]
    lines += [f"vec4 weaveusd_{name}_optics(int yarn)", "{"]
    for index, row in enumerate(rows):
        if row != rows[0]:
            lines.append(f"    if (yarn == {index + 1}) {{ return {row}; }}")
    return "\n".join([*lines, f"    return {rows[0]};", "}", ""])


def _yarns(optics: Mapping[str, Sequence[float]]) -> range:
    return range(len(optics["eta"]))


def _number(value: float) -> str:
    text = f"{value:.9g}"
    return text if any(mark in text for mark in ".en") else f"{text}.0"


def _source(name: str) -> str:
    return (schema_dir() / name).read_text(encoding="utf-8")
