"""The relief of a visitor's touch, by its sensor's lamps: of a profile, or of several touches."""

import json
from io import BytesIO
from typing import Any

from app.pair.pictures import decoded, files_in, name_in
from app.shared.pair_input import profile_in
from app.shared.resources import Resources
from app.shared.state import Question, Reply, one_of
from omnivat.kit.errors import DataError
from omnivat.kit.progress import checkpoint

FEWEST, MOST = 5, 20  # touches of one request that give good lamps; more change them little
KINDS = ("figures", "npy", "ply")


def relief(resources: Resources, question: Question) -> bytes | Reply:
    """Return the relief of the first of several touches of one sensor, by the lamps of its profile
    or, where that holds none, by those that the touches give.

    question  the touches came with it; {"profile": of the sensor that made them; "as": "figures",
              to draw; "npy", slopes to the right and downwards and heights (H, W, 3) float32; or
              "ply", the heights as a surface}

    Raises DataError for none or too many touches, and where they give no lamps; ForgottenError for
    a profile that is not kept.
    """
    import numpy as np

    from omnivat.data.dots import fill_dots
    from omnivat.data.relief import heights, lamps, ply, slopes

    kind = one_of("as", question.get("as"), KINDS)
    profile = profile_in(resources, question)
    sent = files_in(question, MOST, "touch")
    known = profile and profile.lamps
    if profile and not known and len(sent) < FEWEST:
        raise DataError(
            f"The profile of your sensor holds no lamps. {FEWEST - len(sent)} more touches of it"
            " would give them, and with them the relief. Labels are not needed."
        )
    touches = []
    for part in sent[:1] if known else sent:
        image = decoded(resources, part, question)
        touches.append(fill_dots(np.asarray(image))[0])
        checkpoint()
    gel = known or lamps(touches, dots="keep")
    checkpoint()
    high, steep = (of(touches[0], gel, dots="keep") for of in (heights, slopes))
    if kind == "ply":
        return ply(high)
    if kind == "npy":
        with BytesIO() as file:
            np.save(file, np.concatenate([steep, high[..., None]], -1))
            return file.getvalue()
    lit = f"that {gel.pictures} touches of this sensor give"
    if known:
        lit = f"in the profile of your sensor, which {gel.pictures} touches gave"
    caption = (
        f"Drawn by the lamps {lit}, in 95 % of draws within cosine {gel.confidence:.2f}. Heights"
        " have no unit, and the sign may be wrong."
    )
    plots = drawn(name_in(question), high, steep, str(question.get("theme")))
    return {"figures": plots, "caption": caption}


def drawn(name: str, heights: Any, slopes: Any, theme: str) -> list[Any]:
    """Return heights (H, W) to turn, and slopes (H, W, 2), as Plotly's figures."""
    from omnivat import figures

    shown = (
        figures.relief(heights, title=f"Heights of {name}"),
        figures.slopes(slopes, title="Slopes, red where the gel rises"),
    )
    bare = {"title": "", "showticklabels": False}
    near = {"x": 0.3, "y": -1.1, "z": 0.9}  # from the picture's lower edge
    shown[0].update_scenes(xaxis=bare, yaxis=bare, zaxis=bare, camera={"eye": near})
    shown[0].update_layout(height=360, margin={"l": 0, "r": 0, "t": 40, "b": 0})
    template = "omnivat_dark" if theme == "dark" else "omnivat"
    return [json.loads(figure.update_layout(template=template).to_json()) for figure in shown]
