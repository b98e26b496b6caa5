"""The page's routes over HTTP: their replies, and one sentence for every error."""

import base64
import json
import logging
from dataclasses import replace
from shutil import copytree

import numpy as np
import pytest

from app.pair.tab import PARTS
from app.serving.routes import QUESTIONS, SENT
from app.shared.limits import MAX_IMAGE_BYTES, MAX_QUESTION_BYTES, PICTURES
from app.shared.messages import UNEXPECTED
from app.shared.resources import Resources
from omnivat.maps.frames import read_frames

from .conftest import posted, sentence, served

JUNK = [
    b"\xff\xfe\x00",
    b"null",
    b'{"vis": 1, "point": [], "order": "x", "stage": {}}',
    b'{"vis": "row:\\u0661", "point": 1e9, "order": 1e999, "stage": "raw"}',
    b'{"vis": {"path": "/etc/passwd"}, "point": true, "stage": "raw"}',
]


def in_lines(reply):
    """Return a reply of several lines of JSON as one object."""
    return {k: v for line in reply.text.splitlines() for k, v in json.loads(line).items()}


@pytest.mark.parametrize("name", [*QUESTIONS, *SENT, "load", "part"])
@pytest.mark.parametrize("junk", JUNK)
def test_junk_is_refused_in_a_sentence(client, name, junk):
    got = client.post(f"/omnivat/{name}", content=junk)
    if got.status_code == 200:  # where an empty object is a whole question
        assert junk.startswith(b"{")
    else:
        sentence(got, 400)


def test_an_endless_question_is_cut_off(client):
    endless = client.post("/omnivat/pair", content=b"x" * (MAX_QUESTION_BYTES + 1))
    assert "larger than 4 MB" in sentence(endless, 413)


def test_an_uploaded_pair_is_one_request_and_its_reply_replaces_the_pictures(client, png):
    wanted = ["familiar", "rivals", "journey", "moving"]
    question = {"vis": "file:1", "tac": "file:0", "names": ["t.png", "p.png"], "with": wanted}
    first = in_lines(posted(client, "pair", question, png(40, seed=1), png(48, seed=2)))
    touch, photo = first.pop("pictures")
    assert (photo["width"], touch["width"]) == (48, 40)
    assert set(first["familiar"]["images"]) == {"vis", "tac"} and first["rivals"] == {}
    assert "moving" not in first  # p has a part in this head
    again = {"vis": photo["ref"], "tac": touch["ref"], "with": wanted}
    second = in_lines(client.post("/omnivat/pair", json=again))  # nothing was kept for it
    for one in (first, second):  # it is there, or its map is still being computed
        assert one.pop("journey").keys() & {"maps", "problem"}
    assert second == first


def test_a_prediction_is_sent_before_the_rest_of_its_reply_whose_problem_is_a_line(
    client, monkeypatch
):
    question = {"vis": "row:1", "with": ["familiar", "journey"]}
    prediction, rest = client.post("/omnivat/pair", json=question).text.splitlines()
    assert json.loads(prediction)["exact"] and set(json.loads(rest)) == {"familiar", "journey"}
    monkeypatch.setitem(PARTS, "familiar", lambda *_: 1 / 0)
    prediction, rest = client.post("/omnivat/pair", json=question).text.splitlines()
    assert json.loads(prediction)["exact"] and json.loads(rest) == {"problem": UNEXPECTED}
    monkeypatch.setitem(PARTS, "familiar", lambda *_: {"cosine": float("nan")})
    _, rest = client.post("/omnivat/pair", json=question).text.splitlines()
    assert "not finite" in json.loads(rest)["problem"]


