"""Make the drafts of this folder anew: each is one word of notation, and comes out the same."""

from __future__ import annotations

from pathlib import Path

from weaveusd.draft.make import make_draft
from weaveusd.draft.write import write_wif

DRAFTS = {
    "plain.wif": "plain@d8cbb2,f2eee4",  # unbleached and bleached linen
    "twill_2_2.wif": "twill:2/2:Z@2b3a5c,c9b48a",  # navy and camel
    "herringbone.wif": "herringbone:2/2:8@4a4038,cfc4b4",  # brown and oatmeal
    "satin_5.wif": "satin:5:2@7a1f2b,9c3a3f",  # two reds
    "houndstooth.wif": "houndstooth@1c1c1e,efebe2",  # black and white
}


def main() -> None:
    """Write the drafts beside this file."""
    for name, notation in DRAFTS.items():
        Path(__file__).with_name(name).write_bytes(write_wif(make_draft(notation)))


if __name__ == "__main__":
    main()
