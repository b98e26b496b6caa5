"""Teaching a head from a few labelled pairs."""

from dataclasses import replace

import pytest
import torch

from omnivat.checkpoint import load_head, save_head
from omnivat.data.store import load_embeddings
from omnivat.errors import DataError
from omnivat.teach import Lesson, judged, require_enough, taught


@pytest.fixture(scope="module")
def head(head_folder):
    """Return a head that has learned its source: the shared one is trained for two epochs only."""
    from omnivat.model.settings import HeadSettings
    from omnivat.train import TrainSettings, train

    pairs = load_embeddings(head_folder.parent / "set.safetensors").in_domain("TAG-sim")
    short = load_head(head_folder)
    settings = HeadSettings(
        classes=short.settings.classes, input_width=pairs.width, width=16, lang_width=1
    )
    model = train(pairs, settings, TrainSettings(epochs=15, lang=False)).model
    return replace(short, model=model.requires_grad_(False), settings=settings)


@pytest.fixture
def lessons(head_folder):
    """Two pairs of each of two classes, of a domain that the head has not seen."""
    pairs = load_embeddings(head_folder.parent / "set.safetensors").in_domain("OF Real-sim")
    rows = {"wood": (0, 1), "glass": (32, 33)}
    return [
        Lesson(
            label=label,
            vis=torch.from_numpy(pairs.vis[row : row + 1].copy()),
            tac=torch.from_numpy(pairs.tac[row : row + 1].copy()),
        )
        for label, two in rows.items()
        for row in two
    ]


def test_a_taught_head_predicts_its_lessons(head, lessons):
    after = taught(head, lessons)
    for one in lessons:
        best = int(after.model(one.vis, one.tac).probabilities[0].argmax())
        assert after.settings.classes[best] == one.label


def test_teaching_leaves_the_head_and_its_features_as_they_were(head, lessons):
    one = lessons[0]
    before = head.model(one.vis, one.tac)
    after = taught(head, lessons)
    torch.testing.assert_close(head.model(one.vis, one.tac).logits, before.logits)
    torch.testing.assert_close(after.model(one.vis, one.tac).f_hat, before.f_hat)
    assert head.settings.classes == after.settings.classes


def test_a_class_that_the_head_lacks_can_be_taught_and_saved(head, lessons, tmp_path):
    cork = [
        Lesson(label="cork", vis=one.vis, tac=one.tac) if one.label == "glass" else one
        for one in lessons
    ]
    after = taught(head, cork)
    assert after.settings.classes == (*head.settings.classes, "cork")
    one = cork[-1]
    torch.testing.assert_close(
        after.model(one.vis, one.tac).f_hat, head.model(one.vis, one.tac).f_hat
    )
    again = load_head(save_head(tmp_path / "taught", after))
    torch.testing.assert_close(
        again.model(one.vis, one.tac).probabilities, after.model(one.vis, one.tac).probabilities
    )
    assert again.provenance["taught"] == {"wood": 2, "cork": 2}
    assert int(again.model(one.vis, one.tac).probabilities[0].argmax()) == 5


def test_a_photo_alone_teaches_too(head, lessons):
    alone = [Lesson(label=one.label, vis=one.vis, tac=None) for one in lessons]
    assert len(judged(head, alone)) == 4


def test_no_pair_is_judged_by_a_head_that_learned_from_it(head, lessons):
    """A pair with a wrong label is predicted by its true neighbours, not by its own label."""
    odd = Lesson(label="cork", vis=lessons[0].vis, tac=lessons[0].tac)
    found = judged(head, [*lessons, odd])
    assert found[-1].after != "cork"
    assert [one.before for one in found[:4]] == [
        head.settings.classes[int(head.model(one.vis, one.tac).probabilities[0].argmax())]
        for one in lessons
    ]


@pytest.mark.parametrize("labels", [[], ["wood"], ["wood", "wood"], ["wood", "wood", "glass"]])
def test_too_few_labels_are_refused_with_what_is_there(labels):
    with pytest.raises(DataError, match="two or more classes first; there are:"):
        require_enough(labels)


def test_nothing_to_learn_from_is_refused(head):
    with pytest.raises(DataError, match="label at least one pair"):
        taught(head, [])
