"""One planted fault for every finding code: what is spoiled, and what must be found."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import OpenImageIO
from numpy.typing import NDArray

from tests.validate.assets import ACROSS, ALONG, TWILL, Channels, cloth, drawn, publish, surface
from weaveusd.contract import GAP, MANIFEST_FILE
from weaveusd.export.doors import write_doors
from weaveusd.export.images import ImageWriter
from weaveusd.export.manifest import list_files, write_manifest
from weaveusd.export.package import write_package
from weaveusd.validate.profiles import Profile, find_profile

Spoil = Callable[[Path], object]


@dataclass(frozen=True)
class Fault:
    """`change` spoils the channels before they are written, `spoil` the published folder.

    `codes` are all codes worse than a skip that the report must have. A sealed fault gets a
    new manifest, so that the manifest does not betray it.
    """

    name: str
    codes: frozenset[str]
    change: Callable[[Channels], None] | None = None
    spoil: Spoil | None = None
    sealed: bool = True
    profile: str = "quick"

    def judged(self) -> Profile:
        """Return the profile, with renders as small as they can be."""
        return replace(find_profile(self.profile), size=32, spp=32, samples=20_000)

    def plant(self, folder: Path) -> Path:
        entry = publish(folder, cloth(change=self.change))
        if self.spoil is not None:
            self.spoil(folder)
            if self.sealed:
                write_manifest(folder, "shot_twill", list_files(folder))
        return entry


FAULTS: list[Fault] = []


def in_channels(*codes: str) -> Callable[[Callable[[Channels], None]], None]:
    """Register the decorated function as what spoils the channels."""

    def register(change: Callable[[Channels], None]) -> None:
        FAULTS.append(Fault(change.__name__, frozenset(codes), change=change))

    return register


def in_files(*codes: str, sealed: bool = True, profile: str = "quick") -> Callable[[Spoil], None]:
    """Register the decorated function as what spoils the published folder."""

    def register(spoil: Spoil) -> None:
        fault = Fault(spoil.__name__, frozenset(codes), None, spoil, sealed, profile)
        FAULTS.append(fault)

    return register


def in_text(name: str, file: str, old: str, new: str, *codes: str) -> None:
    """Register the replacement of the text `old`, which must be there, in `file`."""

    def spoil(folder: Path) -> None:
        text = (folder / file).read_text()
        assert old in text
        (folder / file).write_text(text.replace(old, new))

    FAULTS.append(Fault(name, frozenset(codes), spoil=spoil))


def rewrite(path: Path, change: Callable[[NDArray], NDArray | None]) -> None:
    """Change the stored numbers of the texture `path`."""
    source = OpenImageIO.ImageInput.open(str(path))
    spec = source.spec()
    pixels = source.read_image(0, 0, 0, spec.nchannels, spec.format)
    source.close()
    changed = change(pixels)
    pixels = pixels if changed is None else changed
    height, width, channels = pixels.shape
    with ImageWriter(path, width, height, channels, pixels.dtype.name, {}) as out:
        out.write(pixels)


ENTRY, LOOK, MTLX = "shot_twill.usda", "look.usda", "material.mtlx"

# --- Structure ------------------------------------------------------------------------------------

in_text("a_root_of_another_type", ENTRY, 'def Scope "shot', 'def Xform "shot', "root-not-scope")
in_text("no_units", ENTRY, "    metersPerUnit = 1\n", "", "stage-metadata", "usd-error")
in_text(
    "no_schema", LOOK, '"WeaveClothAPI", ', "", "material-missing"
)  # fmt: skip
in_text("another_name", ENTRY, 'name = "shot_twill"', 'name = "twill"', "asset-info")
in_text("look_as_sublayer", ENTRY, "    prepend references = @./look.usda@\n", "",
        "look-not-referenced", "material-missing")  # fmt: skip
in_text(
    "no_colorway_chosen", ENTRY, "    prepend references = @./look.usda@\n)\n{\n",
    '    prepend variantSets = "colorway"\n)\n{\n    variantSet "colorway" = {\n'
    '        "one" (\n            prepend references = @./look.usda@\n        ) {\n'
    '        }\n    }\n',
    "colorway-unchosen", "look-not-referenced", "material-missing", "mtlx-broken",
)  # fmt: skip

# --- Paths ----------------------------------------------------------------------------------------

in_text("absolute_path", LOOK, "weave:draft = @./draft.wif@", "weave:draft = @/away/draft.wif@",
        "path-absolute", "usd-error")  # fmt: skip
in_text("drive_letter", LOOK, "weave:draft = @./draft.wif@", "weave:draft = @C:/draft.wif@",
        "path-absolute", "usd-error")  # fmt: skip
in_text("climbing_path", LOOK, "weave:draft = @./draft.wif@",
        "weave:draft = @./textures/../draft.wif@", "path-parent")  # fmt: skip
in_text("search_path", LOOK, "weave:draft = @./draft.wif@", "weave:draft = @draft.wif@",
        "path-unanchored")  # fmt: skip


@in_files("path-missing", "texture-unreadable", "usd-error")
def missing_texture(folder: Path) -> None:
    (folder / "textures" / "height.exr").unlink()


@in_files("path-outside", "manifest-changed", sealed=False)
def texture_elsewhere(folder: Path) -> None:
    inside, outside = folder / "textures" / "height.exr", folder.parent / "height.exr"
    inside.rename(outside)
    inside.symlink_to(outside)


# --- Attributes -----------------------------------------------------------------------------------

in_text("no_thickness", LOOK, "        uniform double weave:thickness = 0.5\n", "",
        "cloth-missing")  # fmt: skip
in_text("ends_as_text", LOOK, "uniform int weave:shafts = 4", 'uniform string weave:shafts = "4"',
        "cloth-type", "usd-error")  # fmt: skip
in_text("cover_above_one", LOOK, "weave:warpCover = 0.88", "weave:warpCover = 1.88",
        "cloth-limits")  # fmt: skip
in_text("not_a_number", LOOK, "weave:thickness = 0.5", "weave:thickness = nan", "cloth-limits")
in_text("invented_attribute", LOOK, "uniform double weave:thickness",
        "uniform double weave:softness = 3\n        uniform double weave:thickness",
        "cloth-unknown")  # fmt: skip
in_text("no_tex", LOOK, "        uniform double weave:yarn:ecru:tex = 66\n", "", "yarn-missing")
in_text("plies_as_double", LOOK, "uniform int weave:yarn:ecru:plies = 1",
        "uniform double weave:yarn:ecru:plies = 1", "yarn-type", "usd-error")  # fmt: skip
in_text("packing_above_one", LOOK, "weave:yarn:ecru:packing = 0.6",
        "weave:yarn:ecru:packing = 60", "yarn-limits")  # fmt: skip
in_text("bogus_token", LOOK, 'weave:yarn:ecru:twistDirection = "S"',
        'weave:yarn:ecru:twistDirection = "left"', "yarn-token")  # fmt: skip
in_text("invented_yarn_attribute", LOOK, "uniform double weave:yarn:ecru:tex",
        "uniform double weave:yarn:ecru:luck = 7\n        uniform double weave:yarn:ecru:tex",
        "yarn-unknown")  # fmt: skip
in_text("dropped_yarn", LOOK, ', "WeaveYarnAPI:indigo"', "", "yarn-list")
in_text("yarns_exchanged", LOOK, "weave:yarn:ecru:id = 1", "weave:yarn:ecru:id = 2", "yarn-order")
in_text("lobe_without_width", LOOK, "weave:yarn:ecru:gammaS = 0.21", "weave:yarn:ecru:gammaS = 0",
        "optics", "shader-disagrees")  # fmt: skip

# --- Shaders --------------------------------------------------------------------------------------

in_text(
    "exact_shader_unplugged",
    LOOK,
    "        token outputs:mitsuba:surface.connect = "
    "</shot_twill/Material/MitsubaSurface.outputs:surface>\n",
    "",
    "shader-missing",
)
in_text("array_left_out", LOOK, "            float[] inputs:tau = [0, 0]\n", "",
        "shader-input-missing")  # fmt: skip
in_text("array_of_doubles", LOOK, "float[] inputs:tau", "double[] inputs:tau",
        "shader-input-type", "usd-error")  # fmt: skip
in_text("another_texture", LOOK, "inputs:height_file = @./textures/height.exr@",
        "inputs:height_file = @./textures/opacity.png@", "shader-file")  # fmt: skip
in_text("array_too_short", LOOK, "inputs:eta = [1.54, 1.54]", "inputs:eta = [1.54]",
        "shader-array-length")  # fmt: skip
in_text("array_of_other_numbers", LOOK, "inputs:eta = [1.54, 1.54]", "inputs:eta = [1.54, 1.55]",
        "shader-disagrees")  # fmt: skip
in_text("scale_of_another_cloth", LOOK, "inputs:uv_scale = (500, 500)",
        "inputs:uv_scale = (500, 400)", "uv-scale", "mtlx-disagrees")  # fmt: skip
in_text("another_sett", LOOK, "weave:endsPerCm = 20", "weave:endsPerCm = 21", "sett-disagrees")
in_text(
    "preview_unplugged",
    LOOK,
    "        token outputs:surface.connect = "
    "</shot_twill/Material/PreviewSurface.outputs:surface>\n",
    "",
    "preview-missing",
)
in_text(
    "materialx_unplugged",
    LOOK,
    "        token outputs:mtlx:surface.connect = </shot_twill/Material/MtlxSurface.outputs:out>\n",
    "",
    "mtlx-missing",
)
in_text("materialx_of_no_version", LOOK, 'string config:mtlx:version = "1.39"',
        "string config:mtlx:version", "mtlx-version")  # fmt: skip
in_text("unknown_input", LOOK, "            float inputs:metallic = 0\n",
        "            float inputs:metallic = 0\n            float inputs:sheen = 1\n",
        "input-unknown")  # fmt: skip
in_text("unknown_input_of_the_exact_shader", LOOK, "            float[] inputs:tau = [0, 0]\n",
        "            float[] inputs:tau = [0, 0]\n            float inputs:sparkle = 1\n",
        "input-unknown")  # fmt: skip
in_text("color_space_of_usd", LOOK, 'colorSpace = "srgb_texture"', 'colorSpace = "sRGB"',
        "color-space-name")  # fmt: skip
in_text("linear_preview_color", LOOK, 'inputs:sourceColorSpace = "sRGB"',
        'inputs:sourceColorSpace = "raw"', "color-space-wrong")  # fmt: skip
in_text("unstated_color_space", LOOK, ' (\n                colorSpace = "srgb_texture"\n'
        "            )", "", "color-space-wrong")  # fmt: skip
in_text("another_color_space_than_the_files", LOOK, 'weave:colorSpace = "lin_rec709"',
        'weave:colorSpace = "acescg"',
        "color-space-tag", "color-space-wrong", "encodings-disagree")  # fmt: skip
in_text("unknown_color_space", LOOK, 'weave:colorSpace = "lin_rec709"',
        'weave:colorSpace = "sRGB"', "cloth-token")  # fmt: skip
in_text("decoded_ids", LOOK, "@./textures/yarn_id.png@\n",
        '@./textures/yarn_id.png@ (\n                colorSpace = "srgb_texture"\n'
        "            )\n", "color-space-wrong")  # fmt: skip
in_text("decoded_directions", LOOK, "@./textures/rotation.exr@\n",
        '@./textures/rotation.exr@ (\n                colorSpace = "srgb_texture"\n'
        "            )\n", "color-space-wrong")  # fmt: skip
in_text("decoded_moments", LOOK, "@./textures/warp_albedo.exr@\n",
        '@./textures/warp_albedo.exr@ (\n                colorSpace = "acescg"\n'
        "            )\n", "color-space-wrong")  # fmt: skip
in_text("unknown_node", LOOK, '"ND_multiply_vector2"', '"ND_multiply_vector9"', "usd-error")

# --- The MaterialX document -----------------------------------------------------------------------


@in_files("mtlx-broken")
def document_cut_short(folder: Path) -> None:
    text = (folder / MTLX).read_text()
    (folder / MTLX).write_text(text[: len(text) // 2])


in_text("document_of_unknown_nodes", MTLX, "<multiply ", "<multiplicate ", "mtlx-broken")
in_text("document_of_unknown_types", MTLX, '<image name="opacity_map" type="float">',
        '<image name="opacity_map" type="integer">',
        "mtlx-broken", "mtlx-node", "mtlx-disagrees")  # fmt: skip
in_text("document_of_no_color_space", MTLX, ' colorspace="lin_rec709"', "", "mtlx-color-space")
in_text(
    "document_of_other_files",
    MTLX,
    "textures/normal.png",
    "../normal.png",
    "mtlx-file",
    "mtlx-disagrees",
)

# --- Textures -------------------------------------------------------------------------------------


@in_files("texture-unreadable")
def texture_cut_short(folder: Path) -> None:
    path = folder / "textures" / "normal.exr"
    path.write_bytes(path.read_bytes()[:600])


@in_files("texture-format")
def opacity_in_color(folder: Path) -> None:
    rewrite(folder / "textures" / "opacity.png", lambda pixels: np.repeat(pixels, 3, axis=2))


in_text("another_resolution", LOOK, "weave:textureWidth = 64", "weave:textureWidth = 128",
        "texture-size")  # fmt: skip


@in_files("texture-not-finite", "moments-disagree")
def not_a_number_in_a_texture(folder: Path) -> None:
    def change(pixels: NDArray) -> None:
        pixels[3, 4, 1] = np.nan

    rewrite(folder / "textures" / "normal.exr", change)


@in_channels("vector-not-unit", "frame-not-orthogonal", "normal-not-of-height")
def gamma_encoded_normals(channels: Channels) -> None:
    normal = channels["normal"]
    normal[...] = 2 * (normal / 2 + 0.5) ** (1 / 2.2) - 1


@in_channels("vector-not-unit")
def tangents_of_half_length(channels: Channels) -> None:
    channels["tangent"][5, 6] *= 0.5


@in_channels("normal-below")
def a_normal_into_the_cloth(channels: Channels) -> None:
    channels["normal"][5, 6] *= -1


@in_channels("frame-not-orthogonal")
def tangents_turned_out_of_the_surface(channels: Channels) -> None:
    channels["tangent"][10:20] = channels["normal"][10:20]


@in_files("frame-not-orthogonal", "encodings-disagree", "moments-disagree")
def a_texture_row_turned_round(folder: Path) -> None:
    def change(pixels: NDArray) -> None:
        pixels[7] = pixels[7, ::-1].copy()

    rewrite(folder / "textures" / "normal.exr", change)


@in_channels("albedo-range")
def a_yarn_that_makes_light(channels: Channels) -> None:
    channels["base_color"][2, 8] = 1.5


@in_channels("height-above-crown")
def a_height_above_the_crown(channels: Channels) -> None:
    channels["height"][2, 8] = 0.01


@in_channels("height-below-cloth")
def a_height_below_the_cloth(channels: Channels) -> None:
    channels["height"][0, 0] = -3


@in_channels("opacity-between")
def a_half_open_texel(channels: Channels) -> None:
    channels["opacity"][8, 8] = 0.5


@in_channels("gap-disagrees")
def an_opaque_gap(channels: Channels) -> None:
    gaps = channels["yarn_id"] == GAP
    row, column, _ = np.argwhere(gaps)[0]
    channels["opacity"][row, column] = 1


@in_files("yarn-id-unknown", "moments-disagree")
def a_yarn_id_beyond_the_list(folder: Path) -> None:
    def change(pixels: NDArray) -> None:
        pixels[8, 8] = 77

    rewrite(folder / "textures" / "yarn_id.png", change)


@in_channels("yarn-id-unused", "weave-disagrees")
def a_weft_that_is_not_there(channels: Channels) -> None:
    weft = channels["yarn_id"] == 1
    for name in ("yarn_id", "system"):
        channels[name][weft] = GAP
    channels["opacity"][weft] = 0


@in_files("encodings-disagree")
def a_preview_of_another_color(folder: Path) -> None:
    def change(pixels: NDArray) -> None:
        pixels[pixels > 100] += 2

    rewrite(folder / "textures" / "base_color.png", change)


@in_channels("normal-not-of-height")
def normals_upside_down(channels: Channels) -> None:
    channels["normal"][..., 1] *= -1
    channels["tangent"][..., 1] *= -1


@in_channels("fibre-across")
def fibres_turned_in_the_surface(channels: Channels) -> None:
    channels["tangent"][...] = np.cross(channels["normal"], channels["tangent"])


@in_channels("tile-seam")
def three_rows_cut_off(channels: Channels) -> None:
    for name, values in channels.items():
        channels[name] = values[:-3]


@in_channels("tile-seam", "tile-cut")
def six_rows_cut_off(channels: Channels) -> None:
    for name, values in channels.items():
        channels[name] = values[:-6]


@in_channels("tile-seam")
def three_columns_cut_off(channels: Channels) -> None:
    for name, values in channels.items():
        channels[name] = values[:, :-3]


in_text("another_weave", LOOK, "weave:drawdownSha256 = \"1", "weave:drawdownSha256 = \"2",
        "drawdown-disagrees", "draft-disagrees")  # fmt: skip

in_text("another_colorway", LOOK, "weave:yarn:ecru:color = (0.6, 0.5, 0.4)",
        "weave:yarn:ecru:color = (0.6, 0.5, 0.9)", "color-disagrees")  # fmt: skip
in_text("another_cover", LOOK, "weave:cover = 0.875", "weave:cover = 0.9", "cover-disagrees")


@in_channels("color-disagrees", "color-misplaced")
def colors_shifted_by_three_rows(channels: Channels) -> None:
    channels["base_color"] = np.roll(channels["base_color"], 3, axis=0)


# --- Moment maps ----------------------------------------------------------------------------------

in_text("a_map_that_is_not_named", LOOK,
        "            asset inputs:warp_along_file = @./textures/warp_along.exr@\n", "",
        "moments-incomplete")  # fmt: skip
in_text("a_system_without_kinds", LOOK, "            int[] inputs:weft_kinds = [2]\n", "",
        "moments-incomplete")  # fmt: skip
in_text("a_list_without_maps", LOOK, "weave:momentMaps = [@./textures/warp_slopes.exr@, ",
        "weave:momentMaps = [", "moments-file")  # fmt: skip
in_text("a_map_of_the_other_system", LOOK,
        "inputs:warp_along_file = @./textures/warp_along.exr@",
        "inputs:warp_along_file = @./textures/weft_along.exr@", "moments-file")  # fmt: skip
in_text("a_section_of_three_numbers", LOOK, "float2 inputs:warp_section = (0.5681818, 0.10785474)",
        "float3 inputs:warp_section = (0.5681818, 0.10785474, 0)",
        "moments-type", "usd-error")  # fmt: skip
in_text("a_section_of_no_yarn", LOOK, "float2 inputs:warp_section = (0.5681818,",
        "float2 inputs:warp_section = (-0.5681818,", "section-wrong")  # fmt: skip
in_text("a_section_of_another_yarn", LOOK, "float2 inputs:weft_section = (0.5681818,",
        "float2 inputs:weft_section = (1,", "section-wrong", "moments-disagree")  # fmt: skip
in_text("yarns_of_another_bend", LOOK, "inputs:warp_section = (0.5681818, 0.10785474)",
        "inputs:warp_section = (0.5681818, 3)", "moments-disagree")  # fmt: skip
in_text("a_kind_of_the_other_system", LOOK, "inputs:warp_kinds = [1]", "inputs:warp_kinds = [2]",
        "kinds-wrong")  # fmt: skip


@in_files("moments-unreadable")
def a_map_cut_short(folder: Path) -> None:
    path = folder / "textures" / "weft_slopes.exr"
    path.write_bytes(path.read_bytes()[:-200])


@in_files("moments-format")
def a_map_of_three_channels(folder: Path) -> None:
    path = folder / "textures" / "warp_across.exr"
    rewrite(path, lambda pixels: np.ascontiguousarray(pixels[..., :3]))


@in_files("moments-format")
def a_map_of_half_the_size(folder: Path) -> None:
    path = folder / "textures" / "warp_across.exr"
    rewrite(path, lambda pixels: np.ascontiguousarray(pixels[::2, ::2]))


@in_files("moments-range", "moments-disagree")
def more_yarn_than_there_is_room_for(folder: Path) -> None:
    rewrite(folder / "textures" / "warp_slopes.exr", lambda pixels: pixels * np.float16(2))


@in_files("moments-range", "moments-disagree")
def a_mean_without_its_squares(folder: Path) -> None:
    def change(pixels: NDArray) -> None:
        pixels[..., 1] = 0

    rewrite(folder / "textures" / "warp_along.exr", change)


@in_files("moments-range", "moments-disagree")
def a_mean_that_is_no_number(folder: Path) -> None:
    def change(pixels: NDArray) -> None:
        pixels[3, 3, 2] = np.nan

    rewrite(folder / "textures" / "weft_across.exr", change)


@in_files("moments-disagree")
def maps_of_last_week(folder: Path) -> None:
    for path in (folder / "textures").glob("w*_*.exr"):
        rewrite(path, lambda pixels: np.roll(pixels, 1, axis=0))


@in_files("moments-disagree")
def colors_of_last_week_from_afar(folder: Path) -> None:
    def change(pixels: NDArray) -> None:
        pixels[..., :3] *= np.float16(0.95)

    rewrite(folder / "textures" / "warp_albedo.exr", change)


@in_files("moments-disagree", "distance-level", profile="standard")
def a_cloth_that_darkens_with_its_distance(folder: Path) -> None:
    for system in ("warp", "weft"):

        def change(pixels: NDArray) -> None:
            pixels[..., :3] *= np.float16(0.7)

        rewrite(folder / "textures" / f"{system}_albedo.exr", change)


# --- The draft ------------------------------------------------------------------------------------


@in_files("draft-broken")
def a_draft_of_no_weave(folder: Path) -> None:
    (folder / "draft.wif").write_text("[WIF]\nVersion=1.1\n")


in_text("a_draft_of_three_ends", "draft.wif", "[WARP]\nThreads=4", "[WARP]\nThreads=3",
        "draft-broken")  # fmt: skip


@in_files("draft-size")
def a_draft_of_another_size(folder: Path) -> None:
    three = np.eye(3, dtype=bool)
    (folder / "draft.wif").write_bytes(drawn(three))


in_text("another_draft", "draft.wif", "1=1,2\n", "1=1,3\n", "draft-disagrees", "weave-disagrees")


@in_files("weave-disagrees", "system-disagrees")
def warp_and_weft_swapped_in_one_map(folder: Path) -> None:
    rewrite(folder / "textures" / "system.png", lambda pixels: np.where(pixels, 3 - pixels, 0))


@in_files("system-disagrees")
def a_texel_of_the_other_system(folder: Path) -> None:
    def change(pixels: NDArray) -> None:
        pixels[8, 8] = 3 - pixels[8, 8]

    rewrite(folder / "textures" / "system.png", change)


in_text("two_yarns_on_one_thread", LOOK, 'weave:yarn:indigo:system = "weft"',
        'weave:yarn:indigo:system = "warp"',
        "thread-mixed", "system-disagrees", "drawdown-disagrees", "fibre-across",
        "kinds-wrong", "moments-disagree")  # fmt: skip

# --- What the thesis's own code did -------------------------------------------------------------


@in_channels("fibre-across", "frame-not-orthogonal")
def weft_tangents_by_the_formula_of_the_warp(channels: Channels) -> None:
    weft = channels["system"][..., 0] == 1
    channels["tangent"][weft] = channels["tangent"][weft][:, [1, 0, 2]]


@in_channels("normal-of-other-slope", "frame-not-orthogonal")
def weft_normals_with_exchanged_curvatures(channels: Channels) -> None:
    weft = channels["system"][..., 0] == 1
    normal = channels["normal"][weft]
    slopes = normal[:, :2] / normal[:, 2:] * (ACROSS / ALONG, ALONG / ACROSS)
    turned = np.concatenate([slopes, np.ones((len(slopes), 1))], axis=1)
    channels["normal"][weft] = turned / np.linalg.norm(turned, axis=1, keepdims=True)


@in_files("vector-not-unit", "frame-not-orthogonal", "normal-not-of-height", "encodings-disagree",
          "moments-disagree")  # fmt: skip
def normals_gamma_encoded_in_the_linear_file(folder: Path) -> None:
    def change(pixels: NDArray) -> NDArray:
        encoded = 2 * (pixels.astype(float) / 2 + 0.5) ** (1 / 2.2) - 1
        return encoded.astype(pixels.dtype)

    rewrite(folder / "textures" / "normal.exr", change)


@in_channels("fibre-across")
def tangents_along_the_other_axis_of_the_frame(channels: Channels) -> None:
    channels["tangent"][...] = np.cross(channels["tangent"], channels["normal"])


@in_channels("float-cut")
def floats_cut_at_the_edge(channels: Channels) -> None:
    colors = (0.6, 0.5, 0.4), (0.05, 0.06, 0.2)
    channels.update(surface(TWILL, colors, cyclic=False))


@in_channels("color-disagrees")
def colors_a_tenth_too_light(channels: Channels) -> None:
    channels["base_color"] *= 1.1


# --- Other readers -------------------------------------------------------------------------------

in_text("another_base_weight", MTLX, '<input name="base_weight" type="float" value="1"',
        '<input name="base_weight" type="float" value="0.9"', "mtlx-disagrees")  # fmt: skip


def tx_of(
    folder: Path,
    change: Callable[[NDArray], NDArray] = np.asarray,
    file: str = "opacity.png",
    **levels: bool,
) -> None:
    """Write the .tx of `file` by OpenImageIO's own means, from the texture as `change` makes it."""
    textures = folder / "textures"
    source = OpenImageIO.ImageBuf(str(textures / file))
    pixels = source.get_pixels(OpenImageIO.FLOAT)
    changed = np.ascontiguousarray(change(pixels), np.float32)
    height, width, channels = changed.shape
    spec = OpenImageIO.ImageSpec(width, height, channels, OpenImageIO.HALF)
    made = OpenImageIO.ImageBuf(spec)
    made.set_pixels(OpenImageIO.ROI(), changed)
    target = str((textures / file).with_suffix(".tx"))
    config = OpenImageIO.ImageSpec()
    config.attribute("maketx:nomipmap", 0 if levels.get("whole", True) else 1)
    config.attribute("maketx:fileformatname", "openexr")
    config.attribute("DateTime", "2000:01:01 00:00:00")
    assert OpenImageIO.ImageBufAlgo.make_texture(OpenImageIO.MakeTxTexture, made, target, config), (
        OpenImageIO.geterror()
    )


