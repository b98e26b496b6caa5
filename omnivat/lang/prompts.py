"""Eighty fixed style phrases for each class, an alternative to PromptStyler."""

LOOKS = (
    "plain",
    "bright",
    "dark",
    "blurry",
    "sharp",
    "noisy",
    "grainy",
    "smooth",
    "rough",
    "shiny",
    "dull",
    "coloured",
    "grey",
    "worn",
    "clean",
    "scratched",
)
VIEWS = ("photo", "close-up", "tactile image", "rendering", "sensor reading")
STYLES = tuple(f"{look} {view}" for look in LOOKS for view in VIEWS)


def prompts_for(material: str) -> list[str]:
    """Return one prompt for each style.

    >>> prompts_for("wood")[0]
    'a plain photo of wood'
    """
    return [f"a {style} of {material}" for style in STYLES]
