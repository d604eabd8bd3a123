"""What makers and judges share: channels, shader inputs, attribute and file names.

A name is spelled here once. Tests hold the schema, the networks, the translator and the BSDF
to it. Nothing here computes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

Encoding = Literal["color", "vector", "scalar", "label"]
ColorSpace = Literal["lin_rec709", "acescg"]

COLOR_SPACES: tuple[ColorSpace, ...] = ("lin_rec709", "acescg")
"""Spaces that a cloth's colors may be in, linear both, by the names of MaterialX."""


@dataclass(frozen=True, slots=True)
class Channel:
    """One texture channel of a cloth.

    `components` values a texel. `encoding` says how the numbers mean something: `color` is
    linear reflectance in the color space of the cloth, under the sRGB curve and in Rec.709 in a
    PNG; `vector` is a unit vector in the cloth frame, components -1…1; `scalar` a number in
    `unit`; `label` an integer that must never be filtered.
    `files` are the names, below the asset's texture folder, that carry the channel. `per_yarn`
    marks channels that follow from each yarn's fit to the standard shaders. Of scalars in 8 bits,
    `low` is what 0 stands for; 255 stands for 1.
    """

    name: str
    components: int
    encoding: Encoding
    unit: str
    files: tuple[str, ...]
    meaning: str
    per_yarn: bool = False
    low: float = 0.0


# The .png files serve renderers that others wrote; the .exr files hold what the exact BSDF reads.
CHANNELS: dict[str, Channel] = {
    c.name: c
    for c in (
        Channel("base_color", 3, "color", "1", ("base_color.png", "base_color.exr"),
                "albedo of the yarn on top"),
        Channel("normal", 3, "vector", "1", ("normal.png", "normal.exr"),
                "unit normal of the yarn's surface, cloth frame"),
        Channel("tangent", 3, "vector", "1", ("tangent.png", "tangent.exr"),
                "unit direction of the fibre, cloth frame, orthogonal to normal"),
        Channel("height", 1, "scalar", "mm", ("height.exr",),
                "height above the crown of the highest float, hence never positive"),
        Channel("opacity", 1, "scalar", "1", ("opacity.png",),
                "1 where there is yarn, 0 in the gaps between yarns"),
        Channel("yarn_id", 1, "label", "1", ("yarn_id.png",),
                "index of the yarn plus one; 0 in gaps"),
        Channel("system", 1, "label", "1", ("system.png",),
                "1 warp, 2 weft, 0 in gaps"),
        Channel("fibre_angle", 2, "scalar", "1", ("fibre_angle.exr",),
                "cos 2φ and sin 2φ of the fibre's angle φ to X, which a mip map may average"),
        Channel("ambient_occlusion", 1, "scalar", "1", ("ambient_occlusion.png",),
                "share of the sky that the heights around leave visible"),
        Channel("roughness", 1, "scalar", "1", ("roughness.png",),
                "specular roughness of OpenPBR, for standard shaders; 1 on loose hairs",
                per_yarn=True),
        Channel("rotation", 3, "scalar", "1", ("rotation.png",),
                "(cos 2φ, sin 2φ, 0) p; the highlight is wide towards φ, from X about the normal, "
                "and p = (α_t − α_b) / (α_t + α_b) of its α across and along the fibre",
                per_yarn=True, low=-1.0),
    )
}  # fmt: skip

GAP = -1
"""Yarn index of a texel without yarn, in memory. Files store the index plus one."""

VECTOR_PNG_LEVELS = 65534
"""A component q of a vector in a 16-bit PNG is round((q/2 + 1/2) · 65534): 0 is exact."""

# --- Moment maps: what the yarns do under a texel, for a cloth seen from afar -------------------

SYSTEMS = ("warp", "weft")


@dataclass(frozen=True, slots=True)
class MomentMap:
    """A map of one system of threads: what its four components hold, linear all of them.

    S is the place along a float, X the place across the yarn, P the sine of the twist, as in
    `synth.moments`. Each component is a mean over a texel, a the system's opacity in it: 0
    everywhere for a system that never shows, which has its maps all the same.
    """

    name: str
    components: tuple[str, str, str, str]
    meaning: str