def test_a_picture_that_cannot_be_read_is_named_and_the_others_are_read(client, png):
    pairs = {"pairs": [{"vis": "file:0"}, {"tac": "file:1"}], "names": ["a.png", "b.png"]}
    found = posted(client, "many", pairs, b"GIF?", png(40)).json()
    assert "'a.png'" in found["pairs"][0]["problem"] and found["pairs"][1]["readings"]
    assert "'a.png'" in found["pictures"][0]["problem"] and found["pictures"][1]["ref"]
    alone = posted(client, "pair", {"vis": "file:0", "names": ["a.png"]}, b"GIF?").json()
    assert set(alone) == {"problem", "pictures"} and "'a.png'" in alone["problem"]
    half = {"touches": ["file:0", "file:1"], "names": ["a.png", "b.png"]}
    assert posted(client, "profile", half, b"GIF?", png(40)).json()["counts"] == {"tac": 1}
    none = posted(client, "profile", half, b"GIF?", b"GIF?").json()
    assert "'a.png'" in none["problem"] and "profile" not in none


@pytest.mark.parametrize("sizes", ["7,8", "2,-1", "2,1" + ",1" * PICTURES, "²"])
def test_sizes_that_are_not_those_of_the_body_are_refused(client, sizes):
    assert "sizes is" in sentence(client.post(f"/omnivat/pair?sizes={sizes}", content=b"{}1"))


def test_one_picture_over_the_limit_and_all_over_theirs_are_refused(client):
    for files in ([bytes(MAX_IMAGE_BYTES + 1)], [bytes(MAX_IMAGE_BYTES)] * 3):
        assert "is larger than" in sentence(posted(client, "many", {"pairs": []}, *files), 413)


def test_a_question_cannot_name_files_that_did_not_come_with_it(client):
    for question in ({"vis": "file:0"}, {"vis": "file:0", "files": ["x"]}, {"vis": "unread:x"}):
        assert "names no image" in sentence(client.post("/omnivat/pair", json=question))
    for name in ("file:1", "file:00001", "file:-1"):
        assert posted(client, "pair", {"vis": name}, b"GIF?").status_code == 400


def test_a_bad_image_is_refused_by_its_name_and_one_over_the_limit_by_its_size(client):
    assert "'touch.png'" in sentence(client.post("/omnivat/image?name=touch.png", content=b"GIF?"))
    assert "larger than 20 MB" in sentence(
        client.post("/omnivat/image", content=bytes(MAX_IMAGE_BYTES + 1)), 413
    )


def test_an_error_nobody_thought_of_is_a_sentence_and_its_traceback_is_logged(
    client, monkeypatch, caplog
):
    monkeypatch.setattr("app.shared.pair_input.order_from", lambda question: 1 / 0)
    with caplog.at_level(logging.ERROR):
        assert sentence(client.post("/omnivat/pair", json={}), 500) == UNEXPECTED
    assert "ZeroDivisionError" in caplog.text


def test_the_page_serves_its_scripts_and_nothing_else(client):
    assert (
        client.get("/omnivat/web/explore/explore.js")
        .headers["content-type"]
        .startswith("text/javascript")
    )
    assert client.get("/omnivat/web/shared/page.css").status_code == 200
    for name in ("..%2Fserver.py", "%2e%2e/server.py", "explore/explore.html", "%2fetc%2fpasswd"):
        assert client.get(f"/omnivat/web/{name}").status_code == 404


def test_an_example_is_served_by_name_and_no_other_file_is(client):
    assert client.get("/omnivat/example/TAG-sim/wood/0/vis").headers["content-type"] == "image/png"
    for path in ("TAG-sim/wood/0/secret", "../../etc/passwd/vis", "TAG-sim/wood/1/vis"):
        assert client.get(f"/omnivat/example/{path}").status_code in (400, 404)


def test_a_set_without_thumbnails_says_so(client):
    assert "goes on without it" in sentence(client.get("/omnivat/thumbnails.json"), 404)


def test_about_says_what_is_loaded_and_tells_no_path_of_the_server(client, small_places):
    about = client.get("/omnivat/about").json()
    assert about["embeddings"] == {
        "pairs": 80,
        "domains": ["TAG-sim", "OF Real-sim"],
        "simulated": True,
    }
    assert about["head"]["source"] == "TAG-sim"
    assert str(small_places.head.parent) not in json.dumps(about)


