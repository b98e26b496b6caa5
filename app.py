"""Open the OmniVaT page: `python app.py`."""

import sys

if __name__ == "__main__":
    try:
        from app.serving.server import main

        sys.exit(main())
    except KeyboardInterrupt:  # before the server took over
        print("Stopped.", file=sys.stderr)
        sys.exit(130)
