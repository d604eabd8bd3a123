"""Renders a MaterialX document with MaterialX's own GLSL renderer; needs a display.

    python -m tests.export.glsl material.mtlx <name of the material> image.hdr

A square from -1 to 1 in x and y is lit and seen from +z, by one directional light alone.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import MaterialX as mx  # noqa: N813
from MaterialX import PyMaterialXGenGlsl, PyMaterialXGenShader, PyMaterialXRender
from MaterialX.PyMaterialXRenderGlsl import GlslRenderer, GLTextureHandler

SIZE = 256
SQUARE = """v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0
vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1
vn 0 0 1
f 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/4/1
"""
BLACK = mx.Color4(0, 0, 0, 1)


def main(path: Path, name: str, target: Path) -> None:
    document = mx.createDocument()
    mx.readFromXmlFile(document, str(path))
    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    document.importLibrary(library)
    sun = document.addNode("directional_light", "sun", "lightshader")
    sun.setInputValue("direction", mx.Vector3(0, 0, -1))
    sun.setInputValue("color", mx.Color3(1, 1, 1))
    sun.setInputValue("intensity", 1.0)

    generator, context = new_generator(document)
    renderer = GlslRenderer.create(SIZE, SIZE, PyMaterialXRender.BaseType.FLOAT)
    renderer.initialize()
    renderer.setLightHandler(new_lights(document, sun, context))
    images = GLTextureHandler.create(PyMaterialXRender.StbImageLoader.create())
    images.setSearchPath(mx.FileSearchPath(str(path.parent)))
    renderer.setImageHandler(images)
    square = target.with_suffix(".obj")
    square.write_text(SQUARE)
    geometry = renderer.getGeometryHandler()
    geometry.addLoader(PyMaterialXRender.TinyObjLoader.create())
    geometry.loadGeometry(mx.FilePath(str(square)), False)
    place_camera(renderer.getCamera())

    node = document.getNode(name)
    renderer.createProgram(generator.generate(name, node, context))
    renderer.setSize(SIZE, SIZE)
    renderer.render()
    image = renderer.captureImage(black(SIZE))
    loader = PyMaterialXRender.StbImageLoader.create()
    if not loader.saveImage(mx.FilePath(str(target)), image, False):
        raise OSError(f"{target}: not saved")


def new_generator(document: mx.Document) -> tuple[Any, Any]:
    """Return a shader generator, which must outlive its context, and the context."""
    generator = PyMaterialXGenGlsl.GlslShaderGenerator.create()
    generator.registerTypeDefs(document)
    colors = PyMaterialXGenShader.DefaultColorManagementSystem.create(generator.getTarget())
    colors.loadLibrary(document)
    generator.setColorManagementSystem(colors)
    units = PyMaterialXGenShader.UnitSystem.create(generator.getTarget())
    units.loadLibrary(document)
    generator.setUnitSystem(units)
    context = PyMaterialXGenShader.GenContext(generator)
    context.registerSourceCodeSearchPath(mx.getDefaultDataSearchPath())
    context.getOptions().hwMaxActiveLightSources = 1
    context.getOptions().fileTextureVerticalFlip = True
    return generator, context


def new_lights(document: mx.Document, sun: mx.Node, context: Any) -> Any:
    lights = PyMaterialXRender.LightHandler.create()
    lights.registerLights(document, [sun], context)
    lights.setLightSources([sun])
    lights.setIndirectLighting(False)
    lights.setEnvRadianceMap(black(4))
    lights.setEnvIrradianceMap(black(4))
    return lights


def place_camera(camera: Any) -> None:
    eye, center, up = mx.Vector3(0, 0, 2), mx.Vector3(0, 0, 0), mx.Vector3(0, 1, 0)
    camera.setViewMatrix(PyMaterialXRender.Camera.createViewMatrix(eye, center, up))
    frustum = (-0.05, 0.05, -0.05, 0.05, 0.1, 100.0)
    camera.setWorldMatrix(mx.Matrix44.IDENTITY)
    camera.setProjectionMatrix(PyMaterialXRender.Camera.createPerspectiveMatrix(*frustum))


def black(size: int) -> Any:
    return PyMaterialXRender.createUniformImage(
        size, size, 4, PyMaterialXRender.BaseType.FLOAT, BLACK
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3]))
