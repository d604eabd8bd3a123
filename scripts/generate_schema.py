"""Write schemas/weaveCloth from weaveusd.contract, or check that it is up to date.

    python scripts/generate_schema.py            # write
    python scripts/generate_schema.py --check    # exit 1 and name the files that differ

`schema.usda` and `shaders.usda` come straight from the contract; `generatedSchema.usda` and
`plugInfo.json` come from usdGenSchema, mended where it falls short: it leaves placeholders in
plugInfo.json and drops the documentation of properties.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from pxr import Gf, Sdf, Vt

from weaveusd.contract import (
    CHANNELS,
    CLOTH_API,
    CLOTH_ATTRIBUTES,
    CLOTH_NAMESPACE,
    CLOTH_SHADER_ID,
    DEFAULT_ST,
    MITSUBA_CONTEXT,
    MOMENT_MAPS,
    SHADER_FILES,
    SHADER_UV_SCALE,
    SHADER_VARNAME,
    SHADER_YARN_ARRAYS,
    SYSTEMS,
    YARN_API,
    YARN_ATTRIBUTES,
    YARN_NAMESPACE,
    Attribute,
    kinds_input,
    moment_input,
    section_input,
)

FOLDER = Path(__file__).resolve().parents[1] / "schemas" / "weaveCloth"
LIBRARY = "weaveCloth"
PREFIX = "Weave"

CLOTH_DOC = "A woven cloth: its draft, its sett and the figures that a mill would quote."
YARN_DOC = "One yarn of a woven cloth, the instance name being the yarn's: make and optics."
SHADER_DOC = (
    "The exact cloth shader. It reads the yarn's frame from the textures and the optics of each "
    "yarn from arrays in the order of the yarn ids, the first value belonging to id 1."
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Write or check the committed files and return the exit status."""
    parser = argparse.ArgumentParser(description="Write schemas/weaveCloth from the contract.")
    parser.add_argument("--check", action="store_true", help="write nothing, exit 1 if stale")
    check = parser.parse_args(arguments).check
    files = generate()
    if not check:
        FOLDER.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            (FOLDER / name).write_text(text, encoding="utf-8")
        return 0
    stale = [name for name, text in files.items() if not _holds(FOLDER / name, text)]
    for name in stale:
        print(f"{FOLDER / name}: out of date; run scripts/generate_schema.py", file=sys.stderr)
    return 1 if stale else 0


