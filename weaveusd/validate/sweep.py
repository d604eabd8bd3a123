"""The sweep: every texture is decoded once, for all checks together, on all cores."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from weaveusd.errors import InputError
from weaveusd.validate.textures import Band, Reader, TextureFolder

if TYPE_CHECKING:
    from weaveusd.validate.textures import Pixels

Look = Callable[[Band], None]


@dataclass(slots=True, eq=False)
class Sweep:
    """What came of reading textures: files that do not decode, and looks that raised."""

    faults: dict[str, InputError] = field(default_factory=dict)
    broken: dict[str, Exception] = field(default_factory=dict)


def sweep(
    textures: TextureFolder,
    files: Sequence[str],
    looks: Mapping[str, Look],
    *,
    jobs: int,
    progress: Callable[[float], None] | None = None,
) -> Sweep:
    """Decode `files`, whose headers are known, once each, and show their bands to `looks`.

    `jobs` threads decode a band while the one before it is looked at, so that two bands of all
    files are in memory. Each look gets the bands one after the other, from the top down; looks
    run side by side, and one that raises gets no more. Nobody gets any once a file has failed.
    Files of several sizes are decoded, each to its end, and shown to nobody. `progress` is told
    the share of the rows read, 0…1.
    """
    found = Sweep()
    sizes = {(header.width, header.height) for header in map(textures.header, files)}
    # The longest work first, so that no thread is left with it at the end.
    ordered = sorted(files, key=lambda file: -textures.header(file).bytes)
    with ExitStack() as stack, ThreadPoolExecutor(jobs) as pool:
        readers = {}
        for file in ordered:
            opened = _open(textures, file, stack)
            if isinstance(opened, InputError):
                found.faults[file] = opened
            else:
                readers[file] = opened
        if len(sizes) != 1:
            _decode_apart(textures, readers, pool, found)
            return found
        spans = list(textures.header(ordered[0]).spans())
        decoding = _submit(pool, readers, spans[0])
        looking: dict[str, Future[None]] = {}
        for k, (first, last) in enumerate(spans):
            pixels = _pixels(decoding, readers, found)
            _finish(looking, found)
            if k + 1 < len(spans):
                decoding = _submit(pool, readers, spans[k + 1])
            if not found.faults:
                band = Band(first, pixels)
                looking = {
                    name: pool.submit(look, band)
                    for name, look in looks.items()
                    if name not in found.broken
                }
            if progress is not None:
                progress(last / spans[-1][1])
        _finish(looking, found)
    return found


def _open(textures: TextureFolder, file: str, stack: ExitStack) -> Reader | InputError:
    try:
        return textures.open(file, stack)
    except InputError as error:
        return error


def _submit(
    pool: ThreadPoolExecutor, readers: Mapping[str, Reader], span: tuple[int, int]
) -> dict[str, Future[Pixels]]:
    return {file: pool.submit(reader.read, *span) for file, reader in readers.items()}


def _pixels(
    decoding: Mapping[str, Future[Pixels]], readers: dict[str, Reader], found: Sweep
) -> dict[str, Pixels]:
    """Wait for a band and return it; files that do not decode are read no further."""
    pixels = {}
    for file, task in decoding.items():
        error = task.exception()
        if isinstance(error, InputError):
            found.faults[file] = error
            del readers[file]
        else:
            pixels[file] = task.result()
    return pixels


def _finish(looking: dict[str, Future[None]], found: Sweep) -> None:
    """Wait for the looks at a band and note those that raised."""
    for name, task in looking.items():
        error = task.exception()
        if isinstance(error, Exception):
            found.broken[name] = error
    looking.clear()


def _decode_apart(
    textures: TextureFolder, readers: Mapping[str, Reader], pool: ThreadPoolExecutor, found: Sweep
) -> None:
    def decode(file: str) -> None:
        for first, last in textures.header(file).spans():
            readers[file].read(first, last)

    for file, task in {file: pool.submit(decode, file) for file in readers}.items():
        error = task.exception()
        if isinstance(error, InputError):
            found.faults[file] = error
        elif error is not None:
            raise error
