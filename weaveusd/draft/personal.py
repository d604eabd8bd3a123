"""What a WIF says of the person who drew it: read only where it is asked for."""

from __future__ import annotations

from weaveusd.draft.scan import scan
from weaveusd.draft.text import one_line

FIELDS = ("Author", "Address", "EMail", "Telephone", "FAX")
"""The personal fields of a WIF's section TEXT, in the order in which they are written."""


def personal_fields(data: bytes, name: str) -> dict[str, str]:
    """Return the personal fields in the bytes of a WIF that are not empty, by name.

    `name` stands for the file in messages. A `Draft` never holds them.

    Raises
    ------
    DraftError
        The file exceeds a limit of the scanner.
    """
    section = scan(data, name).sections.get("TEXT")
    rows = section.rows if section is not None else {}
    found = {field: one_line(rows.get(field.lower(), (0, ""))[1]) for field in FIELDS}
    return {field: value for field, value in found.items() if value}
