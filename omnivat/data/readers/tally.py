"""Count skipped items, so that a hundred thousand frames give a few lines."""

from collections import Counter

from omnivat.data.pairs import Skipped


class Tally:
    """The number of pairs skipped for each item and reason."""

    def __init__(self) -> None:
        self._counts: Counter[tuple[str, str]] = Counter()

    def add(self, what: str, why: str, count: int = 1) -> None:
        """Count `count` pairs of `what`, skipped because of `why`."""
        self._counts[what, why] += count

    def skipped(self) -> tuple[Skipped, ...]:
        """Return one entry for each item and reason, in order of first appearance."""
        return tuple(Skipped(what=what, why=why, count=count) for (what, why), count in self._counts.items())

    def reasons(self, limit: int = 3) -> str:
        """Return the most frequent reasons in a few words, for an error."""
        reasons: Counter[str] = Counter()
        for (_, why), count in self._counts.items():
            reasons[why] += count
        named = [f"{why} ({count})" for why, count in reasons.most_common(limit)]
        return f" Left out: {'; '.join(named)}." if named else ""