MOMENT_MAPS: dict[str, MomentMap] = {
    m.name: m
    for m in (
        MomentMap("slopes", ("a flat", "a rising", "a falling", "a X"),
                  "shares of straight, rising and falling yarn, and the place across"),
        MomentMap("along", ("a S rising", "a S² rising", "a S falling", "a S² falling"),
                  "place along the float"),
        MomentMap("across", ("a |X|", "a X²", "a P", "a P²"), "place across the yarn, and twist"),
        MomentMap("albedo", ("a A red", "a A green", "a A blue", "a"),
                  "albedo A of the fibre, premultiplied, and opacity"),
        MomentMap("kinds", ("a kind 1", "a kind 2", "a kind 3", "a kind 4"),
                  "opacity of the yarns of each kind; only of systems with unlike yarns"),
    )
}  # fmt: skip

KINDS = "kinds"
"""The map that a system lacks whose yarns scatter alike."""

MAX_KINDS = 4
"""Kinds of yarn that the maps of a system tell apart."""

MOMENT_TEXELS_A_THREAD = 4
"""Texels of a moment map from thread to thread, where the textures have as many."""

MAX_MOMENT_TEXELS = 1 << 18
"""Texels of a moment map; a cloth of more threads has fewer of them a thread."""


def moment_file(system: str, name: str) -> str:
    """Return the texture file of a moment map of `system`."""
    return f"{system}_{name}.exr"


def moment_input(system: str, name: str) -> str:
    """Return the asset input of the shader for a moment map of `system`; assets may lack it."""
    return f"{system}_{name}_file"


def section_input(system: str) -> str:
    """Return the shader's float2 of thickness over width and curvature of the yarns of `system`."""
    return f"{system}_section"


def kinds_input(system: str) -> str:
    """Return the shader's int[] of the yarn ids, from 1, that stand for the kinds of `system`.

    There is at least one, and a map of kinds where there are several.
    """
    return f"{system}_kinds"


def moment_inputs() -> dict[str, str]:
    """Return the Sdf type of every input of the shader that the moment maps need, by name."""
    inputs = {moment_input(s, name): "asset" for s in SYSTEMS for name in MOMENT_MAPS}
    sections = dict.fromkeys(map(section_input, SYSTEMS), "float2")
    return inputs | sections | dict.fromkeys(map(kinds_input, SYSTEMS), "int[]")


def moment_names(kinds: int) -> tuple[str, ...]:
    """Return the names of the maps of a system that has so many kinds of yarn."""
    return tuple(name for name in MOMENT_MAPS if name != KINDS or kinds > 1)


# --- Lobe maps: how wide and in which direction highlights lie, for the standard shaders --------


@dataclass(frozen=True, slots=True)
class LobeMap:
    """A map whose file holds all mip levels, the coarse ones with lobes as wide as what they cover.

    The finest level is that of the channel of the same name, where there is one.
    """

    name: str
    components: int
    meaning: str


LOBE_MAPS: dict[str, LobeMap] = {
    m.name: m
    for m in (
        LobeMap("roughness", 1, "specular roughness of OpenPBR"),
        LobeMap("rotation", 3, "(cos 2φ, sin 2φ, 0) p, where the highlight is wide, and how much"),
        LobeMap("preview_roughness", 1, "roughness of UsdPreviewSurface"),
    )
}  # fmt: skip


def lobe_file(name: str) -> str:
    """Return the texture file of a lobe map."""
    return f"{name}.exr"


# --- The exact shader, on `outputs:mitsuba:surface` -------------------------------------------

MITSUBA_CONTEXT = "mitsuba"
GLSLFX_CONTEXT = "glslfx"
CLOTH_SHADER_ID = "weaveusd_cloth"
MAX_YARNS = 255
"""Yarns in one material: the yarn id is stored in 8 bits, 0 being the gap."""

SHADER_FILES: dict[str, str] = {
    "base_color_file": "base_color.exr",
    "normal_file": "normal.exr",
    "tangent_file": "tangent.exr",
    "height_file": "height.exr",
    "opacity_file": "opacity.png",
    "yarn_id_file": "yarn_id.png",
}
"""Asset inputs of the shader and the texture file that each one names."""

