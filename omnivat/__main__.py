"""`python -m omnivat` is the command line."""

import sys

from omnivat.cli import main

if __name__ == "__main__":
    sys.exit(main())
