"""Opens stages safely, with our schema registered and the shaders of the networks known.

USD freezes its schema registry at the first prim it defines or node it looks up, and nothing
can be registered after that. Whoever opens stages for this package therefore does it here.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from pxr import Plug, Sdf, Sdr, Tf, Usd, UsdShade, UsdUtils

from weaveusd import contract
from weaveusd.errors import StageError

MAX_TEXT_BYTES = 64 << 20
"""Largest text layer that is opened as a root: the parser takes many times its size."""

MAX_BINARY_BYTES = 2 << 30
"""Largest crate or package that is opened as a root; it is mapped, not read."""

SUFFIXES = (".usda", ".usdc", ".usd", ".usdz")

_SDF_FROM_MATERIALX = {
    "boolean": "bool", "integer": "int", "float": "float", "string": "string",
    "color3": "color3f", "color4": "color4f",
    "vector2": "float2", "vector3": "float3", "vector4": "float4",
    "matrix33": "matrix3d", "matrix44": "matrix4d",
    "filename": "asset", "geomname": "string",
    "booleanarray": "bool[]", "integerarray": "int[]", "floatarray": "float[]",
    "stringarray": "string[]", "color3array": "color3f[]", "color4array": "color4f[]",
    "vector2array": "float2[]", "vector3array": "float3[]", "vector4array": "float4[]",
}  # fmt: skip
"""USD's spelling of MaterialX types, as UsdMtlx maps them; a closure is a token."""


def schema_dir() -> Path:
    """Return the folder of schemas: inside an installed package, else of the checkout.

    Raises
    ------
    StageError
        When neither exists.
    """
    package = Path(__file__).resolve().parent
    for folder in (package / "schemas", package.parent / "schemas"):
        if (folder / "weaveCloth" / "plugInfo.json").is_file():
            return folder
    raise StageError(
        f"{package / 'schemas'}: the schema weaveCloth is not installed, "
        "expected weaveCloth/plugInfo.json"
    )


@cache
def require() -> None:
    """Register our schema; call it before anything else asks USD for a schema.

    Raises
    ------
    StageError
        When the schema is missing, or USD had frozen its registry without it.
    """
    with captured_diagnostics():
        Plug.Registry().RegisterPlugins(str(schema_dir() / "weaveCloth"))
        known = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(contract.CLOTH_API)
    if known is None:
        raise StageError(
            f"{contract.CLOTH_API}: USD fixed its list of schemas before ours was registered; "
            "call weaveusd.stage.require() before defining prims, or set "
            f"PXR_PLUGINPATH_NAME={schema_dir() / 'weaveCloth'} before the program starts"
        )


@contextmanager
def captured_diagnostics() -> Iterator[list[str]]:
    """Keep USD from printing; on leaving, the list holds its warnings, one line each."""
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    messages: list[str] = []
    try:
        yield messages
    finally:
        messages += [_one_line(d.commentary) for d in delegate.TakeUncoalescedDiagnostics()]


def open_stage(path: str | os.PathLike[str], *, load: bool = True) -> Usd.Stage:
    """Return the stage whose root layer is the file `path`, with our schema registered.

    With `load` false payloads stay unloaded. References that do not resolve leave the stage
    open with holes: ask `stage.GetCompositionErrors()`.

    Raises
    ------
    StageError
        One line, when the file is missing, unreadable, too big or not USD.
    """
    require()
    file = Path(path)
    _check_file(file)
    policy = Usd.Stage.LoadAll if load else Usd.Stage.LoadNone
    try:
        with captured_diagnostics():
            return Usd.Stage.Open(os.path.abspath(file), policy)
    except Tf.ErrorException as error:
        raise StageError(f"{file}: not a USD layer: {_first_cause(error, file)}") from None


@cache
def teach_sdr() -> None:
    """Make the nodes of MaterialX and our own shader known to USD's shader registry.

    USD from PyPI reads no MaterialX, so it takes every MaterialX node id for unknown. The
    definitions of the MaterialX wheel are written as shader definitions into a layer in
    memory, and those of `schemas/weaveCloth/shaders.usda` are read as they are. About one
    second, once a process.
    """
    require()
    with captured_diagnostics():
        _discover(_materialx_definitions())
        _discover(Sdf.Layer.FindOrOpen(str(schema_dir() / "weaveCloth" / "shaders.usda")))


