"""`python -m omnivat` is the command line."""

import sys

if __name__ == "__main__":
    try:
        from omnivat.cli import main
    except KeyboardInterrupt:  # stopped while Python was loading
        sys.exit(130)
    sys.exit(main())