@in_files("mip-broken")
def a_tx_that_is_none(folder: Path) -> None:
    (folder / "textures" / "normal.tx").write_bytes(b"nothing")


@in_files("mip-missing")
def a_tx_of_one_level(folder: Path) -> None:
    tx_of(folder, whole=False)


@in_files("mip-disagrees")
def a_tx_of_an_older_texture(folder: Path) -> None:
    tx_of(folder, lambda pixels: np.roll(pixels, 5, axis=0))


@in_files("mip-disagrees", "mip-range")
def a_tx_twice_as_bright(folder: Path) -> None:
    tx_of(folder, lambda pixels: pixels * 2)


@in_files("mip-disagrees")
def a_tx_of_an_older_map(folder: Path) -> None:
    tx_of(folder, lambda pixels: np.roll(pixels, 5, axis=0), "weft_along.exr")


# --- Lobe maps ------------------------------------------------------------------------------------

Levels = Callable[[int, NDArray], NDArray]


def in_levels(path: Path, change: Levels) -> None:
    """Change the texels of each level of the tiled file `path`, whose number is told."""
    reading = OpenImageIO.ImageInput.open(str(path))
    levels = []
    while reading.seek_subimage(0, len(levels)):
        spec = reading.spec()
        levels.append((spec, reading.read_image(0, len(levels), 0, spec.nchannels, spec.format)))
    reading.close()
    writing = OpenImageIO.ImageOutput.create("openexr")
    for level, (spec, pixels) in enumerate(levels):
        assert writing.open(str(path), spec, "AppendMIPLevel" if level else "Create")
        assert writing.write_image(np.ascontiguousarray(change(level, pixels)))
    writing.close()