def generate() -> dict[str, str]:
    """Return the text of every file of the schema, by name."""
    source = source_layer()
    with tempfile.TemporaryDirectory() as scratch:
        path = Path(scratch) / "schema.usda"
        source.Export(str(path))
        done = subprocess.run(
            [sys.executable, "-m", "pxr.Usd.usdGenSchema", str(path), scratch],
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode != 0:
            raise RuntimeError(f"usdGenSchema failed:\n{done.stdout}{done.stderr}")
        plug_info = (Path(scratch) / "plugInfo.json").read_text(encoding="utf-8")
        generated = Sdf.Layer.OpenAsAnonymous(str(Path(scratch) / "generatedSchema.usda"))
        _restore_docs(source, generated)
        return {
            "schema.usda": source.ExportToString(),
            "generatedSchema.usda": generated.ExportToString(),
            "plugInfo.json": _mend_plug_info(plug_info),
            "shaders.usda": shader_layer().ExportToString(),
        }


def source_layer() -> Sdf.Layer:
    """Return the schema's source: one class for the cloth, one for its yarns."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.comment = "Written by scripts/generate_schema.py from weaveusd/contract.py."
    layer.subLayerPaths = ["usd/schema.usda"]
    library = Sdf.PrimSpec(layer, "GLOBAL", Sdf.SpecifierOver)
    library.customData = {
        "libraryName": LIBRARY,
        "libraryPath": ".",
        "libraryPrefix": PREFIX,
        "skipCodeGeneration": True,
    }
    cloth = _schema_class(layer, CLOTH_API, CLOTH_DOC, {"apiSchemaType": "singleApply"})
    for attribute in CLOTH_ATTRIBUTES:
        _add_attribute(cloth, f"{CLOTH_NAMESPACE}:{attribute.name}", attribute, "Cloth")
    yarn_data = {"apiSchemaType": "multipleApply", "propertyNamespacePrefix": YARN_NAMESPACE}
    yarn = _schema_class(layer, YARN_API, YARN_DOC, yarn_data)
    for attribute in YARN_ATTRIBUTES:
        _add_attribute(yarn, attribute.name, attribute, "Yarn")
    return layer


def shader_layer() -> Sdf.Layer:
    """Return the definition of the exact shader, in the form that Sdr can be taught."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.comment = "Written by scripts/generate_schema.py from weaveusd/contract.py."
    shader = Sdf.PrimSpec(layer, CLOTH_SHADER_ID, Sdf.SpecifierDef, "Shader")
    shader.documentation = SHADER_DOC
    shader.SetInfo("sdrMetadata", {"help": SHADER_DOC, "role": "surface"})
    uniform = Sdf.VariabilityUniform
    types = Sdf.ValueTypeNames
    Sdf.AttributeSpec(shader, "info:id", types.Token, uniform).default = CLOTH_SHADER_ID
    source = Sdf.AttributeSpec(shader, "info:implementationSource", types.Token, uniform)
    source.default = "sourceAsset"
    asset = Sdf.AttributeSpec(shader, f"info:{MITSUBA_CONTEXT}:sourceAsset", types.Asset, uniform)
    # Sdr wants a source that resolves; the code itself lives in weaveusd.render.
    asset.default = Sdf.AssetPath("./shaders.usda")
    meanings = {name: c.meaning for c in CHANNELS.values() for name in c.files}
    for name, file in SHADER_FILES.items():
        _add_input(shader, name, types.Asset, f"Texture: {meanings[file]}.", Sdf.AssetPath())
    for system in SYSTEMS:
        _add_moment_inputs(shader, system)
    for name, meaning in SHADER_YARN_ARRAYS.items():
        _add_input(shader, name, types.FloatArray, f"For each yarn: {meaning}.", [])
    _add_input(
        shader,
        SHADER_UV_SCALE,
        types.Float2,
        "Repeats of the cloth in one unit of the texture coordinates.",
        Gf.Vec2f(1),
    )
    _add_input(
        shader,
        SHADER_VARNAME,
        types.String,
        "Primvar that holds the texture coordinates.",
        DEFAULT_ST,
    )
    Sdf.AttributeSpec(shader, "outputs:surface", types.Token)
    return layer


def _add_moment_inputs(shader: Sdf.PrimSpec, system: str) -> None:
    types = Sdf.ValueTypeNames
    for moment_map in MOMENT_MAPS.values():
        doc = f"Moment map of the {system}: {moment_map.meaning}. " + ", ".join(
            f"{letter} = {component}"
            for letter, component in zip("RGBA", moment_map.components, strict=True)
        )
        name = moment_input(system, moment_map.name)
        _add_input(shader, name, types.Asset, f"{doc}.", Sdf.AssetPath())
    _add_input(
        shader,
        section_input(system),
        types.Float2,
        f"Thickness over width of the {system} yarns, and their half thickness over the radius in "
        "which they bend: what the moment maps are written in. 0 where there are no maps.",
        Gf.Vec2f(0),
    )
    _add_input(
        shader,
        kinds_input(system),
        types.IntArray,
        f"Ids of the yarns, from 1, that stand for the kinds of {system} yarn, in the order of "
        "the components of the map of kinds.",
        [],
    )


def _schema_class(layer: Sdf.Layer, name: str, doc: str, data: dict[str, str]) -> Sdf.PrimSpec:
    prim = Sdf.PrimSpec(layer, name, Sdf.SpecifierClass)
    prim.inheritPathList.explicitItems = ["/APISchemaBase"]
    prim.documentation = doc
    prim.customData = {
        **data,
        "className": name.removeprefix(PREFIX),
        "apiSchemaCanOnlyApplyTo": Vt.TokenArray(["Material"]),
    }
    return prim


def _add_attribute(prim: Sdf.PrimSpec, name: str, attribute: Attribute, group: str) -> None:
    kind = Sdf.ValueTypeNames.Find(attribute.type)
    spec = Sdf.AttributeSpec(prim, name, kind, Sdf.VariabilityUniform)
    spec.documentation = _doc(attribute)
    spec.displayName = _label(attribute)
    spec.displayGroup = f"{group}:{attribute.group}"
    if attribute.tokens:
        spec.allowedTokens = list(attribute.tokens)
    limits = {
        strength: found
        for strength, pair in (("hard", attribute.hard), ("soft", attribute.soft))
        if (found := _limits(kind, pair))
    }
    if limits:
        spec.SetInfo("limits", limits)


def _label(attribute: Attribute) -> str:
    words = re.sub(r"([A-Z])", r" \1", attribute.name)
    return attribute.label or words[0].upper() + words[1:]


def _limits(kind: Sdf.ValueTypeName, pair: tuple[float | None, float | None]) -> dict[str, object]:
    return {
        key: _as_type(kind, limit)
        for key, limit in zip(("minimum", "maximum"), pair, strict=True)
        if limit is not None
    }


def _doc(attribute: Attribute) -> str:
    text = attribute.meaning[0].upper() + attribute.meaning[1:] + "."
    if attribute.unit:
        text += " No unit." if attribute.unit == "1" else f" Unit: {attribute.unit}."
    return text


def _as_type(kind: Sdf.ValueTypeName, limit: float) -> object:
    if kind == Sdf.ValueTypeNames.Int:
        return int(limit)
    if kind == Sdf.ValueTypeNames.Color3f:
        return Gf.Vec3f(limit)
    return float(limit)


def _add_input(
    shader: Sdf.PrimSpec, name: str, kind: Sdf.ValueTypeName, doc: str, default: object
) -> None:
    spec = Sdf.AttributeSpec(shader, f"inputs:{name}", kind)
    spec.documentation = doc
    spec.SetInfo("sdrMetadata", {"help": doc})
    spec.default = default


def _restore_docs(source: Sdf.Layer, generated: Sdf.Layer) -> None:
    for prim in generated.rootPrims:
        origin = source.GetPrimAtPath(prim.path)
        prim.documentation = origin.documentation
        for spec in prim.attributes:
            # A multiple-apply schema spells its properties weave:yarn:__INSTANCE_NAME__:<name>.
            name = spec.name if spec.name in origin.properties else spec.name.rsplit(":", 1)[1]
            spec.documentation = origin.properties[name].documentation


def _mend_plug_info(text: str) -> str:
    # usdGenSchema heads the file with comments that JSON does not know.
    lines = [line for line in text.splitlines() if not line.lstrip().startswith("#")]
    info = json.loads("\n".join(lines))
    for plugin in info["Plugins"]:
        plugin.update(Type="resource", Root=".", ResourcePath=".", LibraryPath="")
    return json.dumps(info, indent=4, sort_keys=True) + "\n"


def _holds(path: Path, text: str) -> bool:
    return path.is_file() and path.read_text(encoding="utf-8") == text


if __name__ == "__main__":
    sys.exit(main())
