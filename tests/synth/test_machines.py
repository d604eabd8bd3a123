"""Textures are the same bytes on every machine, whatever its libraries and vector units."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.weaves import satin, woven
from weaveusd.synth.moments import sections
from weaveusd.synth.plan import lay_threads
from weaveusd.synth.tones import lay_tones
from weaveusd.yarn.irregularity import Irregularity

UNEVEN = Irregularity(thickness=0.1, thickness_correlation_mm=1, bend=0.2, color=3)

DIGEST = """
import hashlib
from tests.synth.test_machines import uneven
from weaveusd.synth.moments import moment_maps
from weaveusd.synth.textures import synthesize
made = synthesize(uneven(), resolution=128, seed=2)
out = made.whole()
maps = moment_maps(uneven(), made, width=9, height=7)
arrays = [*(out[name] for name in sorted(out)), *(of.moments for of in maps)]
print(hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest())
"""


def uneven():
    """A satin whose yarns vary in all they can, one system with conic spines and plies."""
    cloth = woven(satin(), "linen")
    warp, weft = (
        replace(y, irregularity=UNEVEN, spine=spine, kappa=-0.3, plies=plies, twist_deviation=0.1)
        for y, spine, plies in zip(cloth.yarns, ("conic", "circle"), (2, 1), strict=True)
    )
    return replace(cloth, yarns=(warp, weft))


def digest(**environment: str) -> str:
    """The SHA-256 of textures and moments, computed by another process."""
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", DIGEST],
        cwd=Path(__file__).parents[2], env={**os.environ, **environment},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return done.stdout.strip()


@pytest.mark.parametrize("toward", [0.0, np.inf])
def test_the_last_bit_of_a_library_changes_no_number_of_a_thread(toward):
    """Arc tangents and powers come from libraries, which round the last bit as they like."""

    def nudged(floats):
        return replace(floats, u_max=np.nextafter(floats.u_max, toward))

    cloth = uneven()
    other = replace(
        cloth,
        yarns=tuple(
            replace(
                y,
                twist_angle=float(np.nextafter(y.twist_angle, toward)),
                color=tuple(np.nextafter(y.color, toward).tolist()),
            )
            for y in cloth.yarns
        ),
        warp_floats=nudged(cloth.warp_floats),
        weft_floats=nudged(cloth.weft_floats),
    )
    for one, two in zip(lay_threads(cloth, 2), lay_threads(other, 2), strict=True):
        for name in one._fields:
            np.testing.assert_array_equal(getattr(one, name), getattr(two, name), err_msg=name)
    assert sections(cloth) == sections(other)
    np.testing.assert_array_equal(lay_tones(cloth.yarns).scale, lay_tones(other.yarns).scale)
    np.testing.assert_array_equal(lay_tones(cloth.yarns).color, lay_tones(other.yarns).color)


@pytest.mark.slow
def test_a_machine_without_vector_units_computes_the_same_bits(tmp_path):
    found = np.show_config(mode="dicts")["SIMD Extensions"]["found"]
    plain = {
        "NUMBA_CPU_NAME": "generic",
        "NUMBA_CPU_FEATURES": "",
        "NUMBA_CACHE_DIR": str(tmp_path),
        "NPY_DISABLE_CPU_FEATURES": " ".join(found),
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F",
    }
    assert digest(**plain) == digest()
