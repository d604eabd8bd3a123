"""The road from a draft to a published, rendered and judged asset."""

from __future__ import annotations