@in_files("lobes-broken")
def a_lobe_map_without_tiles(folder: Path) -> None:
    rewrite(folder / "textures" / "preview_roughness.exr", np.asarray)


@in_files("lobes-levels")
def a_lobe_map_of_one_level(folder: Path) -> None:
    tx_of(folder, file="preview_roughness.exr", whole=False)
    textures = folder / "textures"
    (textures / "preview_roughness.tx").rename(textures / "preview_roughness.exr")


@in_files("lobes-disagree")
def lobes_of_last_week(folder: Path) -> None:
    path = folder / "textures" / "roughness.exr"
    in_levels(path, lambda level, pixels: pixels if level else np.roll(pixels, 3, axis=0))


@in_files("lobes-disagree")
def even_lobes_of_last_week(folder: Path) -> None:
    path = folder / "textures" / "preview_roughness.exr"
    in_levels(path, lambda level, pixels: np.roll(pixels, 3, axis=0))


@in_files("lobes-mixed", "lobes-disagree")
def a_texel_of_another_lobe(folder: Path) -> None:
    def change(pixels: NDArray) -> None:
        pixels[8, 8] //= 2

    rewrite(folder / "textures" / "roughness.png", change)


@in_files("lobes-mixed")
def a_lobe_in_the_gaps(folder: Path) -> None:
    textures = folder / "textures"
    opacity = OpenImageIO.ImageBuf(str(textures / "opacity.png")).get_pixels("uint8")
    rewrite(textures / "roughness.png", lambda p: np.where(opacity == 0, 204, p).astype(p.dtype))

    def change(level: int, pixels: NDArray) -> NDArray:
        return pixels if level else np.where(opacity == 0, 0.8, pixels).astype(pixels.dtype)

    in_levels(textures / "roughness.exr", change)


