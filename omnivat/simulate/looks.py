"""Visual imitations: the imitated classes of each class, and their appearance.

An imitation has the colours, gloss and usually the shape of the other class.
"""

IMITATIONS: dict[str, tuple[str, ...]] = {
    "wood": ("plastic", "ceramic", "steel"),  # painted, matt or glossy; metallic lacquer
    "steel": ("plastic", "ceramic", "wood"),  # powder coat; enamel; film with a picture of wood
    "plastic": ("wood", "steel", "glass", "ceramic"),  # laminate; faux metal; clear; melamine
    "ceramic": ("wood", "plastic", "steel"),  # wood-look tile; matt glaze; metallic glaze
    "glass": ("plastic", "ceramic", "steel"),  # dyed and opaque; milk glass; silvered
}
EMBOSSED = 0.3  # share of the imitated relief in an imitation
OTHER_SHAPE = 0.7  # share of the imitations with a shape of the imitated class
