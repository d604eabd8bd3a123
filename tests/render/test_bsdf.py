from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.render.cloths import PRESETS, direction, optics, plain_arrays, with_gaps
from weaveusd import contract
from weaveusd.shading.normalization import normalization
from weaveusd.yarn.recipe import preset_names, read_preset

FRAMES = {
    "flat": ((0, 0, 1), (0, 1, 0)),
    "tilted": ((0.5, -0.3, 0.8), (0.2, 1, 0.3)),
    "steep": ((0.9, 0.1, 0.35), (0.1, 1, -0.2)),
}
ANGLES = ((0, 0), (30, 40), (60, 100), (80, 200), (88, -30))


def cloth(
    arrays: Any, inputs: Any, uv_scale: tuple[float, float] = (1.0, 1.0), **options: Any
) -> Any:
    import mitsuba as mi

    from weaveusd.render.bsdf import cloth_bsdf_dict

    return mi.load_dict(cloth_bsdf_dict(arrays, inputs, uv_scale, **options), parallel=False)


def interaction(mi: Any, wi: Any, count: int = 1, uv: Any = (0.5, 0.5)) -> Any:
    from weaveusd.render import probe

    return probe.interaction(wi, count, uv)


def assert_sampled_as_told(mi: Any, bsdf: Any, wi: Any, trials: int, frame: str) -> None:
    from weaveusd.render import probe

    arrays = plain_arrays(*FRAMES[frame])
    normal, tangent = arrays["normal"][0, 0], arrays["tangent"][0, 0]
    found = probe.chi_square(bsdf, wi, normal=normal, tangent=tangent)
    assert not found.fault
    assert found.p_value >= probe.least_p_value(trials)
    assert found.density <= 1.005
    if frame == "flat":
        assert found.density == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize("preset", list(PRESETS))
@pytest.mark.parametrize("tau", [0.0, 0.3])
@pytest.mark.parametrize("frame", list(FRAMES))
def test_samples_follow_their_density(mi: Any, preset: str, tau: float, frame: str) -> None:
    trials = len(PRESETS) * 2 * len(FRAMES) * len(ANGLES)
    bsdf = cloth(plain_arrays(*FRAMES[frame]), optics(preset, tau=tau))
    for angle in (*ANGLES, (150, 70)):
        # From behind the surface the sampled and the told side must still be the same.
        assert_sampled_as_told(mi, bsdf, direction(*angle), trials, frame)


@pytest.mark.parametrize("preset", ["linen", "polyester flat", "polyester twisted"])
def test_gaussian_lobes_are_sampled_as_their_density_says(mi: Any, preset: str) -> None:
    for frame, angle in (("flat", (60, 100)), ("tilted", (30, 40)), ("steep", (80, 200))):
        arrays = plain_arrays(*FRAMES[frame])
        bsdf = cloth(arrays, optics(preset, tau=0.3), gaussian=True)
        assert_sampled_as_told(mi, bsdf, direction(*angle), 9, frame)


def test_a_white_volume_with_gaussian_lobes_reflects_all_light_at_its_brightest(mi: Any) -> None:
    arrays, inputs = plain_arrays(color=1.0), optics("shot warp", k_s=0.0)
    eta, k_d, gamma_s, gamma_v = (inputs[k][0] for k in ("eta", "k_d", "gamma_s", "gamma_v"))
    inputs["normalization"] = [normalization(eta, k_d, 0, gamma_s, gamma_v, gaussian=True)]
    found = [albedo(mi, arrays, inputs, (a, 90), gaussian=True) for a in range(0, 90, 10)]
    assert max(found) == pytest.approx(1, abs=0.01)


