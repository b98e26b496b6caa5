"""One seed for a run, and an independent stream for each named use of it."""

from hashlib import blake2b


def derive_seed(run_seed: int, *names: str | int) -> int:
    """Return the 63-bit seed of the stream called `names`.

    Streams do not depend on one another nor on the order they are asked for, so adding one
    (a baseline, a domain, a tree level) leaves every earlier result as it was.

    >>> derive_seed(0, "split", "TAG") == derive_seed(0, "split", "TAG")
    True
    >>> derive_seed(0, "split", "TAG") == derive_seed(1, "split", "TAG")
    False
    """
    key = "\x1f".join(map(str, (run_seed, *names)))
    return int.from_bytes(blake2b(key.encode(), digest_size=8).digest(), "big") >> 1
