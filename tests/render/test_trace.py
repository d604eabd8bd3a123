"""How the samples of a picture are spread."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest


def edge(mi: Any) -> Any:
    """A shining half plane with a slanted edge, seen from straight above."""
    square = mi.ScalarTransform4f().rotate([0, 0, 1], 20).translate([1, 0, 0])
    return mi.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2},
        "sensor": {
            "type": "orthographic",
            "to_world": mi.ScalarTransform4f().look_at([0, 0, 1], [0, 0, 0], [0, 1, 0])
            @ mi.ScalarTransform4f().scale([0.4, 0.4, 1]),
        },
        "lamp": {
            "type": "rectangle",
            "to_world": square,
            "emitter": {"type": "area", "radiance": 1.0},
        },
    }, parallel=False)  # fmt: skip


def test_an_edge_is_smoother_than_by_independent_samples(mi: Any) -> None:
    from weaveusd.render.trace import trace

    scene = edge(mi)
    covered = np.stack([trace(scene, (8, 8), 16, seed)[..., 0] for seed in range(40)])
    mean = covered.mean(0)
    independent = mean * (1 - mean) / 16
    crossed = independent > 0.004
    assert crossed.sum() >= 6
    assert covered.var(0)[crossed].mean() < 0.4 * independent[crossed].mean()


@pytest.mark.parametrize("spp", [1, 2, 7, 17, 30])
def test_every_number_of_samples_is_taken_as_asked(
    mi: Any, monkeypatch: pytest.MonkeyPatch, spp: int
) -> None:
    from weaveusd.render import trace

    taken = []
    wavefront = trace._wavefront

    def counted(scene: Any, size: Any, now: int, seed: int) -> Any:
        taken.append(now)
        return wavefront(scene, size, now, seed)

    monkeypatch.setattr(trace, "_wavefront", counted)
    image = trace.trace(edge(mi), (4, 4), spp, 3)
    assert sum(taken) == spp
    assert image.max() == pytest.approx(1)
