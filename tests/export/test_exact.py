"""The exact document stands beside the interchange one, complete, with every yarn's optics."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import MaterialX as mx  # noqa: N813
import numpy as np
import pytest

from tests.export.cloths import cloth, plain_weave, texture_set, yarn
from tests.export.glsl import Job, render
from weaveusd.contract import EXACT_FILE, MATERIALX_FILE, MATERIALX_NODE_DIR
from weaveusd.export.asset import write_asset
from weaveusd.export.exact import write_exact
from weaveusd.export.images import ImageWriter
from weaveusd.shading.material import ClothMaterial
from weaveusd.shading.measured import Measured
from weaveusd.validate.run import validate


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("asset")
    write_asset(cloth(), path, also=["exact"])
    return path


def of_many_yarns(count: int) -> ClothMaterial:
    """Return a cloth whose yarns differ in their index of refraction and share the rest."""
    plain = yarn("plain", "warp")
    yarns = tuple(
        replace(plain, name=f"y{i}", optics=replace(plain.optics, eta=1.2 + 0.005 * i))
        for i in range(count)
    )
    return replace(
        cloth(),
        weave=replace(plain_weave(), yarns=yarns),
        textures=texture_set(64, 64),
        normalization=(1.5,) * count,
        measured=(Measured(1.0, (0.2, 0.2, 0.2)),) * count,
    )


def read(path: Path) -> mx.Document:
    document = mx.createDocument()
    mx.readFromXmlFile(document, str(path))
    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    document.importLibrary(library)
    return document


def test_the_document_is_valid_knows_its_node_and_finds_every_file(folder):
    document = read(folder / EXACT_FILE)
    valid, message = document.validate()
    assert valid, message
    nodes = [e for e in document.traverseTree() if e.isA(mx.Node) and not e.hasSourceUri()]
    assert "weaveusd_cloth" in {node.getCategory() for node in nodes}
    for node in nodes:
        definition = node.getNodeDef()
        assert definition is not None, node.getNamePath()
        for put in node.getInputs():
            assert definition.getActiveInput(put.getName()) is not None, put.getNamePath()
            if put.getType() == "filename" and node.getActiveSourceUri().endswith(EXACT_FILE):
                assert (folder / put.getValueString()).is_file(), put.getValueString()
    assert {file.name for file in (folder / MATERIALX_NODE_DIR).iterdir()} == {
        "weaveusd_cloth.mtlx", "weaveusd_cloth.glsl", "weaveusd_cloth_bsdf.glsl",
        "weaveusd_footprint.glsl", "weaveusd_distance.glsl",
    }  # fmt: skip


def test_the_interchange_document_never_holds_our_node(folder):
    assert "weaveusd_cloth" not in (folder / MATERIALX_FILE).read_text()


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("weaveusd_cloth", "weaveusd_felt", "mtlx-node"),
        ("textures/yarn_id.png", "textures/gone.png", "mtlx-file"),
        ("<materialx", "<material", "mtlx-broken"),
    ],
)
def test_a_broken_exact_document_is_found(folder, tmp_path, old, new, code):
    asset = Path(shutil.copytree(folder, tmp_path / "asset"))
    document = asset / EXACT_FILE
    document.write_text(document.read_text().replace(old, new))
    before = {f.code for f in validate(folder / "plain.usda").findings}
    assert code not in before
    assert code in {f.code for f in validate(asset / "plain.usda").findings}


def test_it_stands_only_where_it_is_asked_for(tmp_path):
    write_asset(cloth(), tmp_path)
    assert not (tmp_path / EXACT_FILE).exists()
    assert not (tmp_path / MATERIALX_NODE_DIR).exists()


def test_what_all_yarns_share_is_a_plain_value(tmp_path):
    write_exact(of_many_yarns(3), tmp_path)
    document = read(tmp_path / EXACT_FILE)
    node = document.getNode("plain_cloth")
    assert node.getInput("k_d").getValue() == pytest.approx(0.3)
    assert node.getInput("eta").getConnectedNode().getCategory() == "switch"


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 10, 25, 255])
def test_every_yarn_id_finds_its_own_optics(tmp_path, count):
    """The table is drawn: an image with all ids, and the index of refraction for color."""
    material = of_many_yarns(count)
    write_exact(material, tmp_path)
    (tmp_path / "textures").mkdir()
    # Blocks of texels, since Mesa's software renderer blurs what it magnifies.
    ids = np.kron(np.arange(256, dtype=np.uint8).reshape(16, 16), np.ones((4, 4), np.uint8))
    path = tmp_path / "textures" / "yarn_id.png"
    with ImageWriter(path, 64, 64, 1, "uint8", {"oiio:ColorSpace": "data"}) as writer:
        writer.write(ids[..., None])
    made = mx.createDocument()
    mx.readFromXmlFile(made, str(tmp_path / EXACT_FILE))
    graph = made.getNodeGraph("plain_textures")
    color = graph.addNode("combine3", "shown", "color3")
    for name in ("in1", "in2", "in3"):
        color.setConnectedNode(name, graph.getOutput("eta_out").getConnectedNode())
    graph.addOutput("shown_out", "color3").setConnectedNode(color)
    surface = made.addNode("surface_unlit", "drawn", "surfaceshader")
    surface.addInput("emission_color", "color3").setConnectedOutput(graph.getOutput("shown_out"))
    made.addNode("surfacematerial", "table", "material").setConnectedNode("surfaceshader", surface)
    document = tmp_path / "table.mtlx"
    document.write_text(mx.writeToXmlString(made))

    width, height = material.weave.repeat_mm
    job = Job(str(document), "table", str(tmp_path / "table.npy"), size=256,
              st=(width / 1000, height / 1000))  # fmt: skip
    (picture,) = render([job], tmp_path)
    shown = picture[8::16, 8::16, 0][::-1].ravel()
    eta = np.array([y.optics.eta for y in material.weave.yarns])
    np.testing.assert_allclose(shown[1 : count + 1], eta, rtol=1e-6)
    assert shown[0] == pytest.approx(eta[0])
