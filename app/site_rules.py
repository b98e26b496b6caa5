"""The numbers of the library that a page without a server needs in its scripts, too.

    python -m app.site_rules

writes `app/web/site/rules.js`; a test holds both together.
"""

import json

from app import familiar, pair_input, pictures, sensor
from app.components import WEB
from app.views import explore, pair
from omnivat.data import dots, grid, images, profile
from omnivat.head import calibration, output
from omnivat.kit.files import write_text
from omnivat.kit.stages import STOPS

FILE = WEB / "site" / "rules.js"
WIDTH = 120  # of a line of a script
HEAD = "/** Numbers of the library, written by `python -m app.site_rules`. */\n\n"
DOTS = ("SIDE", "WIDEST", "LONGEST", "SHORTEST", "MOST", "FAINTEST", "NODES", "SUPPORT", "STRAY")
TABLES = {
    "DOTS": {
        **{name: getattr(grid, name) for name in DOTS},
        "FAINT": grid.FAINT,
        "SMALLEST": dots.SMALLEST,
        "SWEEPS": dots.SWEEPS,
    },
    "PICTURE": {
        "MOST_JPEG": images.MAX_PIXELS,
        "MOST": images.VISITORS["pixels"],
        "SHORT_SIDE": images.SHORT_SIDE,
        "REDUCED": images.MOST_PIXELS,
        "LEAST_SIDE": images.MIN_SIDE,
        "STRIP": images.STRIP_PIXELS,
        "PREVIEW": pictures.PREVIEW_SIDE,
        "HIDDEN": pictures.SIDE,
    },
    "PAIR": {
        "STOPS": len(STOPS),
        "COLUMNS": pair.COLUMNS,
        "NEAREST": familiar.NEAREST,
        "NEIGHBOURS": explore.NEIGHBOURS,
        "READINGS": output.READINGS,
        "WORDS": tuple(text for _, text in calibration.WORDS),
        "UNLIKE": calibration.UNLIKE,
        "MOST_LESSONS": pair_input.MOST_LESSONS,
        "LONGEST_LABEL": pair_input.LONGEST_LABEL,
    },
    "PROFILE": {"FORMAT": profile.FORMAT, "MOST": profile.MOST, "DOMAIN": sensor.DOMAIN},
}


def rules() -> str:
    """Return the script."""
    script = HEAD
    for name, row in TABLES.items():
        parts = [f"{key}: {json.dumps(value)}" for key, value in row.items()]
        line = f"export const {name} = {{ {', '.join(parts)} }};"
        long = "{\n  " + ",\n  ".join(parts) + ",\n};"
        script += f"{line if len(line) <= WIDTH else f'export const {name} = {long}'}\n"
    return script


if __name__ == "__main__":
    write_text(FILE, rules())
