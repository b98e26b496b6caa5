"""Count what a reader leaves out, so that a hundred thousand frames make a few lines."""

from collections import Counter

from omnivat.data.pairs import Skipped


class Tally:
    """How many pairs each thing stands for that was left out for a reason."""

    def __init__(self) -> None:
        self._counts: Counter[tuple[str, str]] = Counter()

    def add(self, what: str, why: str, count: int = 1) -> None:
        """Count `count` pairs of `what`, left out because of `why`."""
        self._counts[what, why] += count

    def skipped(self) -> tuple[Skipped, ...]:
        """Return one entry for each thing and reason, in the order they first came."""
        return tuple(
            Skipped(what=what, why=why, count=count) for (what, why), count in self._counts.items()
        )

    def reasons(self, limit: int = 3) -> str:
        """Return the commonest reasons in a few words, for the sentence of an error."""
        reasons: Counter[str] = Counter()
        for (_, why), count in self._counts.items():
            reasons[why] += count
        named = [f"{why} ({count})" for why, count in reasons.most_common(limit)]
        return f" Left out: {'; '.join(named)}." if named else ""
