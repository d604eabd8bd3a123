"""Plugins for pyblish: cloths are collected, validated, extracted and integrated.

    import pyblish.api, pyblish.util
    from weaveusd.integrations.pyblish import register

    register()
    context = pyblish.api.Context()
    context.data["weaveusd"] = [{"draft": "twill.wif", "preset": "linen", "root": "assets"}]
    pyblish.util.publish(context)

Each entry of ``context.data["weaveusd"]`` holds the arguments of `weaveusd.publish` and becomes an
instance of the family ``weaveusd.cloth``. After the publish the instance's ``data["publication"]``
is what `weaveusd.publish` returns as JSON types, the asset being that below `root`. A failure is
where pyblish has it: in ``context.data["results"]``, under ``"error"``. As pyblish goes on, one
cloth that fails its validation stops them all, and one that fails later stops itself.
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Any

import pyblish.api

from weaveusd import pipeline
from weaveusd.errors import InputError
from weaveusd.patch import Patch

FAMILY = "weaveusd.cloth"
KEY = "weaveusd"
"""Where a context holds what is to be published."""


class CollectWeaveCloths(pyblish.api.ContextPlugin):
    """Make an instance of each cloth that the context is asked for."""

    label = "Collect woven cloths"
    order = pyblish.api.CollectorOrder

    def process(self, context: Any) -> None:
        """Raise InputError where the context is asked for something of another form."""
        requests = context.data.get(KEY, [])
        if not isinstance(requests, list):
            raise InputError(f"context.data[{KEY!r}]: expected a list")
        for number, request in enumerate(requests):
            where = f"context.data[{KEY!r}][{number}]"
            if not isinstance(request, dict) or not {"draft", "root"} <= request.keys():
                raise InputError(f"{where}: expected a dictionary with 'draft' and 'root'")
            if "dry_run" in request:
                raise InputError(f"{where}: found 'dry_run', expected to stop before integration")
        for request in requests:
            instance = context.create_instance(Path(request["draft"]).stem, family=FAMILY)
            instance.data["families"] = [FAMILY]
            instance.data["request"] = dict(request)


class ValidateWeaveCloth(pyblish.api.InstancePlugin):
    """Read the draft and the recipe and make the cloth in memory; nothing is written."""

    label = "Validate woven cloth"
    order = pyblish.api.ValidatorOrder
    families = [FAMILY]

    def process(self, instance: Any) -> None:
        """Raise InputError where the draft, the recipe or a size is broken."""
        request = instance.data["request"]
        recipe = pipeline.read_recipe(preset=request.get("preset"), recipe=request.get("recipe"))
        sizes = ("resolution", "texels_per_mm", "repeats", "patch_mm")
        patch = Patch(*(request.get(size) for size in sizes))
        draft = pipeline.read_draft(request["draft"])
        pipeline.make_material(draft, recipe, "cloth", patch=patch)


class ExtractWeaveCloth(pyblish.api.InstancePlugin):
    """Make the asset in a temporary folder and have it judged."""

    label = "Extract woven cloth"
    order = pyblish.api.ExtractorOrder
    families = [FAMILY]

    def process(self, instance: Any) -> None:
        """Raise ValidationFailedError where the asset fails its checks."""
        staging = Path(tempfile.mkdtemp(prefix="weaveusd-"))
        instance.data["staging"] = str(staging)
        try:
            done = pipeline.publish(
                **{**instance.data["request"], "root": staging, "version": "next"}
            )
        except BaseException:
            shutil.rmtree(staging, ignore_errors=True)
            raise
        instance.data["publication"] = done.as_dict()


class IntegrateWeaveCloth(pyblish.api.InstancePlugin):
    """Publish the asset below the root of all assets, whole or not at all."""

    label = "Integrate woven cloth"
    order = pyblish.api.IntegratorOrder
    families = [FAMILY]

    def process(self, instance: Any) -> None:
        """Raise VersionConflictError where the version asked for has other content."""
        if "publication" not in instance.data:
            return  # its extraction failed and has told so
        request, publication = instance.data["request"], instance.data["publication"]
        try:
            asset = pipeline.adopt(
                publication["folder"],
                root=request["root"],
                version=request.get("version", "next"),
            )
        finally:
            shutil.rmtree(instance.data.pop("staging"), ignore_errors=True)
        instance.data["publication"] = {**publication, **asset.as_dict()}


PLUGINS = (CollectWeaveCloths, ValidateWeaveCloth, ExtractWeaveCloth, IntegrateWeaveCloth)


def register() -> None:
    """Register the plugins with pyblish; a second time changes nothing."""
    for plugin in PLUGINS:
        pyblish.api.register_plugin(plugin)


def deregister() -> None:
    """Take the plugins from pyblish again."""
    for plugin in PLUGINS:
        pyblish.api.deregister_plugin(plugin)
