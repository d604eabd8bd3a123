"""Prints, as JSON, what another OpenUSD does not know of the shaders of a stage.

    python known_nodes.py STAGE SHADER_DEFINITIONS

It runs in an environment of its own and imports nothing of ours.
"""

from __future__ import annotations

import json
import sys

from pxr import Sdr, Usd, UsdShade


def learn(definitions: str) -> Usd.Stage:
    """Tell Sdr of the shader definitions in a layer; the stage must stay open."""
    stage = Usd.Stage.Open(definitions)
    for prim in stage.GetPseudoRoot().GetChildren():
        shader = UsdShade.Shader(prim)
        for found in UsdShade.ShaderDefUtils.GetDiscoveryResults(shader, definitions):
            Sdr.Registry().AddDiscoveryResult(found)
    return stage


def unknown(prim: Usd.Prim) -> list[str]:
    """Return every node, input, output and type of the shader `prim` that is not known."""
    shader = UsdShade.Shader(prim)
    node = Sdr.Registry().GetShaderNodeByIdentifier(shader.GetShaderId())
    if not node:
        return [f"{prim.GetPath()}: no node {shader.GetShaderId()}"]
    faults = []
    for put in shader.GetInputs():
        known = node.GetShaderInput(put.GetBaseName())
        if not known:
            faults.append(f"{put.GetAttr().GetPath()}: no such input")
        elif known.GetTypeAsSdfType().GetSdfType() != put.GetTypeName():
            expected = known.GetTypeAsSdfType().GetSdfType()
            faults.append(f"{put.GetAttr().GetPath()}: {put.GetTypeName()}, expected {expected}")
    return faults + [
        f"{out.GetAttr().GetPath()}: no such output"
        for out in shader.GetOutputs()
        if out.GetBaseName() not in node.GetShaderOutputNames()
    ]


def main(layer: str, definitions: str) -> None:
    kept = learn(definitions)
    stage = Usd.Stage.Open(layer)
    shaders = [
        prim
        for prim in stage.TraverseAll()
        if prim.IsA(UsdShade.Shader)
        and UsdShade.Shader(prim).GetImplementationSource() == UsdShade.Tokens.id
    ]
    report = {
        "version": ".".join(map(str, Usd.GetVersion())),
        "kept": bool(kept),
        "materialx": bool(
            Sdr.Registry().GetShaderNodeByIdentifier("ND_open_pbr_surface_surfaceshader")
        ),
        "shaders": len(shaders),
        "unknown": [fault for prim in shaders for fault in unknown(prim)],
        "composition": [str(error) for error in stage.GetCompositionErrors()],
    }
    sys.stdout.write(json.dumps(report))


if __name__ == "__main__":
    main(*sys.argv[1:])
