"""`python -m chebid`: the command line."""

from chebid.cli import main

main()
