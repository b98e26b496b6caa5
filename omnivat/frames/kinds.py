"""The kind of stops in a frames file, which depends on how its head was trained."""

from omnivat.checkpoint import Head


def kind_of(head: Head) -> str:
    """Return the kind of a head's frames: "every" if trained with random p, else "moved"."""
    return (
        "every" if head.provenance.get("train", {}).get("order_draw", "none") != "none" else "moved"
    )
