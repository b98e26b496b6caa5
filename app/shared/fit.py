"""Whether the loaded head fits the loaded set."""

import shlex

from app.shared.messages import without_places
from app.shared.resources import Resources
from omnivat.kit.errors import DataError

FITS = dict.fromkeys(("problem", "remedy", "command"), "")
REMEDY = (
    "This command trains a small head on the set, tests it on objects that it has not seen, and"
    " opens the page with it."
)
UNABLE = (
    "No domain has pairs of two classes, so no head can learn from the set. This command measures"
    " gaps, retrieval and neighbours, which need none."
)


def fit(resources: Resources) -> dict[str, str]:
    """Return why the first head cannot predict the set, a remedy and the command to run; each ""
    if it can.
    """
    if resources.where.frames is not None:
        return FITS
    embeddings = resources.embeddings()
    try:
        resources.head().require_embeddings(embeddings)
    except DataError as error:
        able = embeddings.learnable
        name = shlex.quote(resources.where.embeddings.name)
        return {
            "problem": without_places(str(error)),
            "remedy": REMEDY if able else UNABLE,
            "command": (
                f"python -m omnivat {f'try {name}' if able else f'report {name} --out report'}"
            ),
        }
    return FITS
