"""Writing USD layers: prims, attributes, shaders and connections, without opening a stage.

Layers are authored directly because a stage makes USD fix its list of schemas; whoever publishes
an asset may still want to register ours and open it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pxr import Gf, Sdf, Vt

_CASTS: dict[str, Any] = {
    "asset": Sdf.AssetPath,
    "asset[]": lambda value: Sdf.AssetPathArray([Sdf.AssetPath(path) for path in value]),
    "color3f": lambda value: Gf.Vec3f(*value),
    "float2": lambda value: Gf.Vec2f(*value),
    "float4": lambda value: Gf.Vec4f(*value),
    "float[]": Vt.FloatArray,
    "int[]": Vt.IntArray,
    "token[]": Vt.TokenArray,
}


def define_prim(parent: Sdf.Layer | Sdf.PrimSpec, name: str, kind: str) -> Sdf.PrimSpec:
    """Define the prim `name` of type `kind` below `parent` and return its spec."""
    return Sdf.PrimSpec(parent, name, Sdf.SpecifierDef, kind)


def apply_schemas(prim: Sdf.PrimSpec, schemas: Sequence[str]) -> None:
    """Apply API schemas to `prim`, by name: they need not be registered."""
    prim.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=list(schemas)))


def author(
    prim: Sdf.PrimSpec, name: str, kind: str, value: object, *, uniform: bool = False
) -> Sdf.AttributeSpec:
    """Author an attribute of the Sdf type named `kind` on `prim` and return its spec."""
    spec = _attribute(prim, name, kind, uniform)
    spec.default = _CASTS[kind](value) if kind in _CASTS else value
    return spec


def connect(prim: Sdf.PrimSpec, name: str, kind: str, source: Sdf.Path) -> None:
    """Author an attribute on `prim` that takes its value from `source`."""
    _attribute(prim, name, kind, False).connectionPathList.explicitItems = [source]


def define_shader(
    material: Sdf.PrimSpec,
    name: str,
    identifier: str,
    inputs: Mapping[str, tuple[str, object]],
    output: tuple[str, str],
) -> Sdf.Path:
    """Define a shader below `material` and return the path of its output.

    Parameters
    ----------
    material
        Spec of the material.
    name, identifier
        Name of the prim, and of the shader in `info:id`.
    inputs
        (type, value) by name; a value that is an `Sdf.Path` becomes a connection.
    output
        Name and type of the output.
    """
    shader = define_prim(material, name, "Shader")
    author(shader, "info:id", "token", identifier, uniform=True)
    for key, (kind, value) in inputs.items():
        if isinstance(value, Sdf.Path):
            connect(shader, f"inputs:{key}", kind, value)
        else:
            author(shader, f"inputs:{key}", kind, value)
    out = _attribute(shader, f"outputs:{output[0]}", output[1], False)
    path: Sdf.Path = out.path
    return path


def interface_input(material: Sdf.PrimSpec, name: str) -> Sdf.Path:
    """Return the path of the public input `name` of `material`.

    Raises
    ------
    ValueError
        The material has no such input.
    """
    key = f"inputs:{name}"
    if key not in material.attributes:
        raise ValueError(f"{material.path} has no {key} to connect to")
    path: Sdf.Path = material.attributes[key].path
    return path


def _attribute(prim: Sdf.PrimSpec, name: str, kind: str, uniform: bool) -> Sdf.AttributeSpec:
    variability = Sdf.VariabilityUniform if uniform else Sdf.VariabilityVarying
    return Sdf.AttributeSpec(prim, name, Sdf.ValueTypeNames.Find(kind), variability)
