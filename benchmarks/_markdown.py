"""Tables in Markdown."""

from collections.abc import Iterable, Sequence


def table(head: Sequence[str], rows: Iterable[Sequence[str]], mark: str = "---:") -> str:
    """Return a table whose first column holds words; `mark` aligns the others."""
    marks = ["---", *[mark] * (len(head) - 1)]
    return "\n".join(f"| {' | '.join(row)} |" for row in (head, marks, *rows))
