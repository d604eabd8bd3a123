"""Time and memory of a whole publish, and the share of it that is spent encoding images.

    python benchmarks/publish.py [--quick]

Encoding is what OpenImageIO does between rows handed to it and a file closed: compression, and
reading back that the file is whole. Each publish runs in a child process; its memory is the
highest that the process held (VmHWM), validation included.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

DRAFT = Path(__file__).parents[1] / "examples" / "drafts" / "herringbone.wif"


def timed(seconds: dict[str, float], key: str, function: Callable[..., Any]) -> Callable[..., Any]:
    """Return `function`, which adds the time it takes to `seconds`."""

    def call(*args: Any, **settings: Any) -> Any:
        started = time.perf_counter()
        try:
            return function(*args, **settings)
        finally:
            seconds[key] = seconds.get(key, 0.0) + time.perf_counter() - started

    return call


def child(resolution: int) -> None:
    """Publish at `resolution` and print, as JSON, seconds of each part and the memory in MB."""
    import weaveusd.synth.textures
    import weaveusd.validate.run
    from weaveusd.export import images, textures
    from weaveusd.pipeline import publish
    from weaveusd.synth.model import TextureSet

    seconds: dict[str, float] = {}
    for name in ("__init__", "write", "__exit__"):
        method = getattr(images.ImageWriter, name)
        setattr(images.ImageWriter, name, timed(seconds, "encoding", method))
    textures.encode = timed(seconds, "conversion", textures.encode)
    weaveusd.validate.run.validate = timed(seconds, "validation", weaveusd.validate.run.validate)
    made = weaveusd.synth.textures.synthesize

    def synthesize(*args: Any, **settings: Any) -> TextureSet:
        out = made(*args, **settings)
        band = timed(seconds, "synthesis", out.band)
        return TextureSet(out.width, out.height, out.repeat_mm, out.seed, band)

    weaveusd.synth.textures.synthesize = synthesize
    with tempfile.TemporaryDirectory() as root:
        started = time.perf_counter()
        publish(DRAFT, preset="linen", root=root, resolution=resolution)
        seconds["all"] = time.perf_counter() - started
    status = Path("/proc/self/status").read_text()
    peak = next(line for line in status.splitlines() if line.startswith("VmHWM"))
    print(json.dumps({**seconds, "megabytes": int(peak.split()[1]) / 1024}))


def main() -> None:
    """Print a line for each resolution."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="1024² only")
    parser.add_argument("--child", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.child:
        child(arguments.child)
        return
    parts = ("synthesis", "conversion", "encoding", "validation")
    print(f"{'texels':>7}{'seconds':>9}" + "".join(f"{p:>12}" for p in parts) + "   peak memory")
    for resolution in (1024,) if arguments.quick else (2048, 4096, 8192):
        output = subprocess.run(
            [sys.executable, __file__, "--child", str(resolution)],
            stdout=subprocess.PIPE, text=True, check=True,
        ).stdout  # fmt: skip
        found = json.loads(output.splitlines()[-1])
        shares = "".join(f"{found.get(p, 0.0) / found['all']:>12.0%}" for p in parts)
        line = f"{resolution:>6}²{found['all']:>9.2f}{shares}{found['megabytes']:>11.0f} MB"
        print(line, flush=True)


if __name__ == "__main__":
    main()
