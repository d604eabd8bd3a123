"""The OpenAsset: a published asset as a judge sees it, from its files alone."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import cached_property
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

from pxr import Sdf, Usd, UsdShade

from weaveusd import contract
from weaveusd.errors import InputError, RendererUnavailableError
from weaveusd.stage import captured_diagnostics, open_stage
from weaveusd.validate.exhibits import Exhibit
from weaveusd.validate.profiles import DEFAULT, Profile
from weaveusd.validate.registry import Need
from weaveusd.validate.sweep import Look, Sweep, sweep
from weaveusd.validate.textures import Header, TextureFolder

if TYPE_CHECKING:
    from weaveusd.validate.textures import Pixels

TEXTURE_FILES: dict[str, contract.Channel] = {
    file: channel for channel in contract.CHANNELS.values() for file in channel.files
}
"""Every texture file of an asset and the channel that it carries."""

_CLOTH_TYPES = {attribute.name: attribute.type for attribute in contract.CLOTH_ATTRIBUTES}
_YARN_TYPES = {attribute.name: attribute.type for attribute in contract.YARN_ATTRIBUTES}


class OpenAsset:
    """An asset opened for judging: its stage, material, textures and files.

    `jobs` is the number of threads that read textures, by default one for each core. `colorway`
    is the variant of the root that is judged, "" for the one that the asset chooses itself.
    `profile` says how closely checks look. What checks show beside findings is in `shown`, the
    texels of small textures that several checks look at, by file, in `kept`.

    Raises
    ------
    StageError
        When the entry layer cannot be opened.
    """

    def __init__(
        self,
        entry: str | os.PathLike[str],
        jobs: int | None = None,
        colorway: str = "",
        profile: Profile | None = None,
    ) -> None:
        self.entry = Path(os.path.abspath(entry))
        self.folder = self.entry.parent
        self.stage: Usd.Stage = open_stage(self.entry)
        self.colorway = colorway
        self.profile = profile or Profile(DEFAULT)
        self.shown: dict[str, Exhibit] = {}
        self.kept: dict[str, Pixels] = {}
        with captured_diagnostics():
            # What counts is on disk, not what this process remembers of it.
            for layer in self.layers():
                if not layer.dirty:
                    layer.Reload()
            if colorway:
                with Usd.EditContext(self.stage, self.stage.GetSessionLayer()):
                    self._colorway_set().SetVariantSelection(colorway)
        textures = self.folder / contract.TEXTURE_DIR
        self.textures = TextureFolder(textures, textures / colorway if colorway else None)
        self._jobs = len(os.sched_getaffinity(0)) if jobs is None else jobs
        self._swept: Sweep | None = None

    @property
    def root(self) -> Usd.Prim:
        """The default prim; invalid, hence false, when there is none."""
        return self.stage.GetDefaultPrim()

    @property
    def colorways(self) -> tuple[str, ...]:
        """Names of the colorways, of which one is chosen; none where there is but one look."""
        return tuple(self._colorway_set().GetVariantNames()) if self.root else ()

    @property
    def chosen(self) -> str:
        """The colorway that is chosen, "" where none is."""
        return str(self._colorway_set().GetVariantSelection()) if self.root else ""

    def file_of_look(self, name: str) -> str:
        """Return what the file called `name` in the contract is called in this colorway."""
        return contract.of_colorway(name, self.colorway)

    def texture_path(self, file: str) -> str:
        """Return the anchored path of a texture: a colorway has those of its own in a folder."""
        return f"./{self.textures.path(file).relative_to(self.folder).as_posix()}"

    @cached_property
    def material(self) -> Usd.Prim:
        """The cloth material: below the root by the contract's name, else the first of all.

        Invalid, hence false, when there is none.
        """
        found = [p for p in self.stage.Traverse() if _has_api(p, contract.CLOTH_API)]
        if self.root:
            named = self.root.GetPath().AppendChild(contract.MATERIAL_NAME)
            found.sort(key=lambda prim: prim.GetPath() != named)
        return found[0] if found else Usd.Prim()

    @cached_property
    def shader(self) -> Usd.Prim:
        """The shader on the exact output of the material, whatever its id, or an invalid prim."""
        if not self.material:
            return Usd.Prim()
        material = UsdShade.Material(self.material)
        return connected_prim(material.GetSurfaceOutput(contract.MITSUBA_CONTEXT))

    def layers(self) -> Iterator[Sdf.Layer]:
        """Yield the layers that make up the stage, in the order of their files."""
        layers = [layer for layer in self.stage.GetUsedLayers() if not layer.anonymous]
        yield from sorted(layers, key=lambda layer: str(layer.identifier))

    def short(self, path: str | os.PathLike[str]) -> str:
        """Return `path` as seen from the asset's folder where it lies inside."""
        file = Path(path)
        return str(file.relative_to(self.folder)) if file.is_relative_to(self.folder) else str(file)

    def cloth(self, name: str) -> Any:
        """Return the value of `weave:<name>`, or None unless authored in the contract's type."""
        return self._authored(f"{contract.CLOTH_NAMESPACE}:{name}", _CLOTH_TYPES[name])

    def yarn(self, instance: str, name: str) -> Any:
        """Return the value of `weave:yarn:<instance>:<name>`, or None like `cloth`."""
        return self._authored(f"{contract.YARN_NAMESPACE}:{instance}:{name}", _YARN_TYPES[name])

    @property
    def color_space(self) -> contract.ColorSpace:
        """The color space of base_color.exr and of the yarns' colors, Rec.709 unless stated."""
        stated = self.cloth("colorSpace")
        return next((name for name in contract.COLOR_SPACES if name == stated), "lin_rec709")

    @cached_property
    def yarns(self) -> tuple[str, ...]:
        """Names of the yarns in the order of their ids: the first of `weave:yarns`, up to 255."""
        return tuple(self.cloth("yarns") or ())[: contract.MAX_YARNS]

    @cached_property
    def texels_per_thread(self) -> tuple[float, float]:
        """Texels from end to end along x and from pick to pick along y; 0 where not stated."""
        header = self.textures.header("yarn_id.png")
        ends, picks = self.cloth("ends") or 0, self.cloth("picks") or 0
        return (
            header.width / ends if ends > 0 else 0.0,
            header.height / picks if picks > 0 else 0.0,
        )

    @cached_property
    def texture_files(self) -> Mapping[str, contract.Channel]:
        """The texture files that the asset has to have, and their channels.

        Those for standard shaders follow from the yarns: an asset of an older version, which lists
        others, needs none that it does not list.
        """
        listed = self.cloth("textures")
        if listed is None:
            return TEXTURE_FILES
        names = {PurePosixPath(file.path).name for file in listed}
        return {f: c for f, c in TEXTURE_FILES.items() if not c.per_yarn or f in names}

    def lacks(self, need: Need) -> str | None:
        """Return why `need` is not there, or None when it is."""
        if need == "material":
            return None if self.material else "there is no cloth material"
        if need == "renderer":
            return _no_renderer()
        if need == "shader":
            return None if self.shader else "there is no exact shader"
        if need == "moments":
            return None if named_maps(self.shader) else "the exact shader names no moment maps"
        return self._texture_fault

    def sweep(
        self, looks: Mapping[str, Look], progress: Callable[[float], None] | None = None
    ) -> Mapping[str, Exception]:
        """Read every texture, show their bands to `looks`, and return what looks have raised.

        Looks see nothing unless `lacks("textures")` will be None.
        """
        complete = len(self._fitting) == len(self.texture_files)
        self._swept = sweep(
            self.textures,
            self._fitting,
            looks if complete else {},
            jobs=self._jobs,
            progress=progress,
        )
        return self._swept.broken

    def decode_fault(self, file: str) -> InputError | None:
        """Return why texture `file`, whose header fits, does not decode, or None when it does."""
        if self._swept is None:
            self.sweep({})
        return self._swept.faults.get(file) if self._swept else None

    @cached_property
    def _fitting(self) -> tuple[str, ...]:
        """The texture files whose headers can be read and are as the contract has them."""
        fitting = []
        for file in self.texture_files:
            with suppress(InputError):
                if fits(file, self.textures.header(file)):
                    fitting.append(file)
        return tuple(fitting)

    @cached_property
    def _texture_fault(self) -> str | None:
        """Why the textures cannot be judged together, or None when they can."""
        sizes = set()
        for file in self.texture_files:
            try:
                header = self.textures.header(file)
            except InputError:
                return "not every texture can be read"
            sizes.add((header.width, header.height))
            if not fits(file, header):
                return f"{file} has another format"
            if self.decode_fault(file) is not None:
                return "not every texture can be read"
        return None if len(sizes) == 1 else "the textures differ in size"

    def _colorway_set(self) -> Usd.VariantSet:
        return self.root.GetVariantSet(contract.COLORWAYS)

    def _authored(self, name: str, kind: str) -> Any:
        attribute = self.material.GetAttribute(name) if self.material else None
        if not attribute or not attribute.HasAuthoredValue():
            return None
        kinds = {str(spec.typeName) for spec in attribute.GetPropertyStack()}
        return attribute.Get() if kinds == {kind} else None


