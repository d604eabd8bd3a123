"""The shader for Storm: it compiles, shows the reference BSDF, and stands only where asked for.

OpenUSD from PyPI has no Storm, so what Storm hands to a surface shader stands here as stubs, after
hdSt's simpleLighting.glslfx of OpenUSD 26.11.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdShade

from tests.export.cloths import cloth
from tests.export.glsl import Job, render, view
from weaveusd import stage as stages
from weaveusd.contract import GLSLFX_CONTEXT, GLSLFX_FILE, SHADER_YARN_ARRAYS
from weaveusd.export.asset import write_asset
from weaveusd.export.glslfx import GLSLFX_INPUTS, glslfx_text
from weaveusd.export.network_mitsuba import optics_of
from weaveusd.shading.microcylinder import Parameters, evaluate

EYE = 0.5
LIGHT = np.array([0.5, 0.3, 0.8]) / np.linalg.norm([0.5, 0.3, 0.8])
NORMAL = np.array([0.3, -0.2, 0.9]) / np.linalg.norm([0.3, -0.2, 0.9])
COLOR = np.array([0.2, 0.5, 0.9])

STORM = """
#define MAT4 mat4
struct LightSource {
    vec4 position; vec4 ambient; vec4 diffuse; vec4 specular; vec4 spotDirection;
    vec4 spotCutoffAndFalloff; vec4 attenuation; MAT4 worldToLightTransform;
    int shadowIndexStart; int shadowIndexEnd; bool hasShadow; bool isIndirectLight;
};
MAT4 GetWorldToViewInverseMatrix() { return MAT4(1.0); }
mat3 ComputeTBNMatrix(vec3 P, vec3 N, vec2 st) { return mat3(vec3(1, 0, 0), vec3(0, 1, 0), N); }
#if NUM_LIGHTS > 0
uint GetLightCount() { return uint(NUM_LIGHTS); }
LightSource GetLightSource(int index) {
    LightSource light;
    light.position = vec4(TO_LIGHT, 0.0);
    light.diffuse = vec4(1.0);
    light.worldToLightTransform = MAT4(1.0);
    light.hasShadow = false;
    light.isIndirectLight = IS_DOME;
    return light;
}
float shadowing(int index, vec4 Peye) { return 1.0; }
float lightDistanceAttenuation(vec4 Peye, int index) { return 1.0; }
float lightSpotAttenuation(vec3 l, int index) { return 1.0; }
#endif
#ifdef HD_HAS_domeLightIrradiance
vec4 HdGet_domeLightIrradiance(vec3 direction) { return vec4(1.0); }
#endif
"""

DOCUMENT = """<?xml version="1.0"?>
<materialx version="1.39">
  <nodedef name="ND_storm" node="storm">
    <input name="position" type="vector3" value="0, 0, 0" />
    <output name="out" type="color3" />
  </nodedef>
  <implementation name="IM_storm" nodedef="ND_storm" file="storm.glsl" function="storm"
    target="genglsl" />
  <position name="position" type="vector3"><input name="space" type="string" value="world" />
  </position>
  <storm name="storm" type="color3">
    <input name="position" type="vector3" nodename="position" />
  </storm>
  <surface_unlit name="surface" type="surfaceshader">
    <input name="emission_color" type="color3" nodename="storm" />
  </surface_unlit>
  <surfacematerial name="material" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="surface" />
  </surfacematerial>
</materialx>
"""
"""MaterialX runs Storm's shader as the source of a node: its renderer takes no other programs."""


def vector(values: np.ndarray) -> str:
    return f"vec3({', '.join(f'{x:.9g}' for x in values)})"