def test_a_missing_head_is_a_sentence_everywhere_and_the_page_goes_on(resources, tmp_path):
    missing = Resources(replace(resources.where, head=tmp_path / "none"))
    with served(missing) as client:
        assert "omnivat train" in sentence(client.post("/omnivat/pair", json={"vis": "row:0"}))
        assert "No head" in client.get("/omnivat/about").json()["head"]["problem"]
        missing.frames.wait()
        assert "missing" in sentence(client.get("/omnivat/frames"), 404)
        assert client.get("/omnivat/examples").status_code == 200


def test_the_frames_that_come_with_the_project_are_of_its_head_and_its_set():
    from omnivat.data.store import load_embeddings
    from omnivat.head.checkpoint import head_hash, load_head
    from omnivat.head.heads import EXAMPLES, default_embeddings, default_head

    if not (EXAMPLES / "frames.bin").is_file():
        pytest.skip("examples/frames.bin is not made yet")
    frames, embeddings = read_frames(EXAMPLES / "frames.bin"), load_embeddings(default_embeddings())
    assert frames.head["hash"] == head_hash(default_head())
    assert frames.head["learned_order"] == pytest.approx(load_head(default_head()).model.order)
    assert frames.pairs == len(embeddings)
    assert frames.domains == embeddings.header.domains
    assert frames.embeddings["weights_hash"] == embeddings.header.weights_hash


def test_the_frames_of_a_head_that_is_not_loaded_are_refused_by_name(client):
    answer = client.get("/omnivat/frames?head=ghost")
    assert answer.status_code == 400
    assert answer.json()["error"].startswith("No head is called 'ghost'")


def test_every_answer_says_which_head_and_set_it_is_of(client, resources):
    asked = [client.get("/omnivat/about"), client.get("/omnivat/examples")]
    asked.append(client.post("/omnivat/pair", json={"vis": "row:1"}))
    assert {answer.headers["x-holds"] for answer in asked} == {resources.holds}


def test_another_head_is_held_under_another_name(resources, tmp_path):
    copy = copytree(resources.where.head, tmp_path / "copy")
    assert Resources(resources.where).holds == resources.holds
    assert Resources(replace(resources.where, head=copy)).holds != resources.holds


def test_a_page_gets_frames_in_parts_that_make_the_file_again(framed):
    frames = read_frames(framed.frames)
    with served(Resources(framed)) as client:
        answer = client.get("/omnivat/frames?part=head")
        head = answer.json()
        assert answer.headers["content-encoding"] == "gzip"
        assert head["tag"] in answer.headers["etag"] and head["pairs"] == frames.pairs
        curve = frames.curves["modality_gap/f_hat"]
        assert head["curves"]["modality_gap/f_hat"] == pytest.approx(curve, rel=1e-5)
        assert base64.b64decode(head["inline"]["label"]) == frames.label.tobytes()
        answer = client.get("/omnivat/frames", params={"part": "prediction", "of": head["tag"]})
        assert answer.content == frames.prediction.tobytes()
        points = frames.maps["umap/f_hat"].points
        low, high = (head["extents"]["map:umap/f_hat"][1][at] for at in (0, 2))
        half = points[:, frames.pairs :, 0]
        assert (low, high) == (half.min(), half.max())
        answer = client.get("/omnivat/frames?part=map:umap/f_hat&from=1")
        stops = np.frombuffer(answer.content, "<u2").reshape(points.shape)
        assert (stops == points[[1, 0, 2, 3]]).all()
        again = {"If-None-Match": answer.headers["etag"]}
        assert client.get("/omnivat/frames?part=map:umap/f_hat", headers=again).status_code == 304


@pytest.mark.parametrize(
    ("query", "status", "words"),
    [
        ("part=map:tsne/f_hat", 400, "no part 'map:tsne/f_hat'"),
        ("part=map:umap/f_hat&from=4", 400, "no stop 4"),
        ("part=prediction&of=older", 410, "computed again"),
    ],
)
def test_a_part_that_is_not_there_or_of_an_older_file_is_refused(framed, query, status, words):
    with served(Resources(framed)) as client:
        assert words in sentence(client.get(f"/omnivat/frames?{query}"), status)
