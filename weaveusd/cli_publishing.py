"""One publish from the command line: between its hooks, and told to everybody who waits for it."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from weaveusd.cli_hooks import Hooks
from weaveusd.cli_output import json_text, print_json, say
from weaveusd.cli_telling import Log, ProgressKind, ResultFile, tell_farm, told_progress

if TYPE_CHECKING:
    from weaveusd.pipeline import Publication


def publish_and_tell(
    draft: Path,
    settings: dict[str, Any],
    hooks: Hooks,
    *,
    progress: ProgressKind,
    told: ResultFile,
    log: Log,
    as_json: bool,
    go_on: Callable[[], None],
) -> None:
    """Publish `draft` with the `settings` of `pipeline.publish`, between `hooks`.

    `go_on` is called as the work proceeds, and raises to end it. Whatever happens, the answer goes
    to `told`, to `log`, and as JSON or words to stdout; what was raised is raised again.
    """
    from weaveusd import pipeline

    started = time.perf_counter()
    request = _request(draft, settings)
    log.start(request)
    answer: dict[str, Any] = {
        "status": "failed", "asset": settings["name"], "version": None, "entry": None,
        "material": None, "files": [], "findings": [],
    }  # fmt: skip
    try:
        with told_progress(progress, f"publishing {draft.name}") as tell:
            hooks.ask(request, log)
            follow = log.following(tell)

            def proceed(share: float) -> None:
                if share < 1:  # then it is published
                    go_on()
                follow(share)

            done = pipeline.publish(draft, **settings, progress=proceed)
            answer = done.as_dict()
            hooks.tell(request, answer, log)
    except BaseException as error:
        log.note_error(error)
        if isinstance(error, Exception):
            answer["error"] = str(error) or type(error).__name__
        else:
            answer["error"] = "ended from outside"
        answer["findings"] = getattr(error, "findings", answer["findings"])
        answer.setdefault("seconds", round(time.perf_counter() - started, 3))
        raise
    finally:
        log.note(f"answer {json_text(answer)}")
        if as_json:
            print_json(answer)
        told.write(answer)
    if progress is ProgressKind.openjd:
        tell_farm("status", f"{done.asset.status} {done.asset.asset} {done.asset.version}")
    elif not as_json:
        _describe(done)


def _describe(done: Publication) -> None:
    """Say for people what was published."""
    asset = done.asset
    megabytes = sum(f.bytes for f in asset.files) / 1e6
    extent = f"{len(asset.files)} files, {megabytes:.1f} MB, {done.seconds:.1f} s"
    say(f"{asset.status} {asset.asset} {asset.version}: {extent}")
    say(f"  entry     {asset.entry}")
    say(f"  material  {asset.material}")
    say(f"  networks  {', '.join(_network(network) for network in done.losses)}")
    for finding in done.findings:
        say(f"  {finding['status']:<5} {finding['code']}: {finding['message']}")
    for yarn in done.colors_out_of_reach:
        color, reached = (_color(yarn[key]) for key in ("color", "reached"))
        name = ": ".join(yarn[key] for key in ("colorway", "yarn") if key in yarn)
        say(f"  note  {name} is {color}; its fibres reach {reached} in this weave")


def _request(draft: Path, settings: dict[str, Any]) -> dict[str, Any]:
    """Return what is to be published as JSON types, paths from the root of the file system."""
    paths = {"draft": draft, **{key: settings[key] for key in ("root", "recipe")}}
    named = {key: path and os.path.abspath(path) for key, path in paths.items()}
    colorways = {
        name: os.path.abspath(source) if source.endswith((".toml", ".wif")) else source
        for name, source in settings["colorways"].items()
    }
    return {**settings, **named, "colorways": colorways}


def _network(losses: dict[str, Any]) -> str:
    """Return the name of a network, and how far its reflectance is from the exact one."""
    errors = [effect["error"] for effect in losses["effects"] if "error" in effect]
    # The first is of the cloth seen near.
    return " ".join([str(losses["network"]), *(f"{error:.0%} off" for error in errors[:1])])


def _color(components: list[float]) -> str:
    return "(" + ", ".join(f"{c:.2f}" for c in components) + ")"