def sections(text: str) -> dict[str, str]:
    parts = re.split(r"^-- glsl (\S+)\n", text, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def around(text: str, defines: dict[str, str], inputs: dict[str, str]) -> str:
    """Return what Storm would build around the glslfx file `text`: `storm` shows a point."""
    getters = [
        f"{kind} HdGet_{name}() {{ return {inputs.get(name, f'{kind}(0.5)')}; }}"
        for name, (kind, _) in GLSLFX_INPUTS.items()
    ]
    return "\n".join(
        [
            *(f"#define {name} {value}" for name, value in defines.items()),
            STORM,
            *getters,
            *sections(text).values(),
            "void storm(vec3 position, out vec3 shown)",
            f"{{ vec4 eye = vec4(position.xy, position.z - {EYE}, 1.0);",
            "  shown = surfaceShader(eye, vec3(0, 0, 1), vec4(1), vec4(0)).rgb; }",
        ]
    )


def defines(lights: int = 1, dome: bool = False, shadows: bool = False) -> dict[str, str]:
    found = {"NUM_LIGHTS": str(lights), "TO_LIGHT": vector(LIGHT), "IS_DOME": str(dome).lower()}
    if dome:
        found["HD_HAS_domeLightIrradiance"] = "1"
    return found | {"USE_SHADOWS": str(int(shadows))}


@pytest.mark.parametrize(
    "kinds", [defines(0), defines(1), defines(3, shadows=True), defines(2, dome=True)]
)
def test_the_shader_compiles_with_what_storm_hands_over(tmp_path, kinds):
    if shutil.which("glslangValidator") is None:
        pytest.skip("glslangValidator is not here; install glslang-tools")
    source = tmp_path / "cloth.frag"
    body = around(glslfx_text(optics_of(cloth())), kinds, {})
    main = "in vec3 at;\nout vec3 shown;\nvoid main() { storm(at, shown); }"
    source.write_text(f"#version 450 core\n{body}\n{main}\n")
    done = subprocess.run(["glslangValidator", source], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("yarn", [1, 2])
def test_a_light_in_storm_shows_the_reference_bsdf_of_the_yarn(tmp_path, yarn):
    fibre = np.array([0.4, 0.9, 0.1])
    fibre -= NORMAL * (NORMAL @ fibre)
    fibre /= np.linalg.norm(fibre)
    optics = {
        "eta": (1.46, 1.54), "k_d": (0.3, 0.1), "k_s": (1.0, 0.7), "gamma_s": (0.21, 0.0436),
        "gamma_v": (0.42, 0.0873), "tau": (0.2, 0.0), "normalization": (1.86, 0.91),
        "albedo_gain": (1.25, 0.5),
    }  # fmt: skip
    inputs = {
        "base_color": vector(COLOR), "normal": vector(NORMAL), "fibre": vector(fibre),
        "opacity": "1.0", "yarn_id": f"{yarn}.0 / 255.0",
    }  # fmt: skip
    (tmp_path / "storm.glsl").write_text(around(glslfx_text(optics), defines(), inputs))
    (tmp_path / "storm.mtlx").write_text(DOCUMENT)
    document, target = tmp_path / "storm.mtlx", tmp_path / "storm.npy"
    job = Job(str(document), "material", str(target), tuple(LIGHT), eye=EYE, size=64)
    (picture,) = render([job], tmp_path)

    of_yarn = {name: values[yarn - 1] for name, values in optics.items()}
    albedo = np.minimum(1, COLOR * of_yarn.pop("albedo_gain"))
    n_v = of_yarn.pop("normalization")
    wi = view(job)
    reference = evaluate(wi, LIGHT, NORMAL, fibre, Parameters(**of_yarn, A=albedo), n_v=n_v)
    reference = np.where((wi @ NORMAL > 0)[..., None], reference, 0)
    np.testing.assert_allclose(picture, reference, rtol=1e-4, atol=1e-5 * reference.max())


def test_both_users_of_our_glsl_have_the_same_source():
    shared = (stages.schema_dir() / "materialx" / "weaveusd_cloth.glsl").read_text()
    closure = (stages.schema_dir() / "materialx" / "weaveusd_cloth_bsdf.glsl").read_text()
    assert sections(glslfx_text(optics_of(cloth())))["Weaveusd.Cloth"].strip() == shared.strip()
    assert '#include "weaveusd_cloth.glsl"' in closure


def test_every_yarn_has_its_optics_and_those_alike_share_a_line():
    optics = dict.fromkeys(SHADER_YARN_ARRAYS, (0.5,) * 20 + (0.25,))
    yarns = sections(glslfx_text(optics))["Weaveusd.Yarns"]
    assert yarns.count("if (yarn == 21)") == 2
    assert yarns.count("return vec4(") == 4


def test_the_configuration_names_sections_of_the_file_and_the_helper():
    text = glslfx_text(optics_of(cloth()))
    found = text.split("-- configuration", 1)[1].split("-- glsl", 1)[0]
    configuration = json.loads(found)
    names = configuration["techniques"]["default"]["surfaceShader"]["source"]
    assert names[0] == "SurfaceHelpers.TangentSpace"
    assert names[1:] == list(sections(text))
    assert set(configuration["parameters"]) == set(GLSLFX_INPUTS)
    asked = set(re.findall(r"HdGet_(\w+)\(", text)) - {"domeLightIrradiance"}
    assert asked == set(GLSLFX_INPUTS)


@pytest.fixture(scope="module")
def published(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("asset")
    write_asset(cloth(), folder, also=["glslfx"])
    return folder


def test_the_network_hands_every_input_to_the_shader_of_the_asset(published):
    stage = stages.open_stage(published / "plain.usda")
    material = UsdShade.Material(stage.GetPrimAtPath("/plain/Material"))
    surface, name, _ = material.ComputeSurfaceSource(GLSLFX_CONTEXT)
    assert name == "surface"
    assert surface.GetImplementationSource() == "sourceAsset"
    assert surface.GetSourceAsset(GLSLFX_CONTEXT).path == f"./{GLSLFX_FILE}"
    assert (published / GLSLFX_FILE).is_file()
    assert {put.GetBaseName() for put in surface.GetInputs()} == set(GLSLFX_INPUTS)
    for put in surface.GetInputs():
        assert put.GetConnectedSources()[0], put.GetBaseName()


def test_every_colorway_has_its_own_shader(tmp_path):
    first = cloth()
    looks = {"one": first, "two": cloth()}
    write_asset(first, tmp_path, colorways=looks, also=["glslfx", "exact"])
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "look.two.usda"))
    path = "/plain/Material/GlslfxSurface.info:glslfx:sourceAsset"
    assert layer.GetAttributeAtPath(path).default.path == "./cloth.two.glslfx"
    assert (tmp_path / "cloth.two.glslfx").is_file()
    assert (tmp_path / "exact.two.mtlx").is_file()


def test_it_stands_only_where_it_is_asked_for(tmp_path):
    write_asset(cloth(), tmp_path)
    stage = Usd.Stage.Open(str(tmp_path / "plain.usda"))
    prim = stage.GetPrimAtPath("/plain/Material")
    assert not prim.HasAttribute(f"outputs:{GLSLFX_CONTEXT}:surface")
    assert not (tmp_path / GLSLFX_FILE).exists()


def test_an_input_that_is_missing_is_a_slip():
    with pytest.raises(ValueError, match="expected the optics"):
        glslfx_text({"eta": (1.5,)})