def test_value_density_and_sample_agree(mi: Any) -> None:
    bsdf = cloth(plain_arrays(*FRAMES["tilted"]), optics("linen", tau=0.3))
    context, count = mi.BSDFContext(), 4096
    si = interaction(mi, direction(40, 20), count)
    rng = mi.PCG32(size=count)
    bs, weight = bsdf.sample(
        context, si, rng.next_float32(), mi.Point2f(rng.next_float32(), rng.next_float32())
    )
    value, pdf = bsdf.eval_pdf(context, si, bs.wo)
    live = np.array(bs.pdf) > 0
    np.testing.assert_allclose(np.array(pdf)[live], np.array(bs.pdf)[live], rtol=2e-3)
    expected = np.array(value)[:, live] / np.array(pdf)[live]
    np.testing.assert_allclose(np.array(weight)[:, live], expected, rtol=2e-3)
    assert not np.array(weight)[:, ~live].any()
    np.testing.assert_array_equal(np.array(bsdf.eval(context, si, bs.wo)), np.array(value))
    np.testing.assert_array_equal(np.array(bsdf.pdf(context, si, bs.wo)), np.array(pdf))


def test_no_light_crosses_where_yarn_and_cloth_disagree_on_the_side(mi: Any) -> None:
    bsdf = cloth(plain_arrays(*FRAMES["steep"]), optics("linen", tau=0.3))
    context, wi = mi.BSDFContext(), direction(20, 0)
    normal = plain_arrays(*FRAMES["steep"])["normal"][0, 0]
    rng = np.random.default_rng(1)
    wo = rng.normal(size=(4096, 3))
    wo /= np.linalg.norm(wo, axis=1, keepdims=True)
    disagree = ((wo @ normal) * (normal @ wi) > 0) != (wo[:, 2] * wi[2] > 0)
    assert 100 < disagree.sum() < 4000
    value, pdf = bsdf.eval_pdf(
        context, interaction(mi, wi, 4096), mi.Vector3f(wo.T.astype(np.float32))
    )
    np.testing.assert_array_equal(np.array(pdf) == 0, disagree)
    np.testing.assert_array_equal(np.array(value).max(axis=0) == 0, disagree)


def test_a_gap_lets_light_pass_straight(mi: Any) -> None:
    arrays = plain_arrays(size=4)
    gaps = np.zeros((4, 4), bool)
    gaps[0, 0] = True
    bsdf = cloth(with_gaps(arrays, gaps), optics("linen"))
    context, wi = mi.BSDFContext(), direction(30, 10)
    si = interaction(mi, wi, uv=(0.1, 0.1))
    bs, weight = bsdf.sample(context, si, mi.Float(0.3), mi.Point2f(0.2, 0.7))
    np.testing.assert_allclose(np.array(bs.wo).ravel(), -np.array(wi), rtol=1e-6)
    np.testing.assert_allclose(np.array(weight), 1)
    assert bool(mi.has_flag(bs.sampled_type, mi.BSDFFlags.Null)[0])
    assert not np.array(bsdf.pdf(context, si, mi.Vector3f(0, 0, 1))).any()
    assert np.array(bsdf.eval_null_transmission(si)).ravel() == pytest.approx([1, 1, 1])
    covered = interaction(mi, wi, uv=(0.6, 0.6))
    assert not np.array(bsdf.eval_null_transmission(covered)).any()


def test_a_half_covered_texel_splits_its_samples(mi: Any) -> None:
    arrays = plain_arrays()
    arrays["opacity"][...] = 0.25
    bsdf, whole = cloth(arrays, optics("linen")), cloth(plain_arrays(), optics("linen"))
    context, count = mi.BSDFContext(), 1 << 14
    si = interaction(mi, direction(30, 10), count)
    rng = mi.PCG32(size=count)
    bs, weight = bsdf.sample(
        context, si, rng.next_float32(), mi.Point2f(rng.next_float32(), rng.next_float32())
    )
    null = np.array(mi.has_flag(bs.sampled_type, mi.BSDFFlags.Null))
    assert null.mean() == pytest.approx(0.75, abs=0.02)
    assert np.array(weight)[:, null] == pytest.approx(np.ones((3, null.sum())))
    wo = mi.Vector3f(*direction(20, 80))
    part, full = (np.array(b.eval(context, si, wo)) for b in (bsdf, whole))
    np.testing.assert_allclose(part, 0.25 * full, rtol=1e-5)


