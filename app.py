"""Open the OmniVaT page: `python app.py`."""

from app.server import main

if __name__ == "__main__":
    raise SystemExit(main())