SHADER_YARN_INPUTS: dict[str, str] = {
    "eta": "index of refraction of the fibre",
    "k_d": "share of isotropic scattering in the volume lobe, 0…1",
    "k_s": "scale of the surface lobe, 0…1",
    "gamma_s": "width of the surface lobe in radians",
    "gamma_v": "width of the volume lobe in radians",
    "tau": "share of the volume lobe that leaves on the other side, 0…1",
    "normalization": "N_V, the factor that makes A an albedo",
}
"""The optics, inputs of type float[], one value a yarn, in the order of the yarn ids."""

SHADER_ALBEDO_GAIN = "albedo_gain"
"""float[]: factors from the base color to A. Assets of older versions lack it; it is 1 there."""

SHADER_YARN_ARRAYS: dict[str, str] = {
    **SHADER_YARN_INPUTS,
    SHADER_ALBEDO_GAIN: "factor from the base color to A, the fibre's albedo, which stays within 1",
}
"""Every input with one value a yarn."""

SHADER_UV_SCALE = "uv_scale"
"""float2: repeats of the cloth in one unit of st. As published, st is in metres."""

SHADER_VARNAME = "varname"
"""string: the primvar that holds the texture coordinates."""

DEFAULT_ST = "st"

# --- Schema -----------------------------------------------------------------------------------

CLOTH_API = "WeaveClothAPI"
YARN_API = "WeaveYarnAPI"
CLOTH_NAMESPACE = "weave"
YARN_NAMESPACE = "weave:yarn"


@dataclass(frozen=True, slots=True)
class Attribute:
    """An attribute of our schema: base name in its namespace, Sdf type, unit, meaning.

    `hard` are the limits that a value never leaves, (low, high), None where open; `soft` those of
    usual values, for sliders. `group` is under what interfaces show it and `label` as what, by
    default the words of its name. Assets of older versions lack what is `optional`.
    """

    name: str
    type: str
    unit: str
    meaning: str
    hard: tuple[float | None, float | None] = (None, None)
    tokens: tuple[str, ...] = ()
    group: str = ""
    optional: bool = False
    soft: tuple[float | None, float | None] = (None, None)
    label: str = ""


def _group(name: str, *attributes: Attribute) -> tuple[Attribute, ...]:
    return tuple(replace(attribute, group=name) for attribute in attributes)