@in_files("lobes-turned")
def highlights_along_the_fibres(folder: Path) -> None:
    textures = folder / "textures"
    rewrite(textures / "rotation.png", lambda pixels: 255 - pixels)
    in_levels(textures / "rotation.exr", lambda level, pixels: -pixels)


@in_files("lobes-range")
def lobes_rougher_than_rough_from_afar(folder: Path) -> None:
    path = folder / "textures" / "preview_roughness.exr"
    in_levels(path, lambda level, pixels: pixels * np.float16(1 + (level > 0)))


@in_files("lobes-narrow")
def razors_from_afar(folder: Path) -> None:
    path = folder / "textures" / "roughness.exr"
    in_levels(path, lambda level, pixels: pixels * np.float16(0.4 if level else 1))


# --- Optics --------------------------------------------------------------------------------------


@in_files("energy-gained", "normalization-disagrees")
def a_yarn_that_makes_light_of_its_own(folder: Path) -> None:
    restate(folder, "normalization", 4.0)


@in_files("normalization-disagrees")
def a_normalization_of_another_yarn(folder: Path) -> None:
    restate(folder, "normalization", 1.5)


# --- Renders -------------------------------------------------------------------------------------


@in_files("energy-gained", "normalization-disagrees", "furnace-above", "swatch-color",
          "preview-far", "moments-disagree", "distance-level", profile="standard")  # fmt: skip
