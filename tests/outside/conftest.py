"""Three assets of different kinds, published as a user does, for judges that are not ours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import weaveusd
from tests.weaves import draft_of, plain, satin, twill
from weaveusd.contract import DOORS
from weaveusd.draft.write import write_wif

SIDE = 60


def damask() -> np.ndarray:
    """A figure of 60 threads: a diamond in warp satin on a ground of weft satin."""
    middle = (SIDE - 1) / 2
    y, x = np.mgrid[:SIDE, :SIDE]
    figure = abs(x - middle) + abs(y - middle) < SIDE / 3
    face = np.tile(satin(5), (SIDE // 5, SIDE // 5))
    return np.where(figure, face, ~face[:, ::-1])


KINDS: dict[str, tuple[np.ndarray, dict[str, object]]] = {
    "denim": (twill(3, 1), {"preset": "denim"}),
    "chiffon": (plain(), {"preset": "chiffon", "colorways": {"shot": "shot_silk"}}),
    "damask": (damask(), {"preset": "charmeuse", "color_space": "acescg"}),
}

# One of them quickly, all of them where there is time.
KINDS_OF_ASSETS = [
    pytest.param("chiffon", id="chiffon"),
    pytest.param("denim", id="denim", marks=pytest.mark.slow),
    pytest.param("damask", id="damask", marks=pytest.mark.slow),
]


@pytest.fixture(scope="session")
def published(tmp_path_factory):
    """Return the folder of the published asset of a kind; it is made once."""
    root = tmp_path_factory.mktemp("published")
    made: dict[str, Path] = {}

    def folder(kind: str) -> Path:
        if kind not in made:
            warp_up, settings = KINDS[kind]
            draft = root / f"{kind}.wif"
            draft.write_bytes(write_wif(draft_of(warp_up)))
            done = weaveusd.publish(
                draft, root=root, name=kind, resolution=120, doors=DOORS, **settings
            )
            made[kind] = done.asset.folder
        return made[kind]

    return folder


@pytest.fixture(params=KINDS_OF_ASSETS)
def asset(request, published) -> Path:
    """The entry layer of each kind of asset."""
    return published(request.param) / f"{request.param}.usda"
