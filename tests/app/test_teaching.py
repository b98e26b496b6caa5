"""A visitor's own labelled pairs: teaching, and saving what they make."""

import io
import zipfile

import pytest

from app.pair.pictures import live, occlusion
from app.pair.tab import many, predicted
from app.pair.teaching import curve, save_set, save_taught, taught, teach
from app.shared.pair_input import reader_of
from app.shared.requests import FILES
from omnivat.data.store import load_embeddings
from omnivat.head.checkpoint import load_head

from .conftest import LESSONS


def test_teaching_reports_every_pair_before_and_after(resources):
    got = teach(resources, {"lessons": LESSONS})
    assert [one["label"] for one in got["judged"]] == ["cork", "cork", "glass", "glass"]
    assert got["right"]["before"] <= 2  # the head lacks cork
    assert got["classes"][-1] == "cork"


def test_the_curve_of_labels_ends_with_what_teaching_brings(resources):
    question = {"lessons": LESSONS}
    found = curve(resources, question)
    after = teach(resources, question)["right"]["after"]
    assert [(one["objects"], one["right"]) for one in found["points"]] == [(1, after / 4)]
    assert found["words"].startswith("Label a third object")


def test_a_pair_can_be_predicted_by_the_taught_head(resources):
    question = {"vis": "row:40", "tac": "row:40"}
    plain = predicted(resources, question)
    own = predicted(resources, {**question, "lessons": LESSONS})
    assert own["classes"] == [*plain["classes"], "cork"]
    first, again = (reader_of(resources, {"lessons": LESSONS})[0] for _ in range(2))
    assert first is again
    assert reader_of(resources, {})[0] is resources.head()


def test_labelled_pairs_are_saved_as_a_set_that_loads(resources, tmp_path):
    photo = {"vis": "row:1", "tac": None, "label": "wood"}
    content = save_set(resources, {"lessons": [*LESSONS, photo]})
    zipfile.ZipFile(io.BytesIO(content)).extractall(tmp_path)
    found = load_embeddings(tmp_path / "my-pairs" / "embeddings.safetensors")
    assert (len(found), found.header.classes) == (4, ("cork", "glass"))
    resources.head().require_embeddings(found)
    assert (found.vis == resources.embeddings().vis[[40, 41, 72, 73]]).all()


def test_the_taught_head_is_saved_as_a_folder_that_loads(resources, tmp_path):
    content = save_taught(resources, {"lessons": LESSONS})
    zipfile.ZipFile(io.BytesIO(content)).extractall(tmp_path)
    assert load_head(tmp_path / "taught-head").settings.classes[-1] == "cork"


@pytest.mark.parametrize("of_image", [occlusion, live])
def test_requests_with_an_image_use_the_taught_head_as_the_headline_does(resources, png, of_image):
    question = {"modality": "vis"}
    name = taught(resources, {"lessons": [{**one, "label": "cork"} for one in LESSONS]})
    plain, own = (of_image(resources, {**question, **one, FILES: [png()]}) for one in ({}, name))
    said = [one.get("class") or one["classes"][-1] for one in (plain, own)]
    assert said[0] != "cork"
    assert said[1] == "cork"


def test_after_teaching_a_picture_is_compared_with_the_visitors_own(resources):
    question = {"pairs": [{"vis": "row:41", "tac": "row:41"}]}
    after = many(resources, {**question, "lessons": LESSONS})["pairs"][0]["images"]
    assert {name: one["cosine"] for name, one in after.items()} == {"vis": 1, "tac": 1}
    assert many(resources, question)["pairs"][0]["images"] != after
    photos = [{**one, "tac": None} for one in LESSONS]
    assert set(many(resources, {**question, "lessons": photos})["pairs"][0]["images"]) == {"vis"}
