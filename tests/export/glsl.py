"""Renders MaterialX documents with MaterialX's own GLSL renderer; needs a display.

    python -m tests.export.glsl jobs.json

`jobs.json` is a list of `Job`. A square from -1 to 1 in x and y is seen from (0, 0, eye), filling
the picture, and lit by one directional light of irradiance 1 alone, or by an environment of
radiance 1. Each picture becomes an array (size, size, 3) of float32, the first row at the bottom.
"""

from __future__ import annotations

import ctypes
import json
import os
import shutil
import subprocess
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
SQUARE = """v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0
vt 0 0\nvt {u} 0\nvt {u} {v}\nvt 0 {v}
vn 0 0 1
f 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/4/1
"""


@dataclass(frozen=True)
class Job:
    """A picture of the material `material` of `document`, both as text."""

    document: str
    material: str
    target: str
    light: tuple[float, float, float] = (0.0, 0.0, 1.0)  # towards the light
    eye: float = 2.0
    size: int = 256
    environment: bool = False
    st: tuple[float, float] = (1.0, 1.0)  # texture coordinates of the upper right corner


def render(jobs: list[Job], folder: Path) -> list[np.ndarray]:
    """Return the pictures of `jobs`; skips the test where there is no display."""
    if shutil.which("xvfb-run") is None or shutil.which("xauth") is None:
        pytest.skip("MaterialX's GLSL renderer needs a display; install xvfb and xauth")
    listing = folder / "jobs.json"
    listing.write_text(json.dumps([asdict(job) for job in jobs]))
    done = subprocess.run(
        ["xvfb-run", "-a", sys.executable, "-m", "tests.export.glsl", str(listing)],
        cwd=ROOT, capture_output=True, text=True, env=os.environ,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return [np.load(job.target) for job in jobs]


def view(job: Job) -> np.ndarray:
    """Return the unit vectors (size, size, 3) from the square to the eye, the first row below."""
    at = (np.arange(job.size) + 0.5) / job.size * 2 - 1
    x, y = np.meshgrid(at, at)
    to_eye = np.stack([-x, -y, np.full_like(x, job.eye)], -1)
    return to_eye / np.linalg.norm(to_eye, axis=-1, keepdims=True)


def _main(jobs: list[Job]) -> None:
    import MaterialX as mx  # noqa: N813
    from MaterialX import PyMaterialXRender
    from MaterialX.PyMaterialXRenderGlsl import GlslRenderer, GLTextureHandler

    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    exr = _new_exr_loader()
    for job in jobs:
        path = Path(job.document)
        document = mx.createDocument()
        mx.readFromXmlFile(document, str(path))
        document.importLibrary(library)
        sun = document.addNode("directional_light", "sun", "lightshader")
        sun.setInputValue("direction", mx.Vector3(*(-x for x in job.light)))
        sun.setInputValue("color", mx.Color3(1, 1, 1))
        sun.setInputValue("intensity", 0.0 if job.environment else 1.0)

        generator, context = _new_generator(document, path.parent)
        renderer = GlslRenderer.create(job.size, job.size, PyMaterialXRender.BaseType.FLOAT)
        renderer.initialize()
        renderer.setLightHandler(_new_lights(document, sun, context, job.environment))
        images = GLTextureHandler.create(PyMaterialXRender.StbImageLoader.create())
        images.addLoader(exr)
        images.setSearchPath(mx.FileSearchPath(str(path.parent)))
        renderer.setImageHandler(images)
        square = Path(job.target).with_suffix(".obj")
        square.write_text(SQUARE.format(u=job.st[0], v=job.st[1]))
        geometry = renderer.getGeometryHandler()
        geometry.addLoader(PyMaterialXRender.TinyObjLoader.create())
        geometry.loadGeometry(mx.FilePath(str(square)), False)
        _place_camera(renderer.getCamera(), job.eye)

        node = document.getNode(job.material)
        renderer.createProgram(generator.generate(job.material, node, context))
        renderer.setSize(job.size, job.size)
        renderer.render()
        image = renderer.captureImage(_uniform(job.size, 0.0))
        np.save(job.target, _texels(image)[..., :3])


def _new_generator(document: Any, folder: Path) -> tuple[Any, Any]:
    """Return a shader generator, which must outlive its context, and the context."""
    import MaterialX as mx  # noqa: N813
    from MaterialX import PyMaterialXGenGlsl, PyMaterialXGenShader

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
    context.registerSourceCodeSearchPath(mx.FileSearchPath(str(folder)))
    context.getOptions().hwMaxActiveLightSources = 1
    context.getOptions().fileTextureVerticalFlip = True
    return generator, context


def _new_exr_loader() -> Any:
    """Return a loader of EXR images by OpenImageIO, which MaterialX's wheels are built without.

    Keep it: handlers do not, and find no image once it is gone.
    """
    import OpenImageIO as oiio  # noqa: N813
    from MaterialX import PyMaterialXRender

    class Loader(PyMaterialXRender.ImageLoader):
        def __init__(self) -> None:
            PyMaterialXRender.ImageLoader.__init__(self)

        def supportedExtensions(self) -> set[str]:
            return {"exr"}

        def loadImage(self, path: Any) -> Any:
            if not Path(path.asString()).is_file():
                return None
            texels = np.ascontiguousarray(oiio.ImageBuf(path.asString()).get_pixels(oiio.FLOAT))
            height, width, channels = texels.shape
            kind = PyMaterialXRender.BaseType.FLOAT
            image = PyMaterialXRender.Image.create(width, height, channels, kind)
            image.createResourceBuffer()
            ctypes.memmove(image.getResourceBuffer(), texels.ctypes.data, texels.nbytes)
            return image

    return Loader()


def _texels(image: Any) -> np.ndarray:
    """Return a copy of an image of floats (height, width, channels)."""
    shape = image.getHeight(), image.getWidth(), image.getChannelCount()
    floats = (ctypes.c_float * int(np.prod(shape))).from_address(image.getResourceBuffer())
    return np.array(floats, np.float32).reshape(shape)


def _new_lights(document: Any, sun: Any, context: Any, environment: bool) -> Any:
    from MaterialX import PyMaterialXRender

    lights = PyMaterialXRender.LightHandler.create()
    lights.registerLights(document, [sun], context)
    lights.setLightSources([sun])
    lights.setIndirectLighting(environment)
    lights.setEnvRadianceMap(_uniform(4, float(environment)))
    lights.setEnvIrradianceMap(_uniform(4, float(environment)))
    return lights


def _place_camera(camera: Any, height: float) -> None:
    import MaterialX as mx  # noqa: N813
    from MaterialX import PyMaterialXRender

    eye, center, up = mx.Vector3(0, 0, height), mx.Vector3(0, 0, 0), mx.Vector3(0, 1, 0)
    camera.setViewMatrix(PyMaterialXRender.Camera.createViewMatrix(eye, center, up))
    near = 0.05
    half = near / height
    frustum = (-half, half, -half, half, near, 100.0)
    camera.setWorldMatrix(mx.Matrix44.IDENTITY)
    camera.setProjectionMatrix(PyMaterialXRender.Camera.createPerspectiveMatrix(*frustum))


def _uniform(size: int, value: float) -> Any:
    import MaterialX as mx  # noqa: N813
    from MaterialX import PyMaterialXRender

    color = mx.Color4(value, value, value, 1)
    return PyMaterialXRender.createUniformImage(
        size, size, 4, PyMaterialXRender.BaseType.FLOAT, color
    )


if __name__ == "__main__":
    _main([Job(**job) for job in json.loads(Path(sys.argv[1]).read_text())])
