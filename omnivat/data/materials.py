"""The five materials that all domains share."""

MATERIALS = ("wood", "steel", "plastic", "ceramic", "glass")
