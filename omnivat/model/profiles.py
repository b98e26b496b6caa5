"""Named settings of whole heads, by which the paper's parameter counts were checked."""

from dataclasses import replace

from omnivat.errors import SettingsError
from omnivat.model.settings import HeadSettings, literal
from omnivat.tables import suggestion

PROFILES = ("core", "match", "literal", "light")
STYLE_NUMBERS = 80 * 512  # of PromptStyler's word vectors, which are not part of a head


def settings_for_profile(
    profile: str, *, classes: tuple[str, ...], input_width: int = 512, lang_width: int = 512
) -> HeadSettings:
    """Return the settings of a named head.

    core     D = 512, projections only where widths differ: 4.47 M at the widths of CLIP ViT-B/16
    match    with learned projections, one for images and one for text: 4.99 M, and 5.03 M with the
    styles,
             the closest that the equations come to the paper's 5.1 M
    literal  the core as printed; it does not train
    light    D = 64: 0.17 M, and 0.21 M with the styles (the paper's 0.2 M)

    Raises SettingsError for an unknown name.
    """
    core = HeadSettings(classes=classes, input_width=input_width, lang_width=lang_width, width=512)
    if profile == "core":
        return core
    if profile == "match":
        return replace(core, project=True, shared_projection=True)
    if profile == "literal":
        return literal(core)
    if profile == "light":
        return replace(core, width=64)
    raise SettingsError(
        f"No profile is called '{profile}'; there are {', '.join(PROFILES)}."
        f"{suggestion(profile, PROFILES)}"
    )
