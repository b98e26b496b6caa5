"""What the stops of a frames file are, by how its head was trained."""

from omnivat.checkpoint import Head


def kind_of(head: Head) -> str:
    """Return what the frames of a head are: "every" for one trained with random p, else "moved"."""
    return (
        "every" if head.provenance.get("train", {}).get("order_draw", "none") != "none" else "moved"
    )
