"""Choose a Mitsuba variant that works on this machine and make it the active one."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
from functools import lru_cache
from pathlib import Path

from weaveusd.errors import InputError, RendererUnavailableError
from weaveusd.render import llvm

CUDA = "cuda_ad_rgb"
LLVM = "llvm_ad_rgb"
SCALAR = "scalar_rgb"
VARIANTS = (CUDA, LLVM, SCALAR)
"""What can be asked for. The cloth is defined in linear Rec.709, hence rgb only."""

_CUDA_PROBE = """
import drjit as dr
import mitsuba as mi
mi.set_variant("cuda_ad_rgb")
scene = mi.load_dict({"type": "scene", "shape": {"type": "sphere"}})
hit = scene.ray_test(mi.Ray3f(mi.Point3f(0, 0, -5), mi.Vector3f(0, 0, 1)))
raise SystemExit(0 if bool(dr.all(hit)) else 1)
"""


def prepare(variant: str | None = None) -> str:
    """Activate a Mitsuba variant and return its name; the process never aborts.

    Without a wish it is `cuda_ad_rgb` where a CUDA device renders, else `llvm_ad_rgb` with an
    LLVM of version 19 or newer. `scalar_rgb` needs neither and is so slow that it is used only
    where asked for.

    Raises
    ------
    InputError
        For a variant that weaveusd does not know.
    RendererUnavailableError
        When Mitsuba or an LLVM that it can use is missing; the message says what to install.
    """
    if variant is not None and variant not in VARIANTS:
        raise InputError(f"unknown variant '{variant}': expected one of {', '.join(VARIANTS)}")
    chosen = variant or (CUDA if cuda_works() else LLVM)
    if chosen == CUDA and not cuda_works():
        raise RendererUnavailableError(
            f"{CUDA} needs an NVIDIA GPU with its driver, and none renders here: use {LLVM}"
        )
    if chosen == LLVM:
        _settle_llvm()
    elif "drjit" not in sys.modules:
        # Dr.Jit looks for an LLVM even where none is wanted, and complains on stderr.
        found = llvm.find()
        if found is not None:
            _point_to(found)
    _activate(chosen)
    return chosen


@lru_cache(maxsize=1)
def cuda_works() -> bool:
    """Return whether a CUDA device with OptiX traces a ray, tried in a child process."""
    try:
        cuda = ctypes.CDLL("libcuda.so.1")
        ctypes.CDLL("libnvoptix.so.1")
    except OSError:
        return False
    count = ctypes.c_int(0)
    if cuda.cuInit(0) != 0 or cuda.cuDeviceGetCount(ctypes.byref(count)) != 0 or count.value < 1:
        return False
    try:
        done = subprocess.run(
            [sys.executable, "-c", _CUDA_PROBE], capture_output=True, timeout=180, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0


def _settle_llvm() -> None:
    """Have Dr.Jit use a good LLVM, or raise before it can use a bad one."""
    if "drjit" in sys.modules:
        import drjit as dr

        major = int(dr.detail.llvm_version()[0])
        if major >= llvm.OLDEST_USABLE:
            return
        took = f"LLVM {major}" if major > 0 else "no LLVM"
        raise RendererUnavailableError(
            f"drjit was imported before weaveusd and took {took}, but needs {llvm.OLDEST_USABLE} "
            f"or newer: set {llvm.PATH_VARIABLE} to a newer libLLVM or import drjit later"
        )
    found = llvm.find()
    if found is None:
        raise RendererUnavailableError(
            f"rendering needs libLLVM {llvm.OLDEST_USABLE} or newer: {llvm.ADVICE}"
        )
    _point_to(found)


def _point_to(library: Path) -> None:
    llvm.preload(library)
    os.environ[llvm.PATH_VARIABLE] = str(library)


def _activate(variant: str) -> None:
    try:
        import mitsuba as mi
    except ImportError as error:
        raise RendererUnavailableError(
            f"Mitsuba cannot be imported ({error}): install it with `pip install mitsuba`"
        ) from error
    if variant not in mi.variants():
        raise RendererUnavailableError(f"this Mitsuba was built without the variant {variant}")
    mi.set_variant(variant)
    mi.set_log_level(mi.LogLevel.Error)