CLOTH_ATTRIBUTES: tuple[Attribute, ...] = (
    *_group(
        "Origin",
        Attribute("draftTitle", "string", "", "title of the draft"),
        Attribute("draftSha256", "string", "", "SHA-256 of the draft file as read",
                  label="Draft SHA-256"),
        Attribute("draft", "asset", "", "the draft as clean WIF, beside the asset",
                  label="Draft File"),
        Attribute("recipe", "string", "", "name of the preset or recipe"),
        Attribute("recipeSource", "string", "", "where the recipe's numbers come from"),
        Attribute("recipeFile", "asset", "", "the recipe as used, beside the asset"),
        Attribute("toolVersion", "string", "", "version of weaveusd that made the asset",
                  label="weaveusd Version"),
        Attribute("seed", "int", "", "seed of every irregularity", (0, None)),
    ),
    *_group(
        "Weave",
        Attribute("drawdownSha256", "string", "",
                  "SHA-256 of the drawdown's packed bits, row 0 the first pick, 1 warp on top",
                  label="Drawdown SHA-256"),
        Attribute("ends", "int", "threads", "warp threads in the repeat", (1, None)),
        Attribute("picks", "int", "threads", "weft threads in the repeat", (1, None)),
        Attribute("repeatsAcross", "int", "", "repeats of the draft along the weft in one texture",
                  (1, None), soft=(1, 16)),
        Attribute("repeatsAlong", "int", "", "repeats of the draft along the warp in one texture",
                  (1, None), soft=(1, 16)),
        Attribute("shafts", "int", "", "shafts that the draft uses", (0, None), soft=(2, 32)),
        Attribute("longestFloat", "int", "threads", "longest float of either face", (1, None),
                  soft=(1, 12)),
    ),
    *_group(
        "Size",
        Attribute("endsPerCm", "double", "1/cm", "warp sett", (0.0, None),
                  soft=(2.0, 150.0), label="Ends per cm"),
        Attribute("picksPerCm", "double", "1/cm", "weft sett", (0.0, None),
                  soft=(2.0, 150.0), label="Picks per cm"),
        Attribute("repeatWidth", "double", "mm", "width of the repeat, along the weft",
                  (0.0, None)),
        Attribute("repeatHeight", "double", "mm", "height of the repeat, along the warp",
                  (0.0, None)),
        Attribute("thickness", "double", "mm", "thickness of the cloth", (0.0, None),
                  soft=(0.05, 5.0)),
        Attribute("arealDensity", "double", "g/m²", "weight of the cloth", (0.0, None),
                  soft=(10.0, 1000.0), label="Weight"),
        Attribute("warpCover", "double", "1", "share of the area under warp yarn", (0.0, 1.0)),
        Attribute("weftCover", "double", "1", "share of the area under weft yarn", (0.0, 1.0)),
        Attribute("cover", "double", "1", "share of the area under any yarn", (0.0, 1.0)),
    ),
    *_group(
        "Textures",
        Attribute("colorSpace", "token", "",
                  "color space of base_color.exr and of the yarns' colors",
                  tokens=COLOR_SPACES),
        Attribute("textures", "asset[]", "", "every texture of the cloth but its moment maps"),
        Attribute("textureWidth", "int", "texels", "texels of the repeat along the weft",
                  (1, None)),
        Attribute("textureHeight", "int", "texels", "texels of the repeat along the warp",
                  (1, None)),
        Attribute("momentMaps", "asset[]", "",
                  "every moment map of the cloth: how its yarns lie, for a cloth seen from afar",
                  optional=True),
        Attribute("momentWidth", "int", "texels", "texels of a moment map along the weft",
                  (1, None), optional=True),
        Attribute("momentHeight", "int", "texels", "texels of a moment map along the warp",
                  (1, None), optional=True),
        Attribute("yarns", "token[]", "", "instances of WeaveYarnAPI in the order of the yarn ids"),
    ),
)  # fmt: skip

YARN_ATTRIBUTES: tuple[Attribute, ...] = (
    *_group(
        "Make",
        Attribute("id", "int", "", "value of the yarn id texture, 1 for the first yarn", (1, 255),
                  label="Yarn ID"),
        Attribute("system", "token", "", "system of threads", tokens=("warp", "weft")),
        Attribute("fibre", "token", "", "fibre of the yarn"),
        Attribute("tex", "double", "tex", "linear density, g/km", (0.0, None),
                  soft=(1.0, 1000.0), label="Linear Density"),
        Attribute("plies", "int", "", "singles twisted together", (1, None), soft=(1, 4)),
        Attribute("twist", "double", "1/m", "turns in one metre", (0.0, None), soft=(0.0, 3000.0)),
        Attribute("twistDirection", "token", "", "direction of the twist", tokens=("S", "Z")),
        Attribute("twistAngle", "double", "rad",
                  "angle of the fibre to the yarn's axis, S positive", soft=(-0.8, 0.8)),
        Attribute("packing", "double", "1", "share of fibre in the yarn's section", (0.0, 1.0),
                  soft=(0.4, 0.9), label="Fibre Packing"),
    ),
    *_group(
        "Irregularity",
        Attribute("twistDeviation", "double", "rad", "standard deviation of the twist angle",
                  (0.0, None), soft=(0.0, 0.2), label="Twist Variation"),
        Attribute("thicknessDeviation", "double", "1",
                  "standard deviation of the thickness, relative", (0.0, None),
                  soft=(0.0, 0.5), label="Thickness Variation"),
        Attribute("bendDeviation", "double", "1",
                  "standard deviation of the bend from float to float, relative", (0.0, None),
                  soft=(0.0, 0.3), label="Bend Variation"),
        Attribute("colorDeviation", "double", "ΔE",
                  "standard deviation of the lightness in CIE Lab", (0.0, None),
                  soft=(0.0, 10.0), label="Color Variation"),
        Attribute("hairiness", "double", "1", "light that loose fibres catch beside the yarn",
                  (0.0, 1.0), soft=(0.0, 0.5)),
    ),
    *_group(
        "Size",
        Attribute("width", "double", "mm", "width of the yarn in the cloth", (0.0, None),
                  soft=(0.05, 2.0)),
        Attribute("height", "double", "mm", "thickness of the yarn in the cloth", (0.0, None),
                  soft=(0.02, 2.0)),
        Attribute("crimp", "double", "1", "arc length over chord, less one", (0.0, None),
                  soft=(0.0, 0.3)),
    ),
    *_group(
        "Color",
        Attribute("color", "color3f", "1",
                  "color of the yarn in weave:colorSpace, as d/8° finds it, specular excluded",
                  (0.0, 1.0)),
        Attribute("colorReached", "color3f", "1",
                  "color that the exact shader shows, darker where an albedo of 1 is too little",
                  (0.0, 1.0), label="Rendered Color"),
    ),
    *_group(
        "Optics",
        Attribute("eta", "double", "1", "index of refraction", (1.0, 3.0),
                  soft=(1.3, 1.6), label="IOR"),
        Attribute("kD", "double", "1", "isotropic share of the volume lobe", (0.0, 1.0),
                  label="Volume Isotropy"),
        Attribute("kS", "double", "1", "scale of the surface lobe", (0.0, 1.0),
                  label="Surface Lobe Weight"),
        Attribute("gammaS", "double", "rad", "width of the surface lobe", (0.0, None),
                  soft=(0.02, 0.7), label="Surface Lobe Width"),
        Attribute("gammaV", "double", "rad", "width of the volume lobe", (0.0, None),
                  soft=(0.05, 1.2), label="Volume Lobe Width"),
        Attribute("tau", "double", "1", "transmitted share of the volume lobe", (0.0, 1.0),
                  soft=(0.0, 0.5), label="Transmission"),
        Attribute("normalization", "double", "1", "N_V, from the other numbers", (0.0, None),
                  soft=(0.5, 2.5), label="Volume Normalization"),
        Attribute("albedoGain", "double", "1",
                  "factor from the color to the fibre's albedo that gives the woven yarn its color",
                  (0.0, None), soft=(1.0, 2.5)),
    ),
)  # fmt: skip

