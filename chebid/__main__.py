"""`python -m chebid`: the command line."""

from chebid.cli import main

if __name__ == "__main__":
    main()
