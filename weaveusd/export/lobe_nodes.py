"""The nodes of MaterialX that make anisotropy and a tangent of the lobe maps' rotation.

A table, since the stage and the document have the same nodes and each writes them its own way.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Node:
    """A node: its name, category and type as in ``ND_<category>_<kind>``, type of its output.

    `inputs` are a type of MaterialX and a value by name. The value is the name of another node,
    whose output it takes, unless it is a number or of type ``string``.
    """

    name: str
    category: str
    kind: str
    output: str
    inputs: dict[str, tuple[str, str | float | int]]


# p = (α_t − α_b) / (α_t + α_b) is the rotation's length, and 1 − α_b/α_t = 2 p / (1 + p). Where a
# renderer has averaged directions that differ, the rotation is short and the lobe round.
ANISOTROPY: tuple[Node, ...] = (
    Node("stretch", "magnitude", "vector2", "float", {"in": ("vector2", "rotation")}),
    Node("stretch_twice", "multiply", "float", "float",
         {"in1": ("float", "stretch"), "in2": ("float", 2.0)}),
    Node("stretch_more", "add", "float", "float",
         {"in1": ("float", "stretch"), "in2": ("float", 1.0)}),
    Node("anisotropy", "divide", "float", "float",
         {"in1": ("float", "stretch_twice"), "in2": ("float", "stretch_more")}),
)  # fmt: skip
"""From ``rotation`` to ``anisotropy``, that of OpenPBR."""

# X laid into the plane of the normal, turned by φ; the map holds 2φ, as φ itself wraps.
ACROSS: tuple[Node, ...] = (
    Node("rotation_x", "extract", "vector2", "float",
         {"in": ("vector2", "rotation"), "index": ("integer", 0)}),
    Node("rotation_y", "extract", "vector2", "float",
         {"in": ("vector2", "rotation"), "index": ("integer", 1)}),
    Node("angle_twice", "atan2", "float", "float",
         {"iny": ("float", "rotation_y"), "inx": ("float", "rotation_x")}),
    Node("angle", "multiply", "float", "float",
         {"in1": ("float", "angle_twice"), "in2": ("float", 0.5)}),
    Node("angle_cos", "cos", "float", "float", {"in": ("float", "angle")}),
    Node("angle_sin", "sin", "float", "float", {"in": ("float", "angle")}),
    Node("x", "tangent", "vector3", "vector3", {"space": ("string", "world")}),
    Node("beside", "crossproduct", "vector3", "vector3",
         {"in1": ("vector3", "normal"), "in2": ("vector3", "x")}),
    Node("plane_y", "normalize", "vector3", "vector3", {"in": ("vector3", "beside")}),
    Node("plane_x", "crossproduct", "vector3", "vector3",
         {"in1": ("vector3", "plane_y"), "in2": ("vector3", "normal")}),
    Node("across_x", "multiply", "vector3FA", "vector3",
         {"in1": ("vector3", "plane_x"), "in2": ("float", "angle_cos")}),
    Node("across_y", "multiply", "vector3FA", "vector3",
         {"in1": ("vector3", "plane_y"), "in2": ("float", "angle_sin")}),
    Node("across", "add", "vector3", "vector3",
         {"in1": ("vector3", "across_x"), "in2": ("vector3", "across_y")}),
)  # fmt: skip
"""From ``rotation`` and ``normal`` to ``across``, where the highlight is wide, in the world.

It is the tangent of every standard surface: see `standard.StandardShading`.
"""
