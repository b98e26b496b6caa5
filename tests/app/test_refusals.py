"""What cannot be answered is refused in one sentence, which says what is wanted."""

import json
from base64 import b64encode
from functools import partial

import numpy as np
import pytest

from app.pair.sensor import MOST_AT_ONCE
from app.pair.tab import MOST_AT_ONCE as MOST_PAIRS
from app.serving.routes import QUESTIONS, SENT
from app.shared.pair_input import MOST_LESSONS
from app.shared.requests import FILES
from app.shared.state import ForgottenError
from omnivat.kit.errors import DataError

from .conftest import LESSONS, own_image

RAW = {"point": 4, "stage": "raw"}
MIXED = "come from different pairs"
NOT_FINITE = b64encode(np.full(24, np.nan, np.float32).tobytes()).decode()
REFUSED = [
    ("pair", {}, "Choose a pair first"),
    ("pair", {"vis": "x" * 500}, "An image is named by a short text"),
    ("pair", {"vis": "file:/etc/passwd"}, "names no image"),
    ("pair", {"vis": "row:999"}, "No pair has the number '999'; there are 0 to 79"),
    ("pair", {"vis": "example:../../../etc/passwd"}, "No example is called"),
    (
        "pair",
        {"vis": "row:1", "head": "ghost"},
        "No head is called 'ghost'; there are none beside the first",
    ),
    *(("many", {"pairs": some}, "pairs") for some in ([], [{}] * (MOST_PAIRS + 1), [3])),
    ("neighbours", {"point": 4, "stage": "nowhere"}, "stage is 'nowhere'; choose one of raw"),
    ("neighbours", {**RAW, "point": 4000}, "No point has the number 4000"),
    ("neighbours", {"stage": "raw"}, "No point has the number None"),
    ("predictions", {"method": ["nearest_mean"]}, "choose one of nearest_mean"),
    ("teach", {"lessons": "all"}, "has to be a list"),
    ("teach", {"lessons": [{"vis": "row:1", "label": ""}]}, "A label is ''"),
    ("teach", {"lessons": [{"vis": "row:1", "label": "a" * 50}]}, "1 to 40 letters"),
    ("teach", {"lessons": LESSONS[:1] * (MOST_LESSONS + 1)}, "61 labelled pairs were sent"),
    ("teach", {"lessons": [{"label": "wood"}]}, "Choose a pair first"),
    ("teach", {"lessons": LESSONS[:1]}, "two or more pairs of each of two or more classes"),
    *(
        ("teach", {"lessons": [*LESSONS, {"vis": "row:40", "tac": tac, "label": "cork"}]}, MIXED)
        for tac in ("row:41", "image:own")
    ),
    ("taught", {"lessons": []}, "No pair is labelled"),
    ("save/head", {}, "No pair is labelled"),
    ("save/set", {"lessons": [{"vis": "row:1", "label": "wood"}]}, "label at least one photo"),
    *(
        ("profile", question, "pictures")
        for question in (
            {},
            {"photos": "image:0"},
            {"photos": [None]},
            {"touches": ["row:0"] * (MOST_AT_ONCE + 1)},
        )
    ),
    ("save/sensor", {}, "no profile of your sensor yet"),
    ("live", {"modality": "smell"}, "choose one of vis, tac, both"),
    ("live", {"modality": "both"}, "0 pictures came"),
    ("card", {}, "0 pictures came"),
    ("occlusion", {"modality": "vis"}, "0 pictures came"),
    ("occlusion", {"modality": "vis", "tac": "row:x"}, "No pair has the number 'x'"),
    ("pair", {"vis": "row:1", "with": ["everything"]}, "with has to be a list of familiar"),
    ("pair", {"vis": "image:KEY:AAAA"}, "cut short"),
    ("pair", {"vis": "image:KEY:" + NOT_FINITE}, "not finite"),
    ("pair", {"vis": "image:KEY:§"}, "damaged"),
]
FORGOTTEN = [
    ("pair", {"vis": "image:00"}, "Another encoder"),
    ("pair", {"vis": "row:1", "profile": "gone"}, "load it again"),
    ("pair", {"vis": "row:1", "taught": "0" * 32}, "no longer has the taught head"),
]


def own_in(resources, question):
    """Return a question with a visitor's own image and the encoder's key in their places."""
    text = json.dumps(question).replace("KEY", resources.encoder_key())
    return json.loads(
        text.replace("image:own", own_image(resources, resources.embeddings().vis[0]))
    )


@pytest.mark.parametrize(("route", "question", "words"), [*REFUSED, *FORGOTTEN])
def test_it_is_refused_with_what_is_wanted(resources, png, route, question, words):
    question = own_in(resources, question)
    if route == "occlusion" and "came" not in words:
        question[FILES] = [png()]
    ask = (
        partial(SENT[route][0], resources, png())
        if route in SENT
        else partial(QUESTIONS[route], resources)
    )
    with pytest.raises(DataError, match=words) as caught:
        ask(question)
    assert isinstance(caught.value, ForgottenError) == ((route, question, words) in FORGOTTEN)
    assert str(caught.value).endswith(".")


@pytest.mark.parametrize(
    ("limit", "route", "question"),
    [
        ("app.pair.tab.MOST_AT_ONCE", "many", {"pairs": LESSONS}),
        ("app.shared.pair_input.MOST_LESSONS", "teach", {"lessons": LESSONS}),
        ("app.pair.sensor.MOST_AT_ONCE", "profile", {"photos": ["image:own"] * len(LESSONS)}),
    ],
)
def test_as_many_as_stated_are_taken(resources, monkeypatch, limit, route, question):
    monkeypatch.setattr(limit, len(LESSONS))
    assert QUESTIONS[route](resources, own_in(resources, question))