def a_cloth_that_glows_in_a_furnace(folder: Path) -> None:
    restate(folder, "normalization", 6.0)
    restate(folder, "albedoGain", 5.0, "albedo_gain")


@in_files("swatch-color", "moments-disagree", "distance-level", profile="standard")
def a_gain_of_another_weave(folder: Path) -> None:
    restate(folder, "albedoGain", 0.9, "albedo_gain")


@in_files("render-refused", "normalization-disagrees", profile="standard")
def a_lobe_narrower_than_is_rendered(folder: Path) -> None:
    restate(folder, "gammaS", 5e-4, "gamma_s")


@in_files("preview-far", profile="standard")
def a_preview_that_shines(folder: Path) -> None:
    look = folder / LOOK
    shader = 'uniform token info:id = "UsdPreviewSurface"\n'
    text = look.read_text()
    assert shader in text
    color = "            color3f inputs:emissiveColor = (3, 0, 0)\n"
    look.write_text(text.replace(shader, shader + color))


def restate(folder: Path, attribute: str, value: float, shader_input: str = "") -> None:
    """State another `value` for both yarns, in the attributes and in the exact shader."""
    look = folder / LOOK
    text = re.sub(rf"(weave:yarn:\w+:{attribute} = )\S+", rf"\g<1>{value}", look.read_text())
    name = shader_input or attribute
    text = re.sub(rf"(inputs:{name} = \[)[^]]*", rf"\g<1>{value}, {value}", text)
    look.write_text(text)