def _no_renderer() -> str | None:
    """Return why nothing can be rendered here, or None when it can."""
    from weaveusd.render.variant import prepare

    try:
        prepare()
    except RendererUnavailableError as error:
        return str(error)
    return None


def connected_prim(output: UsdShade.Output) -> Usd.Prim:
    """Return the prim whose output `output` is connected to, or an invalid one."""
    sources = output.GetConnectedSources()[0] if output else []
    return sources[0].source.GetPrim() if sources else Usd.Prim()


def named_maps(shader: Usd.Prim) -> tuple[str, ...]:
    """Return those inputs of `shader` that are there to name moment maps."""
    inputs = (
        contract.moment_input(system, name)
        for system in contract.SYSTEMS
        for name in contract.MOMENT_MAPS
    )
    return tuple(name for name in inputs if shader and UsdShade.Shader(shader).GetInput(name))


def stored_type(file: str) -> str:
    """Return NumPy's name of the type in which the contract stores texture `file`."""
    if file.endswith(".exr"):
        return "float16"
    return "uint16" if TEXTURE_FILES[file].encoding == "vector" else "uint8"


def fits(file: str, header: Header) -> bool:
    """Whether texture `file` has the channels and the type of numbers of the contract."""
    return (header.channels, header.dtype) == (TEXTURE_FILES[file].components, stored_type(file))


def applied_schemas(prim: Usd.Prim) -> tuple[str, ...]:
    """Return the API schemas applied to `prim`, whether this process knows them or not."""
    return tuple(prim.GetPrimTypeInfo().GetAppliedAPISchemas())


def _has_api(prim: Usd.Prim, api: str) -> bool:
    return api in applied_schemas(prim)
