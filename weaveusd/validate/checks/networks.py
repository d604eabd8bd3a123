"""Whether the networks for other renderers are there and name only inputs that exist."""

from __future__ import annotations

from collections.abc import Iterator

from pxr import Sdr, Usd, UsdShade

from weaveusd.stage import teach_sdr
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset, applied_schemas, connected_prim
from weaveusd.validate.registry import Code, check

PREVIEW = Code("preview-missing", Status.FAIL, "No UsdPreviewSurface is on outputs:surface.")
MATERIALX = Code("mtlx-missing", Status.FAIL, "No MaterialX shader is on outputs:mtlx:surface.")
VERSION = Code("mtlx-version", Status.FAIL, "The MaterialX version of the network is not stated.")
INPUT = Code("input-unknown", Status.FAIL, "A shader has an input that its node does not know.")

_CONFIG_API = "MaterialXConfigAPI"
_CONFIG_VERSION = "config:mtlx:version"


@check(
    id="shader/networks",
    why="Every renderer needs a surface it understands, and none reports an input it ignores.",
    needs=("material",),
    codes=(PREVIEW, MATERIALX, VERSION, INPUT),
)
def shader_networks(asset: OpenAsset) -> Iterator[Finding]:
    """The preview and MaterialX networks are connected and name only inputs that exist."""
    prim = asset.material
    path = str(prim.GetPath())
    material = UsdShade.Material(prim)
    if _id(connected_prim(material.GetSurfaceOutput())) != "UsdPreviewSurface":
        yield PREVIEW("outputs:surface leads to no UsdPreviewSurface", path)
    if not _id(connected_prim(material.GetSurfaceOutput("mtlx"))).startswith("ND_"):
        yield MATERIALX("outputs:mtlx:surface leads to no MaterialX node", path)
    version = prim.GetAttribute(_CONFIG_VERSION)
    if _CONFIG_API not in applied_schemas(prim) or not (version and version.Get()):
        yield VERSION(f"expected {_CONFIG_API} and {_CONFIG_VERSION}: unstated means 1.38", path)

    teach_sdr()
    for child in Usd.PrimRange(prim):
        yield from _unknown_inputs(child)


def _unknown_inputs(prim: Usd.Prim) -> Iterator[Finding]:
    """A node that nobody knows is for OpenUSD's validators to report."""
    node = Sdr.Registry().GetShaderNodeByIdentifier(_id(prim)) if _id(prim) else None
    if node is None:
        return
    known = set(node.GetShaderInputNames())
    for found in UsdShade.Shader(prim).GetInputs(onlyAuthored=True):
        if found.GetBaseName() not in known:
            yield INPUT(
                f"the node {_id(prim)} knows no input {found.GetBaseName()!r}",
                str(found.GetAttr().GetPath()),
            )


def _id(prim: Usd.Prim) -> str:
    if not prim or not prim.IsA(UsdShade.Shader):
        return ""
    return str(UsdShade.Shader(prim).GetIdAttr().Get() or "")