@cache
def materialx_library() -> Any:
    """Return the document of MaterialX's standard definitions, read once; not to be changed."""
    import MaterialX

    document = MaterialX.createDocument()
    folder = MaterialX.FileSearchPath(str(_materialx_folder()))
    MaterialX.loadLibraries(["libraries"], folder, document)
    return document


def _materialx_folder() -> Path:
    import MaterialX

    return Path(MaterialX.__file__).parent


def _check_file(file: Path) -> None:
    """Raise StageError unless `file` is a readable file of bounded size that may be USD."""
    if file.suffix.lower() not in SUFFIXES:
        raise StageError(f"{file}: not a USD file, expected one of {', '.join(SUFFIXES)}")
    if not file.exists():
        raise StageError(f"{file}: no such file")
    if not file.is_file():
        raise StageError(f"{file}: not a file, expected a USD layer")
    try:
        with file.open("rb") as stream:
            binary = stream.read(8).startswith((b"PXR-USDC", b"PK"))
        size = file.stat().st_size
    except OSError as error:
        raise StageError(f"{file}: cannot be read: {error.strerror}") from None
    limit = MAX_BINARY_BYTES if binary else MAX_TEXT_BYTES
    if size > limit:
        raise StageError(f"{file}: {size} bytes, expected at most {limit}")


def _one_line(text: str) -> str:
    return " ".join(text.split())


def _first_cause(error: Exception, file: Path) -> str:
    """Return what USD says went wrong first, without its own source lines and the full path."""
    text = str(error).replace(os.path.abspath(file), file.name)
    causes: list[str] = re.findall(r"in file \S+ : '(.*?)'\s*(?=Error in|$)", text, re.DOTALL)
    cause = _one_line(causes[0] if causes else text)
    return cause.removeprefix(f"{file.name}:")[:300]


def _materialx_definitions() -> Sdf.Layer:
    """Return a layer in memory with one shader definition for each MaterialX nodedef."""
    # A definition needs an asset that resolves; which one does not matter to a validator.
    source = str(_materialx_folder() / "libraries" / "stdlib" / "stdlib_defs.mtlx")

    layer = Sdf.Layer.CreateAnonymous("materialx.usda")
    with Sdf.ChangeBlock():
        for nodedef in materialx_library().getNodeDefs():
            _define_shader(layer, nodedef, source)
    return layer


def _define_shader(layer: Sdf.Layer, nodedef: Any, source: str) -> None:
    """Write the MaterialX `nodedef` as a shader definition named as its id into `layer`."""
    prim = Sdf.PrimSpec(layer, nodedef.getName(), Sdf.SpecifierDef, "Shader")

    def attribute(name: str, kind: Sdf.ValueTypeName) -> Sdf.AttributeSpec:
        return Sdf.AttributeSpec(prim, name, kind)

    names = Sdf.ValueTypeNames
    attribute("info:id", names.Token).default = nodedef.getName()
    attribute("info:implementationSource", names.Token).default = "sourceAsset"
    attribute("info:mtlx:sourceAsset", names.Asset).default = Sdf.AssetPath(source)
    for port in nodedef.getActiveInputs():
        attribute(f"inputs:{port.getName()}", _sdf_type(port.getType()))
    for port in nodedef.getActiveOutputs():
        attribute(f"outputs:{port.getName()}", _sdf_type(port.getType()))


def _sdf_type(materialx_type: str) -> Sdf.ValueTypeName:
    return Sdf.ValueTypeNames.Find(_SDF_FROM_MATERIALX.get(materialx_type, "token"))


_definitions: list[Usd.Stage] = []
"""Stages of definitions that Sdr reads when a node is first asked for: they must stay open."""


def _discover(layer: Sdf.Layer) -> None:
    """Tell Sdr about every shader definition at the root of `layer`."""
    stage = Usd.Stage.Open(layer)
    _definitions.append(stage)
    for prim in stage.GetPseudoRoot().GetChildren():
        shader = UsdShade.Shader(prim)
        for found in UsdShade.ShaderDefUtils.GetDiscoveryResults(shader, layer.identifier):
            Sdr.Registry().AddDiscoveryResult(found)