# --- Files of an asset --------------------------------------------------------------------------

TEXTURE_DIR = "textures"

Door = Literal["usdz", "gltf", "u3m", "tx"]
"""A format of other programs that an asset can have beside its own."""

DOORS: tuple[Door, ...] = ("usdz", "gltf", "u3m", "tx")
USDZ_SUFFIX = ".usdz"
GLTF_SUFFIX = ".glb"
U3M_SUFFIX = ".u3m"
U3M_DIR = "u3m"
TX_SUFFIX = ".tx"

LOOK_LAYER = "look.usda"
MATERIALX_FILE = "material.mtlx"
EXACT_FILE = "exact.mtlx"
MATERIALX_NODE_DIR = "materialx"
GLSLFX_FILE = "cloth.glslfx"
MANIFEST_FILE = "manifest.json"
DRAFT_FILE = "draft.wif"
RECIPE_FILE = "recipe.toml"
README_FILE = "README.md"
PREVIEW_DIR = "previews"
MATERIAL_NAME = "Material"

COLORWAYS = "colorway"
"""Variant set of the root prim: recipes that are published together."""
MAX_COLORWAYS = 64

MTLX_SURFACES = "mtlxSurface"
"""Variant set of the material: what `outputs:mtlx:surface` leads to."""

MTLX_VARIANTS: dict[str, str] = {"openPbr": "MtlxSurface", "standardSurface": "MtlxStandard"}
"""Its variants, the first being the default, and the shader of each."""

VERSION_PATTERN = r"v\d{3,}"


def entry_layer(asset: str) -> str:
    """Return the file name of the entry layer of the asset named `asset`."""
    return f"{asset}.usda"


def of_colorway(file: str, colorway: str) -> str:
    """Return the name that `file` has in the colorway of that name; "" is the cloth itself.

    ``look.usda`` is ``look.blue.usda`` in a colorway ``blue``, and no asset is called so, since
    names of assets have no dots. Textures of a colorway lie in a folder of its name, as far as
    they differ from those of the cloth.
    """
    stem, dot, suffix = file.partition(".")
    return f"{stem}.{colorway}{dot}{suffix}" if colorway else file
