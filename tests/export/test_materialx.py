"""The MaterialX document holds standard nodes only, and generates shaders."""

from __future__ import annotations

from pathlib import Path

import MaterialX as mx  # noqa: N813
import pytest
from MaterialX import PyMaterialXGenGlsl, PyMaterialXGenShader

from tests.export.cloths import cloth
from weaveusd.export.materialx import write_materialx


@pytest.fixture(scope="module")
def document(tmp_path_factory) -> mx.Document:
    path = tmp_path_factory.mktemp("mtlx") / "material.mtlx"
    write_materialx(cloth(), path)
    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    read = mx.createDocument()
    mx.readFromXmlFile(read, str(path))
    read.setDataLibrary(library)
    return read


def nodes(document: mx.Document) -> list[mx.Node]:
    return [element for element in document.traverseTree() if element.isA(mx.Node)]


def upstream(node: mx.Node) -> list[mx.Node]:
    """Return `node` and all that it takes values from."""
    above = (put.getConnectedNode() for put in node.getInputs())
    return [node, *(found for one in above if one is not None for found in upstream(one))]


def test_the_document_is_valid_and_every_node_is_standard(document):
    valid, message = document.validate()
    assert valid, message
    assert len(nodes(document)) > 10
    for node in nodes(document):
        definition = node.getNodeDef()
        assert definition is not None, node.getName()
        for put in node.getInputs():
            known = definition.getActiveInput(put.getName())
            assert known is not None, put.getNamePath()
            assert known.getType() == put.getType(), put.getNamePath()


def test_the_document_declares_its_color_space(document):
    assert document.getColorSpace() == "lin_rec709"
    spaces = {
        put.getValueString(): put.getColorSpace()
        for node in nodes(document)
        for put in node.getInputs()
        if put.getType() == "filename"
    }
    assert spaces.pop("textures/base_color.png") == "srgb_texture"
    assert set(spaces.values()) <= {"", "lin_rec709"}


def test_files_are_relative_and_among_those_written(document):
    files = {
        put.getValueString()
        for node in nodes(document)
        for put in node.getInputs()
        if put.getType() == "filename"
    }
    assert files == {
        f"textures/{name}.png"
        for name in ("base_color", "normal", "opacity", "roughness", "rotation")
    }


@pytest.mark.parametrize(
    ("surface", "key"),
    [("plain_surface", "geometry_tangent"), ("plain_standard_surface_surface", "tangent")],
)
def test_both_surfaces_take_the_direction_of_the_rotation_for_tangent(document, surface, key):
    across = document.getNode(surface).getInput(key).getConnectedNode()
    read = [node.getName() for node in upstream(across)]
    assert {"rotation_map", "angle_twice", "normal_map"} <= set(read)


def test_the_anisotropy_is_that_of_the_rotation_s_length(document):
    surface = document.getNode("plain_surface")
    anisotropy = surface.getInput("specular_roughness_anisotropy").getConnectedNode()
    assert "rotation_map" in [node.getName() for node in upstream(anisotropy)]


def test_repeats_multiply_metres(document):
    repeats = document.getNodeGraph("plain_textures").getNode("repeats")
    assert repeats.getCategory() == "multiply"
    assert tuple(repeats.getInputValue("in2")) == (1250.0, 1000.0)


@pytest.mark.parametrize("material", ["plain", "plain_standard_surface"])
def test_materialx_generates_shaders_from_the_document(document, material):
    generator = PyMaterialXGenGlsl.EsslShaderGenerator.create()
    context = PyMaterialXGenShader.GenContext(generator)
    context.registerSourceCodeSearchPath(mx.getDefaultDataSearchPath())
    generator.registerTypeDefs(document)
    shader = generator.generate(material, document.getNode(material), context)
    assert "void main" in shader.getSourceCode("pixel")


def test_any_safe_name_gives_a_valid_document(tmp_path):
    for name in ("textures", "plain_textures", "surface", "out", "repeats"):
        path: Path = tmp_path / f"{name}.mtlx"
        write_materialx(cloth(name), path)
        read = mx.createDocument()
        mx.readFromXmlFile(read, str(path))
        assert [n.getName() for n in read.getMaterialNodes()] == [name, f"{name}_standard_surface"]