def test_disabled_components_are_neither_valued_nor_sampled(mi: Any) -> None:
    from weaveusd.render.exact import NULL, REFLECTION, TRANSMISSION

    arrays = plain_arrays()
    arrays["opacity"][...] = 0.5
    bsdf = cloth(arrays, optics("linen", tau=0.5))
    si = interaction(mi, direction(30, 10))
    above, below = (mi.Vector3f(*direction(a, 80)) for a in (20, 160))
    expected = {REFLECTION: (True, False), TRANSMISSION: (False, True), NULL: (False, False)}
    assert bsdf.component_count() == len(expected)
    for component, (up, down) in expected.items():
        context = mi.BSDFContext()
        context.component = component
        assert np.array(bsdf.eval(context, si, above)).any() == up
        assert np.array(bsdf.pdf(context, si, below)).any() == down
        bs, _ = bsdf.sample(context, si, mi.Float(0.9), mi.Point2f(0.3, 0.4))
        null = bool(mi.has_flag(bs.sampled_type, mi.BSDFFlags.Null)[0])
        assert null == (component == NULL)


def test_the_components_add_up_to_the_whole(mi: Any) -> None:
    arrays, inputs = plain_arrays(*FRAMES["tilted"]), optics("shot weft", tau=0.4)
    arrays["opacity"][...] = 0.7
    parts = [albedo(mi, arrays, inputs, (30, 40), component=k) for k in range(3)]
    assert sum(parts) == pytest.approx(albedo(mi, arrays, inputs, (30, 40)), rel=0.02)
    assert parts[2] == pytest.approx(0.3)


def test_where_one_side_is_asked_for_all_samples_go_there(mi: Any) -> None:
    from weaveusd.render.exact import REFLECTION, TRANSMISSION

    arrays, count = plain_arrays(), 4096
    arrays["opacity"][...] = 0.7
    bsdf = cloth(arrays, optics("linen", tau=0.1))
    for component, sign in ((REFLECTION, 1), (TRANSMISSION, -1)):
        context = mi.BSDFContext()
        context.component = component
        si = interaction(mi, direction(30, 40), count)
        rng = mi.PCG32(size=count)
        bs, weight = bsdf.sample(
            context, si, rng.next_float32(), mi.Point2f(rng.next_float32(), rng.next_float32())
        )
        assert (np.array(bs.wo)[2] * sign > 0).all()
        assert np.array(weight)[0].all()
        pdf = np.array(bsdf.pdf(context, si, bs.wo))
        np.testing.assert_allclose(pdf, np.array(bs.pdf), rtol=2e-3)


@pytest.mark.parametrize("tau", [0.0, 0.3, 1.0])
def test_the_volume_sends_tau_of_its_light_through_the_cloth(mi: Any, tau: float) -> None:
    arrays, inputs = plain_arrays(), optics("velvet", tau=tau, k_s=0.0)
    through, back = (albedo(mi, arrays, inputs, (40, 20), component=k) for k in (1, 0))
    assert through / (through + back) == pytest.approx(tau, abs=0.01)


def test_the_cloth_has_two_faces_that_are_alike(mi: Any) -> None:
    bsdf = cloth(plain_arrays(), optics("shot warp", tau=0.3))
    for out in (direction(50, 190), direction(130, 60)):
        wi, wo = np.array(direction(30, 40)), np.array(out)
        front, back = (
            bsdf.eval_pdf(
                mi.BSDFContext(),
                interaction(mi, (s * wi).tolist()),
                mi.Vector3f(*(s * wo).tolist()),
            )
            for s in (1, -1)
        )
        np.testing.assert_allclose(np.array(front[0]), np.array(back[0]), rtol=1e-5)
        np.testing.assert_allclose(np.array(front[1]), np.array(back[1]), rtol=1e-5)


