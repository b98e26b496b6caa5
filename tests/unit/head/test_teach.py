"""Teaching a head from a few labelled pairs."""

import json
from dataclasses import replace

import numpy as np
import pytest
import torch

from omnivat.cli import main
from omnivat.data.store import load_embeddings, save_embeddings
from omnivat.head.calibration import familiarity_of
from omnivat.head.checkpoint import load_head, save_head
from omnivat.head.teach import DIRECTIONS, LOGISTIC, MEAN, METHODS, NEIGHBOUR, Lesson, _Work, judged, taught
from omnivat.kit.errors import DataError, SettingsError


@pytest.fixture(scope="module")
def head(head_folder):
    """Return a head that has learned its source: the shared one is trained for two epochs only."""
    from omnivat.head.settings import HeadSettings
    from omnivat.training import TrainSettings, train

    pairs = load_embeddings(head_folder.parent / "set.safetensors").in_domain("TAG-sim")
    short = load_head(head_folder)
    settings = HeadSettings(classes=short.settings.classes, input_width=pairs.width, width=16, lang_width=1)
    model = train(pairs, settings, TrainSettings(epochs=15, lang=False)).model
    known = familiarity_of(
        torch.from_numpy(pairs.vis), torch.from_numpy(pairs.tac), pairs.rows["object"], torch.from_numpy(pairs.label)
    )
    return replace(short, model=model.requires_grad_(False), settings=settings, familiarity=known)


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


def said(head, one, reading="fused"):
    return head.settings.classes[int(head.model(one.vis, one.tac).readings[reading][0].argmax())]


@pytest.mark.parametrize("method", METHODS)
def test_a_taught_head_predicts_its_lessons(head, lessons, method):
    after = taught(head, lessons, method)
    assert [said(after, one) for one in lessons] == [one.label for one in lessons]
    assert after.provenance["taught_by"] == method


@pytest.mark.parametrize("method", METHODS)
def test_teaching_leaves_the_head_and_its_features_as_they_were(head, lessons, method):
    one = lessons[0]
    before = head.model(one.vis, one.tac)
    after = taught(head, lessons, method)
    torch.testing.assert_close(head.model(one.vis, one.tac).logits, before.logits)
    torch.testing.assert_close(after.model(one.vis, one.tac).f_hat, before.f_hat)
    assert head.settings.classes == after.settings.classes


@pytest.mark.parametrize("method", METHODS)
def test_a_class_that_the_head_lacks_can_be_taught_and_saved(head, lessons, method, tmp_path):
    cork = [replace(one, label="cork") if one.label == "glass" else one for one in lessons]
    after = taught(head, cork, method)
    assert after.settings.classes == (*head.settings.classes, "cork")
    again = load_head(save_head(tmp_path / "taught", after))
    many = torch.cat([one.vis for one in cork]), torch.cat([one.tac for one in cork])
    for name, shares in after.model(*many).readings.items():
        torch.testing.assert_close(again.model(*many).readings[name], shares)
        torch.testing.assert_close(shares.sum(1), torch.ones(len(cork)))
    assert again.provenance["taught"] == {"wood": 2, "cork": 2}
    assert said(again, cork[-1]) == "cork"
    assert said(taught(again, lessons), lessons[-1]) == "glass"  # it can be taught once more


def test_the_nearest_neighbour_is_the_pair_of_largest_cosine(head, lessons):
    """An oracle in plain NumPy: cosines of both images, standardised, with equal weight."""
    after = taught(head, lessons, NEIGHBOUR)
    pairs = [torch.randn(60, head.settings.input_width) * 4 for _ in range(2)]
    source = [head.familiarity.rows[n] * head.familiarity.lengths[n][:, None] for n in ("vis", "tac")]

    def rows(vis, tac):
        parts = [head.model.standardised(n, x) for n, x in (("vis", vis), ("tac", tac))]
        return np.hstack([(x / x.norm(dim=1, keepdim=True)).numpy() for x in parts])

    known = rows(*source)
    known = np.vstack([np.vstack([rows(one.vis, one.tac) for one in lessons]), known])
    owner = [head.settings.classes.index(one.label) for one in lessons]
    owner = np.array([*owner, *head.familiarity.labels.tolist()])
    kept = np.ones(len(owner), bool)
    kept[4:] = ~np.isin(owner[4:], owner[:4])  # taught classes are known by their lessons alone
    wanted = owner[kept][(rows(*pairs) @ known[kept].T).argmax(1)]
    found = after.model(*pairs).probabilities.argmax(1).numpy()
    assert (found == wanted).all()
    assert len(set(found)) > 2


