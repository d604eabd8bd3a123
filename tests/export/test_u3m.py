"""The U3M is valid by its schema and says what the asset says."""

from __future__ import annotations

import json
import math
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.export import u3m_schema
from tests.export.cloths import FIT, REPEAT_MM, cloth, yarn
from tests.weaves import plain, satin, twill
from weaveusd.cloth import measures
from weaveusd.contract import VECTOR_PNG_LEVELS
from weaveusd.export.asset import write_asset
from weaveusd.export.files import CLOTH_ITSELF
from weaveusd.export.images import read_image, write_png8
from weaveusd.export.u3m import write_u3m
from weaveusd.export.u3m_physics import composition, construction
from weaveusd.export.u3m_pictures import MAPS, half_turns, principled_lobe
from weaveusd.shading.material import StandardFit


@pytest.fixture(scope="module")
def asset(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("asset")
    write_asset(cloth(), path)
    write_u3m(cloth(), path, CLOTH_ITSELF, path / "plain.u3m")
    return path


@pytest.fixture(scope="module")
def document(asset) -> dict:
    return json.loads((asset / "plain.u3m").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def front(document) -> dict:
    return document["material"]["front"]


def test_it_is_valid_by_the_schema(document, asset):
    assert list(u3m_schema.faults(document, asset)) == []
    assert len(document["material"]["front"]) == 22


def test_a_picture_that_leaves_the_folder_would_be_found(document, asset):
    spoiled = json.loads(json.dumps(document))
    spoiled["material"]["front"]["alpha"]["texture"]["image"]["path"] = "../alpha.png"
    spoiled["material"]["physics"]["composition"]["parts"][0]["ratio"] = 0.5
    del spoiled["material"]["front"]["ior"]["texture"]
    spoiled["material"]["front"]["ior"]["texture"] = None
    spoiled["material"]["extra"] = 1
    found = " ".join(u3m_schema.faults(spoiled, asset))
    assert "../alpha.png" in found
    assert "composition" in found
    assert "extra is unknown" in found


def test_pictures_are_rgb_of_the_size_that_is_stated(front, asset):
    for name, value in front.items():
        if not isinstance(value, dict) or value.get("texture") is None:
            continue
        image = value["texture"]["image"]
        pixels = read_image(asset / image["path"])
        height, width, channels = pixels.shape
        assert channels == 3, name
        assert (image["width"], image["height"]) == REPEAT_MM
        assert image["dpi"]["x"] == pytest.approx(width / image["width"] * 25.4)
        assert image["dpi"]["y"] == pytest.approx(height / image["height"] * 25.4)


def test_a_constant_is_the_mean_of_its_texture(front, asset):
    for name in MAPS:
        pixels = read_image(asset / front[name]["texture"]["image"]["path"])
        assert front[name]["constant"] == pytest.approx(pixels.mean() / 255, abs=1e-6)
    encoded = read_image(asset / "textures" / "base_color.png").reshape(-1, 3) / 255
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    mean = linear.mean(0)
    expected = np.where(mean <= 0.0031308, 12.92 * mean, 1.055 * mean ** (1 / 2.4) - 0.055)
    constant = front["basecolor"]["constant"]
    assert [constant[key] for key in "rgb"] == pytest.approx(expected, abs=1e-5)
    normal = np.array([*front["normal"]["constant"].values()])
    assert np.linalg.norm(normal) == pytest.approx(1, abs=1e-5)


def test_the_rotation_is_that_of_the_direction_across_the_fibre(front, asset):
    normal, tangent = (
        read_image(asset / "textures" / f"{name}.png").astype(float) * 65535
        / (VECTOR_PNG_LEVELS / 2) - 1 for name in ("normal", "tangent")
    )  # fmt: skip
    across = np.cross(normal, tangent)[..., :2]
    turns = read_image(asset / front["anisotropy_rotation"]["texture"]["image"]["path"])[..., 0]
    angle = turns / 255 * 2 * math.pi
    direction = np.stack([np.cos(angle), np.sin(angle)], -1)
    length = np.linalg.norm(across, axis=-1)
    cosine = np.abs(np.sum(direction * across, -1))[length > 0.1] / length[length > 0.1]
    assert cosine.min() > math.cos(math.pi / 255 + 1e-3)


def test_no_filter_finds_a_jump_in_the_rotation_of_warp_or_weft():
    around = np.radians(np.arange(-40, 41))
    for turn in (0, 0.25, 0.5, 0.75):
        angle = around + 2 * math.pi * turn
        found = half_turns(np.stack([np.cos(angle), np.sin(angle)], -1))
        assert np.abs(np.diff(found)).max() < 1.1 / 360
        assert found.min() > 0.3
        assert found.max() < 0.95


def test_rotations_are_right_to_a_part_of_a_code():
    angle = np.linspace(-math.pi, math.pi, 10_001)
    found = half_turns(np.stack([np.cos(angle), np.sin(angle)], -1)).astype(float)
    off = (found - angle / (2 * math.pi)) % 0.5
    assert np.minimum(off, 0.5 - off).max() < 1e-5


@pytest.mark.parametrize("along", [0.1, 0.3, 0.8])
def test_a_lobe_has_the_roughnesses_of_its_fit_by_burley(along):
    lobe = principled_lobe(StandardFit(alpha_along=along, alpha_across=0.8, f0=0.04))
    aspect = math.sqrt(1 - 0.9 * lobe.anisotropy)
    assert lobe.roughness**2 * aspect == pytest.approx(along)
    assert lobe.roughness**2 / aspect == pytest.approx(0.8)


def test_the_dielectric_is_that_of_the_fit(front):
    assert front["specular_value"]["constant"] == pytest.approx(FIT.f0 / 0.08)
    ior = front["ior"]["constant"]
    assert ((ior - 1) / (ior + 1)) ** 2 == pytest.approx(FIT.f0)


def test_a_cloth_without_gaps_has_no_map_of_them(asset, tmp_path):
    whole = tmp_path / "whole"
    shutil.copytree(asset, whole)
    path = whole / "textures" / "opacity.png"
    write_png8(path, np.full_like(read_image(path), 255))
    write_u3m(cloth(), whole, CLOTH_ITSELF, whole / "whole.u3m")
    front = json.loads((whole / "whole.u3m").read_text())["material"]["front"]
    assert front["alpha"] == {"constant": 1.0, "texture": None}


def test_weight_thickness_and_fibres_are_the_cloth_s(document):
    stated = document["material"]["physics"]
    weave = cloth().weave
    assert stated["weight"] == pytest.approx(measures.areal_density_g_m2(weave))
    assert stated["thickness"] == pytest.approx(measures.thickness_mm(weave))
    assert stated["composition"]["parts"] == [{"ratio": 1.0, "type": "Linen", "name": None}]


def test_shares_of_the_weight_add_up_and_follow_the_tex():
    weave = cloth().weave
    heavy = replace(yarn("warp", "warp"), fibre="Wool", tex=200.0)
    light = replace(yarn("weft", "weft"), fibre="yak down", tex=10.0)
    parts = composition(replace(weave, yarns=(heavy, light)))
    assert [part["type"] for part in parts] == ["Wool", "other"]
    assert parts[1]["name"] == "yak down"
    assert sum(part["ratio"] for part in parts) == 1
    assert parts[0]["ratio"] > 0.9


HERRINGBONE = np.concatenate([twill(2, 2), twill(2, 2)[:, ::-1]], axis=1)


@pytest.mark.parametrize(
    ("warp_up", "shafts", "kind"),
    [
        (plain(), 2, "Plain weave"),
        (np.tile(plain(), (3, 5)), 2, "Plain weave"),
        (twill(2, 2), 4, "Twill - right hand (Z)"),
        (twill(3, 1)[:, ::-1], 4, "Twill - left hand (S)"),
        (np.tile(twill(1, 3), (2, 2)), 4, "Twill - right hand (Z)"),
        (HERRINGBONE, 4, "Twill"),
        (HERRINGBONE.T, 8, "Twill"),
        (satin(5, 2), 5, "Satin"),
        (satin(8, 3), 8, "Satin"),
        (~satin(8, 3), 8, "Satin"),
        (np.kron(plain(), np.ones((2, 2), bool)).astype(bool), 2, "Dobby"),
        (np.random.default_rng(3).random((40, 40)) < 0.5, 40, "Jacquard"),
    ],
)
def test_the_construction_is_read_from_the_drawdown(warp_up, shafts, kind):
    assert construction(np.asarray(warp_up, bool), shafts) == {"type": kind, "name": None}
    assert kind in u3m_schema.CONSTRUCTIONS


def test_another_cloth_is_another_material_and_the_same_one_the_same(document, asset, tmp_path):
    again, other = tmp_path / "again", tmp_path / "other"
    for folder, material in ((again, cloth()), (other, cloth(size=16))):
        folder.mkdir()
        write_asset(material, folder)
        write_u3m(material, folder, CLOTH_ITSELF, folder / "plain.u3m")
    assert (again / "plain.u3m").read_bytes() == (asset / "plain.u3m").read_bytes()
    for name in MAPS:
        path = f"u3m/{name}.png"
        assert (again / path).read_bytes() == (asset / path).read_bytes()
    found = json.loads((other / "plain.u3m").read_text())["material"]["id"]
    assert found != document["material"]["id"]