def test_the_flags_say_what_the_cloth_does(mi: Any) -> None:
    bsdf = cloth(plain_arrays(), optics("linen"))
    flags = mi.BSDFFlags
    for flag in (flags.GlossyReflection, flags.GlossyTransmission, flags.Null, flags.FrontSide,
                 flags.BackSide, flags.SpatiallyVarying, flags.Anisotropic):  # fmt: skip
        assert mi.has_flag(bsdf.flags(), flag)
    assert not mi.has_flag(bsdf.flags(), flags.NonSymmetric)
    assert [mi.has_flag(bsdf.flags(k), flags.Null) for k in range(3)] == [False, False, True]


@pytest.mark.parametrize(("preset", "surface"), [("linen", 0.1902), ("velvet", 0.2635)])
def test_color_and_surface_lobe_share_the_whole_albedo(
    mi: Any, preset: str, surface: float
) -> None:
    # N_V gives the volume what the surface lobe leaves at its brightest: 1 − max E_R.
    arrays, inputs = plain_arrays(color=1.0), optics(preset, k_s=0.0)
    found = [albedo(mi, arrays, inputs, (angle, 90)) for angle in range(0, 90, 5)]
    assert max(found) == pytest.approx(1 - surface, abs=0.01)


@pytest.mark.parametrize("preset", list(PRESETS))
def test_a_white_cloth_in_a_white_world_never_glows(mi: Any, preset: str) -> None:
    arrays = plain_arrays(*FRAMES["tilted"], color=1.0)
    for angle in ((0, 0), (60, 100), (88, -30)):
        assert albedo(mi, arrays, optics(preset, tau=0.3), angle) <= 1.01


def albedo(
    mi: Any,
    arrays: Any,
    inputs: Any,
    angle: tuple[float, float],
    *,
    component: int | None = None,
    gaussian: bool = False,
) -> float:
    bsdf, count = cloth(arrays, inputs, gaussian=gaussian), 1 << 16
    context = mi.BSDFContext()
    if component is not None:
        context.component = component
    rng = mi.PCG32(size=count)
    si = interaction(mi, direction(*angle), count)
    choice, point = rng.next_float32(), mi.Point2f(rng.next_float32(), rng.next_float32())
    _, weight = bsdf.sample(context, si, choice, point)
    return float(np.array(weight)[1].mean())


def test_texels_are_found_where_uv_says(mi: Any) -> None:
    # Row 0 lies at v = 0, column 0 at u = 0; nearest, and periodic both ways.
    arrays = plain_arrays(size=2)
    arrays["base_color"][..., 0] = ((0.1, 0.2), (0.3, 0.4))
    bsdf = cloth(arrays, optics("linen"), uv_scale=(2.0, 4.0))
    u = np.array((0.01, 0.26, 0.01, 0.26, 0.51, -0.01), np.float32)
    v = np.array((0.01, 0.01, 0.13, 0.13, 0.26, -0.01), np.float32)
    si = interaction(mi, (0, 0, 1), 6)
    si.uv = mi.Point2f(u, v)
    red = np.array(bsdf.eval_diffuse_reflectance(si))[0]
    assert red == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.1, 0.4])


def test_a_mirrored_texture_mirrors_the_yarn(mi: Any) -> None:
    bsdf = cloth(plain_arrays(*FRAMES["tilted"]), optics("shot warp"))
    wi, wo = np.array(direction(30, 40)), np.array(direction(50, 190))
    straight = bsdf.eval(mi.BSDFContext(), interaction(mi, wi.tolist()), mi.Vector3f(*wo.tolist()))
    flip = np.array((1, -1, 1))
    si = interaction(mi, (wi * flip).tolist())
    si.dp_dv = mi.Vector3f(0, -1, 0)
    mirrored = bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(*(wo * flip).tolist()))
    np.testing.assert_allclose(np.array(mirrored), np.array(straight), rtol=1e-5)