def test_the_order_has_no_influence_but_on_class_directions(head, lessons):
    one = lessons[0]
    for method in METHODS:
        model = taught(head, lessons, method).model
        moved = model(one.vis, one.tac, order=0.9).probabilities
        same = torch.equal(moved, model(one.vis, one.tac, order=0.1).probabilities)
        assert same == (method != DIRECTIONS)


def test_a_photo_alone_teaches_and_is_predicted_too(head, lessons):
    alone = [replace(one, tac=None) for one in lessons]
    assert len(judged(head, alone).judged) == 4
    for method in METHODS:
        assert said(taught(head, alone, method), alone[0]) == "wood"


def test_no_pair_is_judged_by_a_head_that_learned_from_its_object(head, lessons):
    """Two pictures of one odd object: the second is no evidence for the first."""
    strange = -3 * lessons[0].vis
    odd = [Lesson(label="cork", vis=strange + shift, tac=strange, object="odd") for shift in (0, 0.01)]
    report = judged(head, [*lessons, *odd])
    apart = judged(head, [*lessons, odd[0], replace(odd[1], object="another")])
    assert all(one.after != "cork" for one in report.judged)
    assert apart.right[NEIGHBOUR] == report.right[NEIGHBOUR] + 2
    assert [one.before for one in report.judged[:4]] == [said(head, one) for one in lessons]
    assert report.after == sum(one.after == one.label for one in report.judged)


def test_another_method_is_chosen_only_if_it_is_clearly_better(head, lessons):
    work = _Work(head, lessons * 4)  # 16 lessons: by more than two
    assert work._best({LOGISTIC: 8, MEAN: 10, NEIGHBOUR: 9, DIRECTIONS: 1}) == LOGISTIC
    assert work._best({LOGISTIC: 8, MEAN: 11, NEIGHBOUR: 9, DIRECTIONS: 1}) == MEAN


def test_an_older_head_without_training_labels_is_taught_by_the_lessons_alone(head, lessons):
    older = replace(head, familiarity=None)
    report = judged(older, lessons)
    assert set(report.right) == {DIRECTIONS, MEAN, NEIGHBOUR}
    with pytest.raises(SettingsError, match="There is no method 'logistic regression' here"):
        taught(older, lessons, LOGISTIC)


@pytest.mark.parametrize("labels", [["wood"], ["wood", "wood"], ["wood", "wood", "glass"]])
def test_too_few_labels_are_refused_with_what_is_there(head, lessons, labels):
    few = [replace(lessons[0], label=label) for label in labels]
    with pytest.raises(DataError, match="two or more classes first, of different objects; there are: wood"):
        judged(head, few)
    assert taught(head, few).provenance["taught_by"] == LOGISTIC


def test_pairs_of_one_object_are_not_enough(head, lessons):
    one = [replace(lesson, object=lesson.label) for lesson in lessons]
    with pytest.raises(DataError, match="different objects"):
        judged(head, one)


def test_nothing_to_learn_from_is_refused(head):
    with pytest.raises(DataError, match="label at least one pair"):
        taught(head, [])


def test_the_command_says_what_teaching_brings_and_writes_a_head(head, head_folder, tmp_path, capsys):
    own = tmp_path / "own"
    save_head(own, head)
    pairs = load_embeddings(head_folder.parent / "set.safetensors").in_domain("OF Real-sim")
    save_embeddings(tmp_path / "few.safetensors", pairs.select(np.arange(0, len(pairs), 2)))
    command = ["teach", "--embeddings", str(tmp_path / "few.safetensors"), "--head", str(own)]
    assert main([*command, "--out", str(tmp_path / "new"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["pairs"] == len(found["held_out"]) == len(pairs) // 2
    assert found["after"] == sum(one["after"] == one["label"] for one in found["held_out"])
    assert found["after"] >= found["before"]
    assert found["method"] in METHODS and set(found["right"]) == set(METHODS)
    after = load_head(tmp_path / "new")
    assert after.provenance["taught_by"] == found["method"]
    assert main([*command, "--out", str(tmp_path / "new")]) == 0
    assert f"right before {found['before']}, after {found['after']} of" in capsys.readouterr().out
