"""Whether a stage moves at all."""

from __future__ import annotations

from pxr import Sdf, Tf, Usd


def moves(stage: Usd.Stage) -> bool:
    """Return whether any value differs between two times.

    Layers without time samples are seen to be still at once; otherwise every prim is asked.
    """
    if not any(_holds_samples(layer) for layer in stage.GetUsedLayers()):
        return False
    everything = Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate))
    return any(
        _changes(attribute) for prim in everything for attribute in prim.GetAuthoredAttributes()
    )


def _holds_samples(layer: Sdf.Layer) -> bool:
    return bool(layer.ListAllTimeSamples())


def _changes(attribute: Usd.Attribute) -> bool:
    if not attribute.ValueMightBeTimeVarying():
        return False
    try:
        times = attribute.GetTimeSamples()
        first = attribute.Get(times[0]) if times else None
        return any(attribute.Get(time) != first for time in times[1:])
    except (Tf.ErrorException, RuntimeError):
        return True
