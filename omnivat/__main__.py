"""`python -m omnivat` is the command line."""

import sys

if __name__ == "__main__":
    try:
        from omnivat.cli import main

        sys.exit(main())
    except KeyboardInterrupt:  # while Python was loading
        print("Stopped. Nothing is half-written.", file=sys.stderr)
        sys.exit(130)
