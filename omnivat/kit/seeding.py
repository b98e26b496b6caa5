"""One seed for each run, and an independent random stream for each named use."""

from hashlib import blake2b


def derive_seed(run_seed: int, *names: str | int) -> int:
    """Return the 63-bit seed of the stream called `names`.

    Streams are independent of one another and of the order of calls, so a new stream (a baseline, a
    domain, a tree level) changes no earlier result.

    >>> derive_seed(0, "split", "TAG") == derive_seed(0, "split", "TAG")
    True
    >>> derive_seed(0, "split", "TAG") == derive_seed(1, "split", "TAG")
    False
    """
    key = "\x1f".join(map(str, (run_seed, *names)))
    return int.from_bytes(blake2b(key.encode(), digest_size=8).digest(), "big") >> 1
