"""The layered BSDF: its sampling, its energy, and the mirror that Mitsuba knows too."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

PLAIN: dict[str, Any] = {
    "base_color": (1, 1, 1), "metalness": (0,), "metal_f90": (1, 1, 1), "f0": (0.04,) * 3,
    "f90": (1, 1, 1), "alpha": (0.1, 0.1), "coat": (0,), "coat_f0": (0.04,),
    "coat_alpha": (0.01,), "coat_color": (1, 1, 1), "opacity": (1,), "emission": (0, 0, 0),
    "transmission": (0,), "transmission_color": (1, 1, 1),
}  # fmt: skip
METAL = {"metalness": (1,)}


def surface_of(*, clear_base: bool = False, **values: Any) -> Any:
    """A surface of constants, white and plain but for the values given."""
    from weaveusd.render.fields import Fields
    from weaveusd.render.surface import Surface

    fields = Fields()
    constants = {name: fields.constant(*v) for name, v in (PLAIN | values).items()}
    return Surface(ior=1.5, thin_walled=False, clear_base=clear_base, **constants)


def bsdf_of(mi: Any, **values: Any) -> Any:
    from weaveusd.render.layered import layered_bsdf

    return mi.load_dict(layered_bsdf(surface_of(**values), None))


def seen_from(mi: Any, theta: float, phi: float, count: int) -> Any:
    """Interactions on a plane, seen at these angles in degrees."""
    import drjit as dr

    si = dr.zeros(mi.SurfaceInteraction3f, count)
    si.sh_frame = mi.Frame3f(mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0), mi.Vector3f(0, 0, 1))
    si.dp_du, si.dp_dv = mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0)
    t, p = np.radians(theta), np.radians(phi)
    si.wi = mi.Vector3f(
        float(np.sin(t) * np.cos(p)), float(np.sin(t) * np.sin(p)), float(np.cos(t))
    )
    return si


def albedo(mi: Any, bsdf: Any, theta: float, phi: float = 0.0) -> float:
    """The mean weight of 65536 samples: all light that leaves, with what goes straight on."""
    count = 1 << 16
    random = mi.PCG32(count)
    place = mi.Point2f(random.next_float32(), random.next_float32())
    si = seen_from(mi, theta, phi, count)
    _, weight = bsdf.sample(mi.BSDFContext(), si, random.next_float32(), place, True)
    return float(np.array(weight).mean())


ANGLES = (0, 30, 60, 75, 85)


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"alpha": (1, 1)},
        {"alpha": (0.3, 0.3), "f0": (0.2, 0.2, 0.2)},
        {**METAL, "alpha": (0.04, 0.04)},
        {**METAL, "alpha": (0.5, 0.5)},
        {**METAL, "alpha": (1, 1)},
        {"metalness": (0.5,), "alpha": (0.3, 0.3)},
        {"coat": (1,), "coat_alpha": (0.2,), "alpha": (0.4, 0.4)},
        {"clear_base": True, "opacity": (0.3,)},
    ],
)
def test_white_gives_back_all_it_receives(mi: Any, values: dict[str, Any]) -> None:
    bsdf = bsdf_of(mi, **values)
    assert [albedo(mi, bsdf, angle) for angle in ANGLES] == pytest.approx([1.0] * 5, abs=0.006)


@pytest.mark.parametrize("alpha", [(0.8, 0.1), (0.3, 0.01), (1, 0.5), (1, 0.05)])
def test_a_stretched_mirror_gives_back_no_more_than_it_receives(
    mi: Any, alpha: tuple[float, float]
) -> None:
    bsdf = bsdf_of(mi, **METAL, alpha=alpha)
    found = [albedo(mi, bsdf, angle, phi) for angle in ANGLES for phi in (0, 30, 60, 90)]
    assert max(found) <= 1.005


def test_without_an_interface_only_diffuse_light_is_left(mi: Any) -> None:
    bsdf = bsdf_of(mi, f0=(0, 0, 0), base_color=(0.3, 0.3, 0.3))
    assert [albedo(mi, bsdf, angle) for angle in ANGLES] == pytest.approx([0.3] * 5, abs=1e-3)


@pytest.mark.parametrize(
    ("values", "theta", "phi"),
    [
        ({"alpha": (0.6, 0.2), "coat": (0.5,), "coat_alpha": (0.3,)}, 30, 40),
        ({**METAL, "alpha": (0.4, 0.4)}, 75, 40),
        ({"alpha": (0.3, 0.3), "clear_base": True, "opacity": (0.3,)}, 130, 40),
    ],
)
def test_samples_follow_their_density(
    mi: Any, values: dict[str, Any], theta: float, phi: float, capsys: Any, tmp_path: Any,
    monkeypatch: Any,
) -> None:  # fmt: skip
    import drjit as dr
    from mitsuba.chi2 import ChiSquareTest, SphericalDomain

    monkeypatch.chdir(tmp_path)  # a test that fails writes its histograms where it runs
    bsdf, context = bsdf_of(mi, **values), mi.BSDFContext()

    def sample(numbers: Any) -> tuple[Any, Any]:
        si = seen_from(mi, theta, phi, dr.width(numbers))
        drawn, _ = bsdf.sample(context, si, numbers[0], mi.Point2f(numbers[1], numbers[2]))
        good = (drawn.pdf > 0) & ~mi.has_flag(drawn.sampled_type, mi.BSDFFlags.Null)
        return drawn.wo, dr.select(good, 1.0, 0.0)

    def density(wo: Any) -> Any:
        return bsdf.pdf(context, seen_from(mi, theta, phi, dr.width(wo)), wo)

    test = ChiSquareTest(
        domain=SphericalDomain(), sample_func=sample, pdf_func=density, sample_dim=3,
        sample_count=200_000, res=101, ires=16,
    )  # fmt: skip
    assert test.run(0.01), capsys.readouterr().out


def test_a_smooth_metal_is_mitsubas_rough_conductor(mi: Any) -> None:
    # With little roughness no light is lost between facets: D G2 F / (4 cos θi) is left.
    import drjit as dr

    ours = bsdf_of(mi, **METAL, alpha=(0.1, 0.1))
    theirs = mi.load_dict(
        {"type": "roughconductor", "material": "none", "alpha": 0.1, "distribution": "ggx"}
    )
    count = 2000
    random = mi.PCG32(count)
    light = mi.warp.square_to_uniform_hemisphere(
        mi.Point2f(random.next_float32(), random.next_float32())
    )
    for theta in (10, 40):
        si, context = seen_from(mi, theta, 20, count), mi.BSDFContext()
        a, b = (np.array(bsdf.eval(context, si, light)) for bsdf in (ours, theirs))
        bright = b[0] > 0.1
        assert dr.width(light) == count
        assert bright.sum() > 20
        # Mitsuba's shadowing of the two directions is not correlated: up to 4 % less here.
        np.testing.assert_allclose(a[0][bright], b[0][bright], rtol=0.04)


def test_highlights_of_clear_surfaces_remain(mi: Any) -> None:
    # F = 1/25 is reflected by a pane without any opacity; by presence it would be nothing.
    bsdf = bsdf_of(mi, clear_base=True, opacity=(0,), base_color=(0.5, 0.5, 0.5))
    si = seen_from(mi, 0, 0, 1)
    assert float(bsdf.eval_null_transmission(si)[0][0]) == pytest.approx(0.96, abs=5e-3)
    assert albedo(mi, bsdf, 0) == pytest.approx(1.0, abs=5e-3)


def test_the_table_of_albedos_is_that_of_the_mirror(mi: Any) -> None:
    from weaveusd.render.mirror_albedo import ggx_albedo

    table = ggx_albedo()
    assert table.min() >= 0
    assert table.sum(axis=-1).max() <= 1
    # Polished, a mirror reflects all: Schlick's term of the view is what divides A and B.
    cosine = np.linspace(0, 1, table.shape[1])
    np.testing.assert_allclose(table[1, 8:, 1], (1 - cosine[8:]) ** 5, atol=0.01)
    np.testing.assert_allclose(table[1, 8:].sum(axis=-1), 1, atol=0.01)
