"""What an asset says about its cloth: a value for every attribute of the schema."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.cloth import measures
from weaveusd.cloth.floats import longest_float
from weaveusd.contract import CHANNELS, LOBE_MAPS, lobe_file
from weaveusd.export.files import CLOTH_ITSELF
from weaveusd.export.moments import moment_files
from weaveusd.export.names import instance_names
from weaveusd.synth.moments import map_size

if TYPE_CHECKING:
    from weaveusd.export.files import LookFiles
    from weaveusd.shading.material import ClothMaterial

Value = str | int | float | tuple[str, ...] | tuple[float, float, float]

MAX_TEXT = 1000


def cloth_values(
    material: ClothMaterial, cover: float, files: LookFiles = CLOTH_ITSELF
) -> dict[str, Value]:
    """Return the value of each of `contract.CLOTH_ATTRIBUTES`, by name.

    `cover` is the mean of the opacity texture: what the asset shows counts, not what the draft
    promises. `files` says where the look's files lie.
    """
    weave, textures, source = material.weave, material.textures, material.provenance
    width, height = weave.repeat_mm
    moment_width, moment_height = map_size(weave, (textures.width, textures.height))
    return {
        "draftTitle": plain_text(source.draft_title),
        "draftSha256": source.draft_sha256,
        "drawdownSha256": hashlib.sha256(np.packbits(weave.warp_up).tobytes()).hexdigest(),
        "draft": f"./{files.draft}",
        "recipe": plain_text(source.recipe),
        "recipeSource": plain_text(source.recipe_source),
        "recipeFile": f"./{files.recipe}",
        "toolVersion": source.tool_version,
        "seed": textures.seed,
        "ends": weave.ends,
        "picks": weave.picks,
        "repeatsAcross": source.repeats[0],
        "repeatsAlong": source.repeats[1],
        "shafts": source.shafts,
        "longestFloat": longest_float(weave.warp_up),
        "endsPerCm": tidy(weave.ends / width * 10),
        "picksPerCm": tidy(weave.picks / height * 10),
        "repeatWidth": tidy(width),
        "repeatHeight": tidy(height),
        "thickness": tidy(measures.thickness_mm(weave)),
        "arealDensity": tidy(measures.areal_density_g_m2(weave)),
        "warpCover": tidy(measures.warp_cover(weave)),
        "weftCover": tidy(measures.weft_cover(weave)),
        "cover": tidy(cover),
        "colorSpace": material.color_space,
        "textures": tuple(
            files.anchored(file)
            for file in (
                *(file for channel in CHANNELS.values() for file in channel.files),
                *map(lobe_file, LOBE_MAPS),
            )
        ),
        "textureWidth": textures.width,
        "textureHeight": textures.height,
        "momentMaps": tuple(files.anchored(file) for file in moment_files(weave)),
        "momentWidth": moment_width,
        "momentHeight": moment_height,
        "yarns": instance_names(yarn.name for yarn in weave.yarns),
    }


def yarn_values(material: ClothMaterial) -> dict[str, dict[str, Value]]:
    """Return the value of each of `contract.YARN_ATTRIBUTES`, by instance name and name."""
    yarns = material.weave.yarns
    names = instance_names(yarn.name for yarn in yarns)
    crimps = measures.crimps(material.weave)
    result: dict[str, dict[str, Value]] = {}
    for index, (name, yarn) in enumerate(zip(names, yarns, strict=True)):
        result[name] = {
            "id": index + 1,
            "system": yarn.system,
            "fibre": plain_text(yarn.fibre),
            "tex": tidy(yarn.tex),
            "plies": yarn.plies,
            "twist": tidy(yarn.twist_per_m),
            "twistDirection": yarn.twist_direction,
            "twistAngle": tidy(yarn.twist_angle),
            "twistDeviation": tidy(yarn.twist_deviation),
            "thicknessDeviation": tidy(yarn.irregularity.thickness),
            "bendDeviation": tidy(yarn.irregularity.bend),
            "colorDeviation": tidy(yarn.irregularity.color),
            "hairiness": tidy(yarn.irregularity.hairiness),
            "packing": tidy(yarn.packing),
            "width": tidy(yarn.width_mm),
            "height": tidy(yarn.height_mm),
            "crimp": tidy(crimps[index]),
            "color": _color(yarn.color),
            "colorReached": _color(material.measured[index].reached),
            "eta": tidy(yarn.optics.eta),
            "kD": tidy(yarn.optics.k_d),
            "kS": tidy(yarn.optics.k_s),
            "gammaS": tidy(yarn.optics.gamma_s),
            "gammaV": tidy(yarn.optics.gamma_v),
            "tau": tidy(yarn.optics.tau),
            "normalization": tidy(material.normalization[index]),
            "albedoGain": tidy(material.measured[index].gain),
        }
    return result


def tidy(value: float) -> float:
    """Return `value` to nine significant digits, as a person would want to read it."""
    return float(f"{value:.9g}")


def _color(color: tuple[float, float, float]) -> tuple[float, float, float]:
    red, green, blue = color
    return tidy(red), tidy(green), tidy(blue)


def plain_text(text: str) -> str:
    """Return `text` on one line, bounded, without what no text file can hold."""
    clean = text.encode("utf-8", "replace").decode("utf-8")
    return " ".join("".join(c if c.isprintable() else " " for c in clean).split())[:MAX_TEXT]
