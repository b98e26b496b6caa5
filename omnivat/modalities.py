"""The modalities by name, in the order of every tensor that holds them."""

IMAGES = ("vis", "tac")
MODALITIES = ("lang", *IMAGES)
