"""My sensor: a profile of a visitor's unlabelled pictures, and what follows from it."""

from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
import torch
from PIL import Image

from app.pair.sensor import profile, save_sensor
from app.pair.sensor_card import MOST_TOUCHES
from app.pair.tab import many
from app.serving.about import about
from app.serving.server import main
from app.shared.pair_input import pair_of
from omnivat.data.images import read_image
from omnivat.data.profile_file import load_profile
from omnivat.head.heads import EXAMPLES
from omnivat.kit.stages import IMAGES

from .conftest import own_image, posted, sentence, served


@pytest.fixture
def visiting(resources):
    return resources


@pytest.fixture
def refs(resources):
    """Return a function for so many pictures of a sensor whose channels are shifted."""
    rows = resources.embeddings().vis
    return lambda count: [own_image(resources, rows[k] + 3) for k in range(count)]


def test_a_profile_moves_a_visitors_pictures_and_never_pairs_of_the_set(visiting, refs):
    name = profile(visiting, {"photos": refs(20)})["profile"]
    asked = {"pairs": [{"vis": refs(1)[0]}]}
    before, after = (many(visiting, {**asked, "profile": one})["pairs"][0] for one in ("", name))
    assert before["readings"] != after["readings"]
    assert before["images"] == after["images"] != {}  # what is familiar stays
    own = dict.fromkeys(IMAGES, refs(1)[0])
    _, plain, with_it = pair_of(visiting, {**own, "profile": name})
    wanted = visiting.head().moved("vis", plain["vis"], visiting.profiles.get(name))
    torch.testing.assert_close(with_it["vis"], wanted)
    assert (plain["vis"] - with_it["vis"]).mean() > 1  # most of the shift is undone
    torch.testing.assert_close(with_it["tac"], plain["tac"])  # no touch is in the profile
    _, plain, with_it = pair_of(visiting, {"vis": "row:3", "profile": name})
    torch.testing.assert_close(with_it["vis"], plain["vis"])


def test_a_saved_profile_is_loaded_again_as_its_touches_were_mended_and_a_broken_one_refused(
    visiting, refs
):
    made = profile(visiting, {"photos": refs(5), "touches": refs(3), "mend": "left-right"})
    assert made["mend"] == "left-right"
    content = save_sensor(visiting, made)
    with served(visiting) as client:
        assert client.post("/omnivat/sensor", content=content).json() == made
        broken = client.post("/omnivat/sensor", content=content[:90])
    assert "profile" in sentence(broken)


def test_a_profile_of_the_command_line_is_in_use_from_the_start(visiting, tmp_path, refs):
    file = tmp_path / "p.safetensors"
    made = profile(visiting, {"touches": refs(5)})
    file.write_bytes(save_sensor(visiting, made))
    assert about(visiting)["sensor"] == {}
    visiting.where = replace(visiting.where, profile=file)
    assert about(visiting)["sensor"]["counts"] == {"tac": 5}


def test_a_profile_that_is_not_there_stops_the_start_in_one_sentence(capsys, tmp_path):
    assert main(["--profile", str(tmp_path / "no.safetensors"), "--no-browser"]) == 1
    assert "cannot be read" in capsys.readouterr().err


def sent(pictures):
    """Return pictures as files."""
    bodies = []
    for picture in pictures:
        with BytesIO() as file:
            Image.fromarray(np.ascontiguousarray(picture)).save(file, "PNG")
            bodies.append(file.getvalue())
    return bodies


@pytest.fixture(scope="module")
def gel():
    """Return the example touches of one gel, (H, W, 3)."""
    files = sorted((EXAMPLES / "pairs" / "TAG-sim").glob("*/*_tac.jpg"))
    return [np.asarray(read_image(file)) for file in files]


def test_flat_grey_single_and_too_many_touches_are_told_in_one_sentence(resources, gel):
    grey = np.repeat(gel[0][..., :1], 3, -1)
    with served(resources) as client:

        def card(pictures):
            return posted(client, "card", {}, *sent(pictures))

        assert "needs 5 touch images" in sentence(card(gel[:1]))
        assert "at most 51 parts" in sentence(card([gel[0][:8, :8]] * (MOST_TOUCHES + 1)))
        for flat in (grey, np.full_like(grey, 90)):
            reply = card([flat] * 5).json()
            assert reply["changes"] is None and reply["cards"][0]["lamps"] is None
            assert reply["cards"][0]["no_lamps"].endswith(".")


def test_a_touch_is_read_as_the_request_mends_it_and_a_photo_as_it_comes(resources, gel):
    mirrored, plain = (sent([one])[0] for one in (gel[0][:, ::-1], gel[0]))
    with served(resources) as client:

        def rows(content, mend=""):
            ref = client.post(f"/omnivat/image?name=x&mend={mend}", content=content).json()["ref"]
            made = [client.post("/omnivat/many", json={"pairs": [{kind: ref}], "mend": mend}).json()
                    for kind in IMAGES]  # fmt: skip
            return [one["pairs"][0]["readings"] for one in made], ref

        (photo, touch), _ = rows(mirrored, "left-right")
        (as_photo, as_touch), _ = rows(plain)
        assert touch == as_touch and photo != as_photo
        assert rows(mirrored)[0][0] == photo
        live = [
            posted(client, "live", {"modality": "tac", "mend": mend}, content).json()["readings"]
            for content, mend in ((mirrored, "left-right"), (plain, ""), (mirrored, ""))
        ]
        assert live[0] == live[1] != live[2]
        wrong = client.post("/omnivat/profile", json={"touches": [rows(plain)[1]], "mend": "<b>"})
    assert "left-right" in sentence(wrong)


def test_a_new_profile_of_touches_alone_holds_their_lamps_and_keeps_them(resources, gel, tmp_path):
    files = sent(gel)
    names = [f"file:{k}" for k in range(len(gel))]
    with served(resources) as client:
        first = posted(client, "profile", {"touches": names[:8]}, *files[:8]).json()["profile"]
        more = {"touches": names[:1], "profile": first}
        both = posted(client, "profile", more, files[8]).json()["profile"]
        bare = posted(client, "profile", {"photos": names[:8]}, *files[:8]).json()["profile"]
        spoilt = {"touches": names[:9]}, *files[:8], b"no picture"
        rest = posted(client, "profile", *spoilt).json()["profile"]
        grey = sent([np.full((64, 64, 3), 90, np.uint8)] * 5)
        none = posted(client, "profile", {"touches": names[:5]}, *grey).json()["profile"]
        held = []
        for name in (first, both, rest, bare, none):
            file = tmp_path / name
            file.write_bytes(client.post("/omnivat/save/sensor", json={"profile": name}).content)
            held.append(load_profile(file))
    assert [one.lamps and one.lamps.pictures for one in held] == [8, 8, 8, None, None]
    assert held[1].counts == {"tac": 9}
