from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.validate.assets import PLAIN, SATIN, TWILL, Bools, Channels, cloth, publish
from weaveusd.validate.run import validate

BASKET = np.kron(PLAIN, np.ones((2, 2), bool)).astype(bool)
WEAVES = {"plain": PLAIN, "twill": TWILL, "satin": SATIN, "basket": BASKET}


def codes(
    folder: Path, warp_up: Bools, change: Callable[[Channels], None] | None = None, cell: int = 16
) -> set[str]:
    entry = publish(folder, cloth(warp_up, cell=cell, change=change))
    findings = validate(entry, checks=["texture/tiles"]).findings
    return {finding.code for finding in findings} - {"texture/tiles/pass"}


def cut(axis: int, lines: int) -> Callable[[Channels], None]:
    def change(channels: Channels) -> None:
        for name, values in channels.items():
            channels[name] = np.delete(values, np.s_[-lines:], axis=axis)

    return change


def rolled(axis: int, lines: int) -> Callable[[Channels], None]:
    def change(channels: Channels) -> None:
        for name, values in channels.items():
            channels[name] = np.roll(values, lines, axis=axis)

    return change


def pushed(axis: int, lines: int) -> Callable[[Channels], None]:
    """Move the picture; what leaves on one side does not come back on the other."""

    def change(channels: Channels) -> None:
        for name, values in channels.items():
            places = np.clip(np.arange(values.shape[axis]) - lines, 0, None)
            channels[name] = np.take(values, places, axis=axis)

    return change


@pytest.mark.parametrize("cell", [9, 16, 33])
@pytest.mark.parametrize("warp_up", WEAVES.values(), ids=WEAVES)
def test_a_tile_joins_however_coarse(warp_up: Bools, cell: int, tmp_path: Path) -> None:
    assert codes(tmp_path / "v001", warp_up, cell=cell) == set()


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("warp_up", WEAVES.values(), ids=WEAVES)
def test_a_tile_that_begins_elsewhere_still_joins(
    warp_up: Bools, axis: int, tmp_path: Path
) -> None:
    assert codes(tmp_path / "v001", warp_up, rolled(axis, 5)) == set()


@pytest.mark.parametrize("seed", range(4))
def test_a_tile_of_any_weave_joins(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    picks, ends = rng.integers(2, 9, 2)
    assert codes(tmp_path / "v001", rng.random((picks, ends)) < 0.5) == set()


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("lines", [4, 6])
@pytest.mark.parametrize("warp_up", WEAVES.values(), ids=WEAVES)
def test_a_tile_with_lines_cut_off_does_not(
    warp_up: Bools, lines: int, axis: int, tmp_path: Path
) -> None:
    assert codes(tmp_path / "v001", warp_up, cut(axis, lines)) & {"tile-seam", "tile-cut"}


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("warp_up", WEAVES.values(), ids=WEAVES)
def test_a_tile_that_was_pushed_aside_does_not(warp_up: Bools, axis: int, tmp_path: Path) -> None:
    assert codes(tmp_path / "v001", warp_up, pushed(axis, 6)) & {"tile-seam", "tile-cut"}


def test_a_texture_that_is_too_coarse_is_not_judged(tmp_path: Path) -> None:
    assert codes(tmp_path / "v001", TWILL, cell=7) == {"tile-unread"}
