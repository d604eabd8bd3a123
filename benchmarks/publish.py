"""Time and memory of a whole publish, and the share of it that is spent encoding images.

    python benchmarks/publish.py [--quick]

Encoding is what OpenImageIO does between rows handed to it and a file closed: compression, and
reading back that the file is whole. Two shares are told. By the clock: the time during which a
file is being encoded, whatever else goes on beside it. By the processor: what encoding the same
files to the same bytes takes in a process that does nothing else, of all processor time of the
publish; and what adding up and writing the moment maps takes of it. Each publish runs in a child
process from its start, imports included; its memory is the highest that the process held (VmHWM),
validation included.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

DRAFT = Path(__file__).parents[1] / "examples" / "drafts" / "houndstooth.wif"
"""Its repeat is nearly square: 1874 × 2048 texels where 2048 are asked for."""


class Clock:
    """Seconds by the clock during which at least one thread did each of several things."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._busy: dict[str, int] = {}
        self._since: dict[str, float] = {}
        self.seconds: dict[str, float] = {}

    @contextmanager
    def during(self, key: str) -> Iterator[None]:
        """Count the time inside as `key`."""
        with self._lock:
            self._busy[key] = self._busy.get(key, 0) + 1
            if self._busy[key] == 1:
                self._since[key] = time.perf_counter()
        try:
            yield
        finally:
            with self._lock:
                self._busy[key] -= 1
                if not self._busy[key]:
                    passed = time.perf_counter() - self._since[key]
                    self.seconds[key] = self.seconds.get(key, 0.0) + passed

    def timed(self, key: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return `function`, the time of whose calls counts as `key`."""

        def call(*args: Any, **settings: Any) -> Any:
            with self.during(key):
                return function(*args, **settings)

        return call


def publish_timed(resolution: int, root: Path) -> dict[str, Any]:
    """Publish at `resolution`; return seconds of each part, memory in MB, and the textures."""
    started = time.perf_counter()
    import weaveusd.synth.textures
    import weaveusd.validate.run
    from weaveusd.export import asset, images
    from weaveusd.pipeline import publish
    from weaveusd.synth.model import TextureSet
    from weaveusd.synth.moment_sums import MomentSums

    clock = Clock()
    for name in ("__init__", "write", "__exit__"):
        method = getattr(images.ImageWriter, name)
        setattr(images.ImageWriter, name, clock.timed("encoding", method))
    judge = weaveusd.validate.run.validate
    weaveusd.validate.run.validate = clock.timed("validation", judge)
    made = weaveusd.synth.textures.synthesize
    repeat_mm: tuple[float, float] = (0.0, 0.0)

    def synthesize(*args: Any, **settings: Any) -> TextureSet:
        nonlocal repeat_mm
        out = made(*args, **settings)
        repeat_mm = out.repeat_mm
        band = clock.timed("synthesis", out.band)
        return TextureSet(out.width, out.height, out.repeat_mm, out.seed, band)

    weaveusd.synth.textures.synthesize = synthesize
    moments = 0.0

    def counted(function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*args: Any, **settings: Any) -> Any:
            nonlocal moments
            before = time.thread_time()
            out = function(*args, **settings)
            moments += time.thread_time() - before
            return out

        return call

    asset.write_moment_maps = counted(asset.write_moment_maps)
    MomentSums.add = counted(MomentSums.add)  # type: ignore[method-assign]
    done = publish(DRAFT, preset="linen", root=root, resolution=resolution)
    status = Path("/proc/self/status").read_text()
    peak = next(line for line in status.splitlines() if line.startswith("VmHWM"))
    return {
        **clock.seconds,
        "all": time.perf_counter() - started,
        "cpu": time.process_time(),
        "moments": moments,
        "megabytes": int(peak.split()[1]) / 1024,
        "textures": str(done.asset.folder / "textures"),
        "repeat_mm": repeat_mm,
    }


def encode_alone(folder: Path, repeat_mm: tuple[float, float]) -> dict[str, Any]:
    """Encode the published textures in `folder` again; return the processor time in seconds.

    Raises AssertionError when a file's bytes are not those that were published.
    """
    import numpy as np

    from weaveusd.contract import CHANNELS
    from weaveusd.export.textures import open_texture
    from weaveusd.validate.textures import TextureFolder

    source = TextureFolder(folder)
    seconds = 0.0
    with tempfile.TemporaryDirectory() as scratch:
        for channel in CHANNELS.values():
            for file in channel.files:
                bands = [band.pixels[file] for band in source.bands(file)]
                header = source.header(file)
                size = header.width, header.height
                before = time.process_time()
                with open_texture(
                    Path(scratch, file), channel, size, repeat_mm, "lin_rec709"
                ) as out:
                    for rows in bands:
                        out.write(np.ascontiguousarray(rows))
                seconds += time.process_time() - before
                assert Path(scratch, file).read_bytes() == (folder / file).read_bytes(), file
    return {"cpu": seconds, "texels": [header.width, header.height]}


def child(*arguments: str) -> dict[str, Any]:
    """Run this file with `arguments` in a process of its own and return what it printed last."""
    command = [sys.executable, __file__, *arguments]
    output = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
    found: dict[str, Any] = json.loads(output.splitlines()[-1])
    return found


def main() -> None:
    """Print a line for each resolution."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="1024² only")
    parser.add_argument("--publish", nargs=2, help=argparse.SUPPRESS)
    parser.add_argument("--encode", nargs=3, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.publish:
        resolution, root = arguments.publish
        print(json.dumps(publish_timed(int(resolution), Path(root))))
        return
    if arguments.encode:
        folder, *repeat_mm = arguments.encode
        print(json.dumps(encode_alone(Path(folder), (float(repeat_mm[0]), float(repeat_mm[1])))))
        return
    parts = ("encoding", "synthesis", "validation")
    print(f"{'texels':>12}{'seconds':>9}" + "".join(f"{p:>12}" for p in parts), end="")
    print(f"{'CPU seconds':>13}{'encoding':>10}{'moments':>9}   peak memory")
    for resolution in (1024,) if arguments.quick else (2048, 4096, 8192):
        with tempfile.TemporaryDirectory() as root:
            found = child("--publish", str(resolution), root)
            alone = child("--encode", found["textures"], *map(str, found["repeat_mm"]))
        width, height = alone["texels"]
        line = f"{f'{width} × {height}':>12}{found['all']:>9.2f}"
        line += "".join(f"{found[p] / found['all']:>12.0%}" for p in parts)
        line += f"{found['cpu']:>13.2f}{alone['cpu'] / found['cpu']:>10.0%}"
        line += f"{found['moments'] / found['cpu']:>9.1%}"
        print(f"{line}{found['megabytes']:>11.0f} MB", flush=True)


if __name__ == "__main__":
    main()
