"""The node `weaveusd_cloth` where moment maps cannot be read: it shows the yarn."""

from __future__ import annotations

import re
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from tests.export.cloths import cloth
from tests.export.glsl import Job, render
from tests.export.node_documents import tile, write_systems
from tests.weaves import satin, twill, woven
from weaveusd.contract import EXACT_FILE, MOMENT_MAPS
from weaveusd.export.asset import write_asset
from weaveusd.shading.shade import shade
from weaveusd.synth.textures import synthesize

LIGHT = (0.3, 0.2, 0.93)
STAND_INS = {
    "zeros": (0, 0, 0, 0),
    "black": (0, 0, 0, 1),
    "white": (1, 1, 1, 1),
    "gray": (0.5, 0.5, 0.5, 1),
    "magenta": (1, 0, 1, 1),
}
"""What renderers show in place of an image that they cannot read."""


def pictures(documents: dict[str, Path], material: str, folder: Path) -> dict[str, np.ndarray]:
    """Return pictures of `material` in `documents`, of a square metre."""
    jobs = [
        Job(str(path), material, str(folder / f"{name}.npy"), LIGHT, eye=20.0, size=16)
        for name, path in documents.items()
    ]
    return dict(zip(documents, render(jobs, folder), strict=True))


def test_a_document_whose_moment_maps_are_not_found_shows_the_yarn(tmp_path):
    weave = woven(twill(), "polyester")
    textures = synthesize(weave, resolution=48)
    material = shade("plain", weave, textures, cloth().provenance)
    write_asset(material, tmp_path, also=["exact"], jobs=1)
    text = (tmp_path / EXACT_FILE).read_text()
    texts = {"yarns": re.sub(r'<input name="moment_texels"[^>]*/>', "", text), "mapped": text}
    for name in (r"\w+", "slopes", "along", "across", "albedo"):
        case = "none" if name == r"\w+" else f"no {name}"
        texts[case] = re.sub(f"textures/(warp|weft)_{name}.exr", "lost.exr", text)
    documents = {name: tmp_path / f"{number}.mtlx" for number, name in enumerate(texts)}
    for name, path in documents.items():
        path.write_text(texts[name])
    found = pictures(documents, "plain", tmp_path)
    yarns, mapped = found.pop("yarns"), found.pop("mapped")
    assert yarns.min() > 0
    assert np.abs(mapped.mean() / yarns.mean() - 1) > 0.05
    for name, picture in found.items():
        np.testing.assert_array_equal(picture, yarns, err_msg=name)


@pytest.mark.slow
@pytest.mark.parametrize(
    "systems", [lambda: tile(twill(), "linen"), lambda: tile(satin(), "silk", 7)],
    ids=["tile", "covered"],
)  # fmt: skip
def test_what_no_yarn_has_is_not_taken_for_a_map(tmp_path, systems):
    mapped = systems()
    maps = [f"warp_{name}" for name in MOMENT_MAPS]
    documents = {
        "yarn": write_systems([], tmp_path / "yarn"),
        "mapped": write_systems(mapped, tmp_path / "mapped"),
    }
    for (stand_in, value), name in product(STAND_INS.items(), ("all", *maps)):
        instead = dict.fromkeys(maps if name == "all" else [name], value)
        case = f"{stand_in} {name}"
        systems_read = [] if name == "all" else mapped
        documents[case] = write_systems(systems_read, tmp_path / case, instead=instead)
    bent_inwards = {"warp_section": (0.6, -1.0)}
    documents["bent inwards"] = write_systems(mapped, tmp_path / "bent", instead=bent_inwards)
    found = pictures(documents, "material", tmp_path)
    yarn, far = found.pop("yarn"), found.pop("mapped")
    assert np.abs(far.mean() / yarn.mean() - 1) > 0.05
    for case, picture in found.items():
        np.testing.assert_array_equal(picture, yarn, err_msg=case)