# --- Other doors ----------------------------------------------------------------------------------

DOOR_FILES = {"usdz": "shot_twill.usdz", "glb": "shot_twill.glb", "u3m": "shot_twill.u3m"}


def with_doors(folder: Path) -> None:
    """Write every door of the asset that stands in `folder`."""
    write_doors(cloth(), folder, ("usdz", "gltf", "u3m"))


@in_files("door-disagrees")
def a_package_of_last_week(folder: Path) -> None:
    with_doors(folder)
    with zipfile.ZipFile(folder / DOOR_FILES["usdz"]) as old:
        (folder / "root.usdc").write_bytes(old.read("shot_twill.usdc"))
    (folder / DOOR_FILES["usdz"]).unlink()
    other = folder / "other.png"
    other.write_bytes((folder / "textures" / "opacity.png").read_bytes())
    write_package(
        folder / DOOR_FILES["usdz"],
        [("shot_twill.usdc", folder / "root.usdc"), ("textures/normal.png", other)],
    )
    other.unlink()
    (folder / "root.usdc").unlink()


@in_files("door-broken")
def a_package_that_is_compressed(folder: Path) -> None:
    with zipfile.ZipFile(folder / DOOR_FILES["usdz"], "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("shot_twill.usda", "#usda 1.0\n" * 100)


@in_files("door-broken")
def a_package_that_is_not_aligned(folder: Path) -> None:
    with zipfile.ZipFile(folder / DOOR_FILES["usdz"], "w") as archive:
        archive.writestr("shot_twill.usda", "#usda 1.0\n")


@in_files("door-broken")
def a_gltf_cut_short(folder: Path) -> None:
    with_doors(folder)
    path = folder / DOOR_FILES["glb"]
    path.write_bytes(path.read_bytes()[:-100])


@in_files("door-disagrees")
def a_gltf_of_another_size(folder: Path) -> None:
    with_doors(folder)
    path = folder / DOOR_FILES["glb"]
    data = path.read_bytes()
    scale = re.search(rb'"scale":\[(\d)', data)
    assert scale
    digit = b"1" if scale[1] != b"1" else b"2"
    path.write_bytes(data.replace(scale[0], scale[0][:-1] + digit))


@in_files("door-broken")
def a_u3m_that_is_no_json(folder: Path) -> None:
    (folder / DOOR_FILES["u3m"]).write_text("{")


@in_files("door-disagrees")
def a_u3m_with_a_picture_elsewhere(folder: Path) -> None:
    with_doors(folder)
    path = folder / DOOR_FILES["u3m"]
    path.write_text(path.read_text().replace("textures/normal.png", "../normal.png"))


# --- The manifest ---------------------------------------------------------------------------------


@in_files("manifest-changed", sealed=False)
def a_flipped_bit(folder: Path) -> None:
    path = folder / "draft.wif"
    data = bytearray(path.read_bytes())
    data[5] ^= 1
    path.write_bytes(data)


@in_files("manifest-added", sealed=False)
def an_added_file(folder: Path) -> None:
    (folder / "notes.txt").write_text("mine")


@in_files("manifest-gone", "path-missing", "usd-error", "draft-broken", sealed=False)
def a_file_gone(folder: Path) -> None:
    (folder / "draft.wif").unlink()


@in_files("manifest-broken", sealed=False)
def a_manifest_of_another_form(folder: Path) -> None:
    (folder / MANIFEST_FILE).write_text("[]")


@in_files("manifest-digest", sealed=False)
def a_manifest_of_another_digest(folder: Path) -> None:
    path = folder / MANIFEST_FILE
    path.write_text(re.sub(r'(content_sha256": ")\w', r"\1-", path.read_text()))
