"""A published cloth measures as its yarns' color, in the renderer as in the mill."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import weaveusd
from weaveusd.cloth.weave import weave
from weaveusd.draft.make import make_draft
from weaveusd.draft.write import write_wif
from weaveusd.render.gain import albedos
from weaveusd.shading.measured import measured, texels_of
from weaveusd.shading.normalization import normalization
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.recipe import read_preset

renders = pytest.mark.usefixtures("renderer")


def d_8(bsdf):
    """Reflectance (3,) of a swatch on black, under even light, seen from 8° all around."""
    import mitsuba as mi

    tilt, at = np.radians(8), mi.ScalarTransform4f()
    scene = mi.load_dict({
        "type": "scene",
        "integrator": {"type": "direct", "emitter_samples": 0, "bsdf_samples": 1},
        "sky": {"type": "constant"},
        "swatch": {"type": "rectangle", "to_world": at.scale(4), "bsdf": bsdf},
        "bed": {"type": "rectangle", "to_world": at.translate((0, 0, -0.01)).scale(1000),
                "bsdf": {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": 0.0}}},
    }, parallel=False)  # fmt: skip
    found = []
    for k, turn in enumerate(np.arange(4) * np.pi / 2):
        away = np.array([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)])
        view = at.look_at(
            origin=away.tolist(), target=[0, 0, 0], up=[-np.sin(turn), np.cos(turn), 0]
        )
        sensor = {
            "type": "orthographic",
            "to_world": view,
            "film": {"type": "hdrfilm", "width": 32, "height": 32, "rfilter": {"type": "box"}},
        }
        picture = mi.render(scene, sensor=mi.load_dict(sensor), spp=512, seed=k)
        found.append(np.array(picture).mean(axis=(0, 1)))
    return np.mean(found, axis=0)


@renders
@pytest.mark.parametrize("preset", ["linen_plain", "charmeuse"])
def test_a_swatch_measures_as_its_yarns_color(preset):

    from weaveusd.render.bsdf import cloth_bsdf_dict

    recipe = read_preset(preset)
    made = weave(make_draft(recipe.weave or "plain"), recipe)
    color = (0.4, 0.25, 0.1)
    made = replace(made, yarns=tuple(replace(yarn, color=color) for yarn in made.yarns))
    textures = synthesize(made, resolution=256)
    arrays = dict(textures.whole())
    even = np.broadcast_to(np.array(color, np.float32), arrays["base_color"].shape)
    gains = [yarn.gain for yarn in measured(made, texels_of(made, textures))]
    arrays["base_color"] = albedos(even, arrays["yarn_id"], gains, len(gains))
    # Specular excluded: no surface lobe, while N_V stays that of the whole.
    optics = [yarn.optics for yarn in made.yarns]
    inputs = {name: [getattr(o, name) for o in optics]
              for name in ("eta", "k_d", "gamma_s", "gamma_v", "tau")}  # fmt: skip
    inputs["k_s"] = [0.0] * len(optics)
    inputs["normalization"] = [
        normalization(o.eta, o.k_d, o.k_s, o.gamma_s, o.gamma_v) for o in optics
    ]
    found = d_8(cloth_bsdf_dict(arrays, inputs, (8.0, 8.0)))
    expected = np.array(color) * float(np.mean(arrays["opacity"]))
    np.testing.assert_allclose(found, expected, rtol=0.02)


def test_gains_are_those_of_the_texels_yarn_and_albedos_stay_within_one():
    color = np.full((1, 3, 3), 0.5, np.float32)
    ids = np.array([[[0.0], [1.0], [-1.0]]])
    found = albedos(color, ids, [1.5, 3.0], 2)
    np.testing.assert_array_equal(found[0, :, 0], [0.75, 1.0, 0.75])


@pytest.mark.parametrize(
    ("gains", "message"),
    [
        ([1.0], "albedo_gain: has 1 values, but eta has 2"),
        ([1.0, -2.0], "albedo_gain: is -2, expected 0 to 1000"),
        ([1.0, float("nan")], "albedo_gain: is nan"),
    ],
)
def test_gains_that_mean_nothing_are_refused(gains, message):
    with pytest.raises(ValueError, match=message):
        albedos(np.zeros((1, 1, 3)), np.zeros((1, 1, 1)), gains, 2)


def test_a_publish_tells_which_colors_its_fibres_cannot_reach(tmp_path):
    draft = tmp_path / "plain.wif"
    draft.write_bytes(write_wif(make_draft("plain")))
    done = weaveusd.publish(draft, preset="poplin", root=tmp_path / "assets", resolution=64)
    told = done.as_dict()["colors_out_of_reach"]
    assert [yarn["yarn"] for yarn in told] == ["warp_1", "weft_2"]
    for yarn in told:
        assert 0.5 < max(yarn["reached"]) < 0.65 < max(yarn["color"])
    drill = weaveusd.publish(draft, preset="drill", root=tmp_path / "assets", resolution=64)
    assert drill.colors_out_of_reach == []
