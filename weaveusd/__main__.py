"""`python -m weaveusd` is the command line."""

from weaveusd.cli import main

main()
