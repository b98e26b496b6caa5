"""What the page offers, as rows: modes of p, measures, steps, colours, methods, rungs, domains.

Each row has an id, a title and what it can do; scripts go by the ability, never by a name.
`app/web/shared/tables.json` has them, but for three: a gap of `omnivat.measure.gaps` is a measure,
too, the rungs are those of `omnivat.measure.rungs`, and the domains are the paper's with their
sensors.
"""

import json
from functools import cache
from pathlib import Path
from typing import Any

from omnivat.data.domains import DOMAINS
from omnivat.measure.gaps import GAPS, NAMES
from omnivat.measure.rungs import RUNGS

Row = dict[str, Any]
FILE = Path(__file__).parents[1] / "web" / "shared" / "tables.json"


@cache
def tables() -> dict[str, list[Row]]:
    """Return the rows by kind: "modes", "measures", "stages", "colours", "methods"."""
    rows: dict[str, list[Row]] = json.loads(FILE.read_bytes())
    return rows


def row_of(kind: str, name: Any) -> Row:
    """Return the row of this id; an empty one if there is none."""
    return next((row for row in tables()[kind] if row["id"] == name), {})


def tables_html() -> str:
    """Return the rows as an element that the page's scripts read."""
    words = "mean over pairs of domains and both modalities; dashed: the raw embedding"
    titles = {name: NAMES.get(name, name) for name in GAPS}
    gaps = [
        {"id": name, "title": title[:1].upper() + title[1:], "between": "domain to domain"}
        | {"help": words, "can": []}
        for name, title in titles.items()
    ]
    rows = tables() | {"measures": [*tables()["measures"], *gaps], "rungs": RUNGS}
    rows["domains"] = [{"id": name, "title": domain.title} for name, domain in DOMAINS.items()]
    text = json.dumps(rows, ensure_ascii=False).replace("<", "\\u003c")  # no tag ends the element
    return f'<script type="application/json" id="omnivat-tables">{text}</script>'
