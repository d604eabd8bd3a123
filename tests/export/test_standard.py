"""The rule that turns a fit into the inputs of standard shaders."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from weaveusd.export.standard import standard_shading
from weaveusd.shading.material import StandardFit

alphas = st.floats(0.01, 1.0)


@given(alphas, alphas, st.floats(0.0, 0.9))
def test_each_shader_gets_back_the_roughness_of_the_fit(one, other, f0):
    along, across = sorted((one, other))
    shading = standard_shading(StandardFit(along, across, f0))

    # open_pbr_anisotropy of MaterialX
    turned = 1 - shading.openpbr_anisotropy
    alpha_t = shading.openpbr_roughness**2 * math.sqrt(2 / (1 + turned**2))
    assert (alpha_t, turned * alpha_t) == pytest.approx((across, along))

    # roughness_anisotropy of MaterialX, before it limits the wide axis to 1
    aspect = math.sqrt(1 - shading.standard_anisotropy)
    squared = shading.standard_roughness**2
    assert (squared / aspect, squared * aspect) == pytest.approx((across, along))

    assert shading.preview_roughness**4 == pytest.approx(along * across)
    assert ((shading.ior - 1) / (shading.ior + 1)) ** 2 == pytest.approx(f0)


def test_equal_roughnesses_are_isotropic():
    shading = standard_shading(StandardFit(0.25, 0.25, 0.04))
    assert shading.openpbr_anisotropy == shading.standard_anisotropy == 0
    assert shading.openpbr_roughness == shading.preview_roughness == 0.5
    assert shading.ior == pytest.approx(1.5)


@pytest.mark.parametrize("fit", [(0.5, 0.2, 0.04), (0.2, 1.1, 0.04), (0.0, 0.5, 0.04), (1, 1, 1)])
def test_a_fit_out_of_range_is_a_slip(fit):
    with pytest.raises(ValueError, match="expected"):
        standard_shading(StandardFit(*fit))