def test_every_yarn_has_its_own_optics(mi: Any) -> None:
    arrays = plain_arrays(size=2)
    arrays["yarn_id"][..., 0] = ((0, 1), (2, 1))
    names = ("linen", "shot warp", "velvet")
    bsdf = cloth(arrays, optics(*names))
    wi, wo = direction(30, 40), mi.Vector3f(*direction(50, 190))
    for k, uv in enumerate(((0.2, 0.2), (0.7, 0.2), (0.2, 0.7))):
        alone = cloth(plain_arrays(), optics(names[k]))
        expected = alone.eval(mi.BSDFContext(), interaction(mi, wi), wo)
        found = bsdf.eval(mi.BSDFContext(), interaction(mi, wi, uv=uv), wo)
        np.testing.assert_allclose(np.array(found), np.array(expected), rtol=1e-5)


def test_parameters_can_be_changed_and_differentiated(mi: Any) -> None:
    import drjit as dr

    bsdf = cloth(plain_arrays(), optics("linen"))
    parameters = mi.traverse(bsdf)
    assert set(parameters.keys()) == {"packed", *contract.SHADER_YARN_INPUTS}
    si, wo = interaction(mi, direction(30, 40)), mi.Vector3f(*direction(30, 220))

    def value() -> Any:
        return bsdf.eval(mi.BSDFContext(), si, wo).x

    parameters["k_s"] = mi.Float(0.5)
    parameters.update()
    before = np.array(value())[0]
    dr.enable_grad(parameters["k_s"])
    dr.enable_grad(parameters["packed"])
    parameters.update()
    dr.backward(value())
    slope = np.array(dr.grad(parameters["k_s"]))[0]
    texels = np.array(dr.grad(parameters["packed"]))
    assert texels.shape == (1, 1, 8)
    assert texels[0, 0, 3] > 0  # a brighter yarn reflects more
    dr.disable_grad(parameters["k_s"])
    parameters["k_s"] = mi.Float(0.6)
    parameters.update()
    assert (np.array(value())[0] - before) / 0.1 == pytest.approx(slope, rel=1e-2)


@pytest.mark.parametrize("gaussian", [False, True])
@pytest.mark.parametrize("name", ["eta", "k_d", "gamma_s", "gamma_v", "tau", "normalization"])
def test_derivatives_are_those_of_finite_differences(mi: Any, name: str, gaussian: bool) -> None:
    import drjit as dr

    inputs = optics("linen", tau=0.3)
    bsdf = cloth(plain_arrays(*FRAMES["tilted"]), inputs, gaussian=gaussian)
    parameters, at = mi.traverse(bsdf), inputs[name][0]
    si, wo = interaction(mi, direction(30, 40)), mi.Vector3f(*direction(50, 190))

    def value(number: float) -> Any:
        parameters[name] = mi.Float(number)
        parameters.update()
        return bsdf.eval(mi.BSDFContext(), si, wo).x

    step = 0.02 * at
    expected = (np.array(value(at + step))[0] - np.array(value(at - step))[0]) / (2 * step)
    value(at)
    dr.enable_grad(parameters[name])  # without an update, as in an optimizer's first step
    dr.backward(bsdf.eval(mi.BSDFContext(), si, wo).x)
    assert np.array(dr.grad(parameters[name]))[0] == pytest.approx(expected, rel=0.02, abs=1e-6)


