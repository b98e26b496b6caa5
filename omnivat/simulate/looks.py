"""Which classes each class imitates by sight, and what such an object looks like.

An imitation wears the picture of the other class: its colours, its gloss, most of its shapes.
"""

IMITATIONS: dict[str, tuple[str, ...]] = {
    "wood": ("plastic", "ceramic", "steel"),  # painted, matt or glossy; metallic lacquer
    "steel": ("plastic", "ceramic", "wood"),  # powder coat; enamel; film with a picture of wood
    "plastic": ("wood", "steel", "glass", "ceramic"),  # laminate; faux metal; clear; melamine
    "ceramic": ("wood", "plastic", "steel"),  # wood-look tile; matt glaze; metallic glaze
    "glass": ("plastic", "ceramic", "steel"),  # dyed and opaque; milk glass; silvered
}
EMBOSSED = 0.3  # how much of the imitated relief shows in an imitation
OTHER_SHAPE = 0.7  # of the imitations come in a shape of the imitated class
