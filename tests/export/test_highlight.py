"""A rendered proof of the rule that a standard shader's tangent lies across the fibre."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.export.cloths import cloth, texture_set
from tests.export.glsl import Job, render
from weaveusd.export.asset import write_asset
from weaveusd.shading.material import StandardFit
from weaveusd.synth.model import Band


def flat_cloth(fibre: tuple[float, float, float], folder: Path) -> Path:
    """Write a black cloth of straight fibres, smooth along them, and return its document."""
    values = {
        "base_color": (0.0, 0.0, 0.0),
        "normal": (0.0, 0.0, 1.0),
        "tangent": fibre,
        "height": (0.0,),
        "opacity": (1.0,),
        "yarn_id": (0.0,),
        "system": (0.0,),
        "fibre_angle": (fibre[0] ** 2 - fibre[1] ** 2, 2 * fibre[0] * fibre[1]),
        "ambient_occlusion": (1.0,),
    }

    def band(first: int, last: int) -> Band:
        shape = (last - first, 32)
        return {
            name: np.broadcast_to(np.array(v, np.float32), (*shape, len(v))).copy()
            for name, v in values.items()
        }

    material, fit = cloth(), StandardFit(alpha_along=0.05, alpha_across=0.4, f0=0.3)
    write_asset(
        replace(
            material,
            textures=replace(texture_set(), band=band),
            fits=replace(material.fits, together=fit, yarns=(fit, fit)),
        ),
        folder,
    )
    return folder / "material.mtlx"


@pytest.mark.slow
@pytest.mark.parametrize("material", ["plain", "plain_standard_surface"])
@pytest.mark.parametrize(("fibre", "axis"), [((1.0, 0.0, 0.0), 1), ((0.0, 1.0, 0.0), 0)])
def test_a_highlight_is_narrow_along_the_fibre_and_wide_across(tmp_path, material, fibre, axis):
    (tmp_path / "asset").mkdir()
    document = flat_cloth(fibre, tmp_path / "asset")
    (picture,) = render([Job(str(document), material, str(tmp_path / "light.npy"))], tmp_path)
    light = picture[8:-8, 8:-8, 0]
    rows, columns = np.nonzero(light > light.max() / 2)
    extent = (np.ptp(columns), np.ptp(rows))
    assert extent[axis] > 5 * extent[1 - axis]