def test_half_floats_and_the_scalar_variant_give_the_same_picture(mi: Any) -> None:
    wi, out = direction(30, 40), direction(50, 190)
    arrays, inputs = plain_arrays(*FRAMES["tilted"]), optics("shot warp", tau=0.3)
    context = mi.BSDFContext()
    exact = cloth(arrays, inputs).eval(context, interaction(mi, wi), mi.Vector3f(*out))
    expected = np.array(exact).ravel()
    bsdf = cloth(arrays, inputs, dtype=np.float16)
    si = interaction(mi, wi)
    value, pdf = bsdf.eval_pdf(context, si, mi.Vector3f(*out))
    assert np.array(value).ravel() == pytest.approx(expected, rel=5e-3)
    bs, weight = bsdf.sample(context, si, mi.Float(0.6), mi.Point2f(0.3, 0.8))
    reflectance = bsdf.eval_diffuse_reflectance(si)
    found = [np.array(x).ravel() for x in (value, pdf, bs.wo, bs.pdf, weight, reflectance)]

    mi.set_variant("scalar_rgb")
    scalar = cloth(arrays, inputs, dtype=np.float16)
    si = mi.SurfaceInteraction3f()
    si.wi, si.uv = mi.Vector3f(*wi), mi.Point2f(0.5, 0.5)
    si.sh_frame = mi.Frame3f(mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0), mi.Vector3f(0, 0, 1))
    si.dp_dv = mi.Vector3f(0, 1, 0)
    context = mi.BSDFContext()
    value, pdf = scalar.eval_pdf(context, si, mi.Vector3f(*out))
    bs, weight = scalar.sample(context, si, 0.6, mi.Point2f(0.3, 0.8))
    reflectance = scalar.eval_diffuse_reflectance(si)
    again = [np.array(x).ravel() for x in (value, pdf, bs.wo, bs.pdf, weight, reflectance)]
    for one, other in zip(found, again, strict=True):
        np.testing.assert_allclose(other, one, rtol=1e-3, atol=1e-5)


def test_a_cloth_without_its_yarns_is_refused(mi: Any) -> None:
    arrays = plain_arrays()
    arrays["yarn_id"][...] = 3
    with pytest.raises(ValueError, match="yarn_id: names yarn 3, but the shader describes 1"):
        cloth(arrays, optics("linen"))


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("eta", [0.5], "eta: is 0.5, expected 1 to 3"),
        ("tau", [0.1, 0.2], "tau: has 2 values, but eta has 1"),
        ("gamma_s", [float("nan")], "gamma_s: is nan"),
    ],
)
def test_optics_out_of_range_are_refused(mi: Any, name: str, value: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        cloth(plain_arrays(), optics("linen") | {name: value})


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("normal", lambda a: a[..., :2], "normal: has shape"),
        ("tangent", lambda a: a * np.nan, "tangent: holds a value that is no finite number"),
        ("base_color", lambda a: a - 1, "base_color: leaves the range"),
        ("opacity", lambda a: a + 1, "opacity: leaves the range"),
        ("opacity", lambda a: np.tile(a, (2, 1, 1)), "opacity: is 1 x 2 texels"),
    ],
)
def test_broken_channels_are_refused(mi: Any, name: str, change: Any, message: str) -> None:
    arrays = plain_arrays()
    arrays[name] = change(arrays[name])
    with pytest.raises(ValueError, match=message):
        cloth(arrays, optics("linen"))


def preset_optics() -> dict[str, Any]:
    """One yarn of our presets for each set of optics that occurs in them."""
    found = {
        yarn.optics: f"{name}/{yarn.name}"
        for name in reversed(preset_names())
        for yarn in read_preset(name).yarns
    }
    return {key: optics for optics, key in found.items()}


@pytest.mark.parametrize("yarn", preset_optics().values(), ids=preset_optics())
def test_every_preset_is_sampled_as_its_density_says(mi: Any, yarn: Any) -> None:
    inputs = {name: [getattr(yarn, name)] for name in contract.SHADER_YARN_INPUTS
              if name != "normalization"}  # fmt: skip
    inputs["normalization"] = [
        normalization(yarn.eta, yarn.k_d, yarn.k_s, yarn.gamma_s, yarn.gamma_v)
    ]
    views = (("tilted", (30, 40)), ("flat", (60, 100)), ("steep", (80, 200)))
    for frame, angles in views:
        bsdf = cloth(plain_arrays(*FRAMES[frame]), inputs)
        trials = len(preset_optics()) * len(views)
        assert_sampled_as_told(mi, bsdf, direction(*angles), trials, frame)
