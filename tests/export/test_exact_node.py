"""The MaterialX node `weaveusd_cloth` is the reference BSDF, and has a fallback that is like it."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import MaterialX as mx  # noqa: N813
import numpy as np
import pytest
from MaterialX import (
    PyMaterialXGenGlsl,
    PyMaterialXGenMsl,
    PyMaterialXGenOsl,
    PyMaterialXGenShader,
)

from tests.export.glsl import Job, render, view
from tests.export.node_documents import LIBRARY, new_document, write_document
from weaveusd.contract import MOMENT_MAPS, SHADER_YARN_ARRAYS, SYSTEMS
from weaveusd.shading import laws
from weaveusd.shading.microcylinder import Parameters, evaluate
from weaveusd.shading.normalization import normalization

COLOR = np.array([0.2, 0.5, 0.9])
GAIN = 1.25  # takes the last channel above 1


def unit(*vector: float) -> np.ndarray:
    return np.array(vector) / np.linalg.norm(vector)


@dataclass(frozen=True)
class Subject:
    """A fibre in a frame, and its optics with angles in degrees."""

    normal: tuple[float, float, float]
    fibre: tuple[float, float, float]
    eta: float
    k_d: float
    k_s: float
    gamma_s: float
    gamma_v: float
    tau: float

    @property
    def frame(self) -> tuple[np.ndarray, np.ndarray]:
        normal, fibre = unit(*self.normal), np.array(self.fibre)
        return normal, unit(*(fibre - normal * (normal @ fibre)))

    @property
    def optics(self) -> Parameters:
        widths = np.radians([self.gamma_s, self.gamma_v])
        albedo = np.minimum(1, COLOR * GAIN)
        return Parameters(self.eta, self.k_d, self.k_s, *widths, self.tau, albedo)


SUBJECTS = {
    "silk": Subject((0, 0, 1), (0, 1, 0), 1.539, 0.1, 0.7, 5, 10, 0.0),
    "linen": Subject((0.3, -0.2, 0.9), (0.4, 0.9, 0.1), 1.46, 0.3, 1.0, 12, 24, 0.2),
    "polyester": Subject((-0.4, 0.3, 0.6), (0.9, 0.2, 0.5), 1.54, 0.1, 1.0, 2.5, 5, 0.0),
    "gauze": Subject((0.1, 0.1, -1), (1, 0.1, 0.3), 1.0, 0.5, 0.5, 30, 60, 0.8),
}
LIGHTS = [unit(0, 0, 1), unit(0.5, 0.3, 0.8), unit(-0.8, 0.1, 0.15), unit(0.1, 0.3, -0.9)]


def document(subject: Subject, folder: Path) -> Path:
    """Write a document with the node and its library beside it."""
    made, cloth = new_document()
    optics = subject.optics
    n_v = normalization(*optics[:5])
    cloth.setInputValue("base_color", mx.Color3(*COLOR))
    for name in SHADER_YARN_ARRAYS:
        value = {"normalization": n_v, "albedo_gain": GAIN}.get(name) or getattr(optics, name)
        cloth.setInputValue(name, float(value))
    for name, vector in zip(("normal", "tangent"), subject.frame, strict=True):
        constant = made.addNode("constant", name, "vector3")
        constant.addInput("value", "vector3").setValueString(", ".join(f"{x:.9g}" for x in vector))
        cloth.setConnectedNode(name, constant)
    return write_document(made, folder)


def expected(subject: Subject, job: Job) -> np.ndarray:
    """Return what the reference shows of the square: 0 where yarn and surface disagree."""
    (normal, fibre), wi, wo = subject.frame, view(job), np.array(job.light)
    value = evaluate(wi, wo, normal, fibre, subject.optics)
    allowed = (wi @ normal) * (normal @ wo) * wi[..., 2] * wo[2] > 0
    return np.where(allowed[..., None], value, 0)


def check(subjects: list[str], lights: list[np.ndarray], folder: Path) -> None:
    jobs = []
    for name in subjects:
        (folder / name).mkdir()
        path = document(SUBJECTS[name], folder / name)
        for i, light in enumerate(lights):
            target = folder / name / f"{i}.npy"
            jobs.append(Job(str(path), "material", str(target), tuple(light), eye=0.5, size=64))
    for job, picture in zip(jobs, render(jobs, folder), strict=True):
        reference = expected(SUBJECTS[Path(job.document).parent.name], job)
        assert reference.max() > 0
        np.testing.assert_allclose(
            picture, reference, rtol=1e-4, atol=1e-5 * reference.max(), err_msg=job.target
        )


def test_lights_show_the_reference_bsdf(tmp_path):
    check(["linen"], [LIGHTS[1], LIGHTS[3]], tmp_path)


@pytest.mark.slow
def test_every_fibre_shows_the_reference_bsdf_from_every_light(tmp_path):
    check(["silk", "linen", "polyester", "gauze"], LIGHTS[:3], tmp_path)


@pytest.mark.slow
def test_an_even_sky_shows_the_directional_albedo(tmp_path):
    subject = SUBJECTS["linen"]
    job = Job(str(document(subject, tmp_path)), "material", str(tmp_path / "sky.npy"),
              eye=0.5, size=32, environment=True)  # fmt: skip
    (picture,) = render([job], tmp_path)
    normal, fibre = subject.frame
    frame = np.stack([np.cross(normal, fibre), fibre, normal])
    n_v = normalization(*subject.optics[:5])
    for y, x in [(16, 16), (2, 30), (30, 4), (20, 10)]:
        wi = frame @ view(job)[y, x]
        theta, phi = np.arcsin(wi[1]), np.arctan2(wi[0], abs(wi[2]))
        for channel in range(3):
            optics = subject.optics._replace(A=subject.optics.A[channel : channel + 1])
            whole = laws.directional_albedo(optics, theta, phi).whole
            assert picture[y, x, channel] == pytest.approx(whole, abs=0.03 * n_v)


def library_document() -> mx.Document:
    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    mx.readFromXmlFile(library, str(LIBRARY / "weaveusd_cloth.mtlx"))
    return library


def test_the_node_takes_the_inputs_of_the_contract():
    definition = library_document().getNodeDef("ND_weaveusd_cloth")
    of_yarn = {*SHADER_YARN_ARRAYS, "weight", "base_color", "normal", "tangent"}
    of_surface = {"surface_normal", "surface_tangent", "surface_bitangent", "moment_texels"}
    moments = {
        f"{system}_{name}"
        for system in SYSTEMS
        for name in (*MOMENT_MAPS, "section", "fibres", "lobes")
    }
    assert of_yarn | of_surface | moments == {put.getName() for put in definition.getActiveInputs()}
    assert all(put.getAttribute("doc") for put in definition.getActiveInputs())


def test_the_library_is_valid_and_its_fallback_of_standard_nodes():
    library = library_document()
    valid, message = library.validate()
    assert valid, message
    for node in library.getNodeGraph("NG_weaveusd_cloth").getNodes():
        assert node.getNodeDef() is not None, node.getName()
        assert node.getCategory() != "weaveusd_cloth"


def generated(generator: Any, folder: Path) -> str:
    """Return the pixel stage of the document in `folder` that the generator writes."""
    made, library = mx.createDocument(), library_document()
    mx.readFromXmlFile(made, str(document(SUBJECTS["silk"], folder)))
    made.importLibrary(library)
    target = generator.create()
    context = PyMaterialXGenShader.GenContext(target)
    context.registerSourceCodeSearchPath(mx.getDefaultDataSearchPath())
    context.registerSourceCodeSearchPath(mx.FileSearchPath(str(folder)))
    target.registerTypeDefs(made)
    return target.generate("material", made.getNode("material"), context).getSourceCode("pixel")


@pytest.mark.parametrize(
    ("generator", "options"),
    [
        (PyMaterialXGenGlsl.GlslShaderGenerator, []),
        (PyMaterialXGenGlsl.EsslShaderGenerator, []),
        (PyMaterialXGenGlsl.VkShaderGenerator, ["-V"]),
    ],
)
def test_what_the_targets_of_glsl_generate_compiles(tmp_path, generator, options):
    if shutil.which("glslangValidator") is None:
        pytest.skip("glslangValidator is not here; install glslang-tools")
    source = tmp_path / "cloth.frag"
    source.write_text(generated(generator, tmp_path))
    done = subprocess.run(
        ["glslangValidator", *options, source], capture_output=True, text=True, cwd=tmp_path
    )
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize(
    ("generator", "exact"),
    [
        (PyMaterialXGenGlsl.GlslShaderGenerator, True),
        (PyMaterialXGenGlsl.EsslShaderGenerator, True),
        (PyMaterialXGenGlsl.VkShaderGenerator, True),
        (PyMaterialXGenGlsl.WgslShaderGenerator, True),
        (PyMaterialXGenMsl.MslShaderGenerator, True),
        (PyMaterialXGenOsl.OslShaderGenerator, False),
    ],
)
def test_hardware_targets_get_the_exact_source_and_others_the_fallback(tmp_path, generator, exact):
    source = generated(generator, tmp_path)
    assert ("weaveusd_lobes(" in source) == exact
    assert ("generalized_schlick_bsdf(" in source) != exact


@pytest.mark.slow
def test_the_fallback_has_the_highlight_and_about_the_light_of_the_exact_node(tmp_path):
    jobs = []
    for name in ("exact", "fallback"):
        (tmp_path / name).mkdir()
        path = document(SUBJECTS["silk"], tmp_path / name)
        if name == "fallback":
            library = tmp_path / name / "materialx" / "weaveusd_cloth.mtlx"
            text = library.read_text()
            start = text.index("<implementation")
            library.write_text(text[:start] + text[text.index("/>", start) + 2 :])
        jobs.append(Job(str(path), "material", str(tmp_path / f"{name}.npy"), eye=0.5, size=64))
    exact, fallback = render(jobs, tmp_path)
    assert fallback.mean() == pytest.approx(exact.mean(), rel=0.35)
    for picture in (exact, fallback):
        light = picture[..., 0]
        rows, columns = np.nonzero(light > light.max() / 2)
        # The fibre runs along y, hence the streak along x.
        assert np.ptp(columns) > 2 * np.ptp(rows)
