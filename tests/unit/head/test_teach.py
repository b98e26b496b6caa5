"""Teaching a head from a few labelled pairs."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
import torch

from omnivat.cli import main
from omnivat.data.store import load_embeddings, save_embeddings
from omnivat.head.checkpoint import load_head, save_head
from omnivat.head.curve import curve, curve_in_words
from omnivat.head.ridge import SHARPNESS, ridge, sharpness
from omnivat.head.teach import Lesson, Work, judged, splits, taught
from omnivat.kit.errors import DataError
from tests.builders import head_settings


@pytest.fixture(scope="module")
def head(head_folder):
    """Return a head that has learned its source: the shared one is trained for two epochs only."""
    from omnivat.training import TrainSettings, train

    pairs = load_embeddings(head_folder.parent / "set.safetensors").in_domain("TAG-sim")
    short = load_head(head_folder)
    settings = head_settings(pairs, width=16, lang_width=1)
    model = train(pairs, settings, TrainSettings(epochs=15, lang=False)).model
    return replace(short, model=model.requires_grad_(False))


def lessons_of(head_folder, domain, rows):
    """Return pairs of a domain of the set that the head was made of, as lessons."""
    pairs = load_embeddings(head_folder.parent / "set.safetensors").in_domain(domain)
    return [
        Lesson(
            label=pairs.header.classes[pairs.label[row]],
            vis=torch.from_numpy(pairs.vis[row : row + 1].copy()),
            tac=torch.from_numpy(pairs.tac[row : row + 1].copy()),
        )
        for row in rows
    ]


@pytest.fixture
def lessons(head_folder):
    """Two pairs of each of two classes, of a domain that the head has not seen."""
    return lessons_of(head_folder, "OF Real-sim", (0, 1, 32, 33))


def said(head, pair, reading="fused"):
    return head.settings.classes[int(head.model(pair.vis, pair.tac).readings[reading][0].argmax())]


def test_a_taught_head_predicts_its_lessons(head, lessons):
    after = taught(head, lessons)
    assert [said(after, one) for one in lessons] == [one.label for one in lessons]
    assert after.provenance["taught"] == {"wood": 2, "glass": 2}


def test_teaching_leaves_the_head_and_its_features_as_they_were(head, lessons):
    one = lessons[0]
    before = head.model(one.vis, one.tac)
    after = taught(head, lessons)
    torch.testing.assert_close(head.model(one.vis, one.tac).logits, before.logits)
    torch.testing.assert_close(after.model(one.vis, one.tac).f_hat, before.f_hat)
    assert head.settings.classes == after.settings.classes


def test_a_class_that_the_head_lacks_can_be_taught_and_saved(head, lessons, tmp_path):
    cork = [replace(one, label="cork") if one.label == "glass" else one for one in lessons]
    after = taught(head, cork)
    assert after.settings.classes == (*head.settings.classes, "cork")
    again = load_head(save_head(tmp_path / "taught", after))
    many = torch.cat([one.vis for one in cork]), torch.cat([one.tac for one in cork])
    for name, shares in after.model(*many).readings.items():
        torch.testing.assert_close(again.model(*many).readings[name], shares)
        torch.testing.assert_close(shares.sum(1), torch.ones(len(cork)))
    assert said(again, cork[-1]) == "cork"


@pytest.fixture
def solved():
    """Regressions of 30 rows and a head that is right now and then, and their objects."""
    random = np.random.default_rng(0)
    rows, labels = random.normal(size=(30, 8)), random.integers(0, 3, 30)
    targets, before = np.eye(3)[labels], random.dirichlet(np.ones(3), 30)
    before += 0.3 * targets
    groups = [np.array([0, 5]), np.array([1]), np.array([2, 3, 4]), np.arange(6, 10)]
    return rows, targets, before, [*groups, *(np.array([k]) for k in range(10, 30))]


def test_scores_without_an_object_are_those_solved_without_its_rows(solved):
    """The closed form of leaving out, beside solving anew without each object."""
    rows, targets, before, groups = solved
    whole = ridge(rows, targets, before, groups)
    for group in groups:
        rest = np.setdiff1d(np.arange(30), group)
        weights = ridge(rows[rest], targets[rest], before[rest], []).weights(0.4)
        wanted = 0.4 * before[group] + (rows[group] @ rows[rest].T + 1) @ weights
        np.testing.assert_allclose(whole.apart(0.4)[group], wanted, atol=1e-9)


def test_the_weight_of_the_head_has_the_least_squared_error(solved):
    """Of the lessons, each without its object, and of one more that the head has right."""
    rows, targets, before, groups = solved
    whole = ridge(rows, targets, before, groups)
    one = (whole.errors[1] ** 2).sum() / len(groups)
    weights = np.linspace(0, 1, 1001)
    errors = [((targets - whole.apart(t)) ** 2).sum() + one * (1 - t) ** 2 for t in weights]
    assert abs(whole.share(groups) - weights[np.argmin(errors)]) < 1e-3


def test_the_probabilities_have_the_sharpness_of_least_loss():
    random = np.random.default_rng(2)
    scores, labels = random.normal(size=(40, 3)), random.integers(0, 3, 40)
    scores[np.arange(40), labels] += 0.5

    def loss(factor):
        logs = factor * scores - np.log(np.exp(factor * scores).sum(1, keepdims=True))
        return -logs[np.arange(40), labels].sum() - logs.mean(1).mean()

    found = sharpness(scores, labels)
    assert loss(found) <= min(loss(0.99 * found), loss(1.01 * found))
    assert sharpness(np.eye(3), np.arange(3)) < SHARPNESS[1]  # all right, yet not without doubt


def test_a_photo_alone_teaches_and_is_predicted_too(head, lessons):
    alone = [replace(one, tac=None) for one in lessons]
    assert len(judged(head, alone).judged) == 4
    assert said(taught(head, alone), alone[0]) == "wood"


def test_no_pair_is_judged_by_a_head_that_learned_from_its_object(head, lessons):
    """Two pictures of one odd object: the second is no evidence for the first."""
    strange = -3 * lessons[0].vis
    odd = [
        Lesson(label="cork", vis=strange + shift, tac=strange, object="odd") for shift in (0, 0.01)
    ]
    report = judged(head, [*lessons, *odd])
    apart = judged(head, [*lessons, odd[0], replace(odd[1], object="another")])
    assert all(one.after != "cork" for one in report.judged)
    assert apart.after == report.after + 2
    assert [one.before for one in report.judged[:4]] == [said(head, one) for one in lessons]
    assert report.after == sum(one.after == one.label for one in report.judged)


def many_lessons(head_folder, count):
    """Pairs of all classes, of a domain that the head has not seen."""
    return lessons_of(head_folder, "OF Real-sim", np.arange(0, 40, 40 // count)[:count])


@pytest.mark.parametrize(("count", "folds"), [(2, 2), (12, 10)])
def test_every_lesson_is_tested_once_by_objects_of_others(count, folds):
    random = np.random.default_rng(count)
    labels = np.repeat([0, 1, 2], (13, 4, 1))
    objects = [np.array([0, 1]), *(np.array([k]) for k in range(2, 18))]
    tested, made = [], [*splits(objects, labels, count, random.permutation(len(objects)))]
    assert len(made) == folds  # as few as leave `count` objects of a class, at most ten
    for test, teach in made:
        tested += test.tolist()
        assert not set(test) & set(np.concatenate(teach))
        classes = [labels[group[0]] for group in teach]
        most = np.bincount(classes, minlength=3)
        assert (most <= count).all() and most[0] == min(count, most[0])
        if count < 3:  # the class of four, too, has as many beside those that are tested
            assert most[0] == most[1] == count
    assert sorted(tested) == list(range(18))


def test_a_draw_of_the_curve_is_the_taught_rule_without_the_tested(head, head_folder):
    """Beside teaching anew."""
    many = many_lessons(head_folder, 12)
    work, order = Work(head, many), np.random.default_rng(5).permutation(12)
    found = work.after(2, order)
    for test, teach in splits(work.objects, work.labels, 2, order):
        after = taught(head, [many[k] for k in np.concatenate(teach)])
        assert [said(after, many[k]) for k in test] == [work.classes[k] for k in found[test]]


def test_the_curve_ends_with_what_teaching_brings(head, head_folder):
    many = many_lessons(head_folder, 24)
    found, report = curve(head, many), judged(head, many)
    assert [one.objects for one in found.points] == [1, 2, 3, 4, 5, 7]  # of eight in a class
    assert found.points[-1].right == report.after / 24
    assert all(0 <= one.least <= one.right <= one.most <= 1 for one in found.points)
    assert curve(head, many) == found
    with pytest.raises(DataError, match="two or more classes"):
        curve(head, many[:1])


@pytest.mark.parametrize(
    ("right", "words"),
    [
        ([0.5], "Label a third object"),
        ([0.5, 0.5], "More labels bring little here; from 1 to 2 objects a class"),
        ([0.2, 0.9], "From 1 to 2 objects a class: .70 points, give or take 3\\.$"),
        ([0.2, 0.6, 0.9], "The last step, from 2 to 3 .*: more labels may bring more"),
        ([0.2, 0.9, 0.9], "The last step, .*: no gain that can be told from chance"),
    ],
)
def test_what_labels_bring_is_told_only_where_it_can_be(right, words):
    each = [np.full(60, share) for share in right]
    assert re.search(words, curve_in_words(range(1, len(right) + 1), each))


@pytest.mark.parametrize(("labels", "objects"), [("wwg", "abc"), ("wwgg", "aabb")])
def test_too_few_objects_are_refused_with_what_is_there(head, lessons, labels, objects):
    names = {"w": "wood", "g": "glass"}
    few = [
        replace(lessons[0], label=names[label], object=name)
        for label, name in zip(labels, objects, strict=True)
    ]
    sentence = "two or more classes first, of different objects; there are: wood"
    with pytest.raises(DataError, match=sentence):
        judged(head, few)
    assert said(taught(head, few[:3]), few[0]) == "wood"  # it can be taught, though not judged


def test_as_many_lessons_as_stated_teach_at_least_one_and_no_more(head, lessons, monkeypatch):
    monkeypatch.setattr("omnivat.head.teach.MOST", len(lessons))
    assert taught(head, lessons).settings.taught
    with pytest.raises(DataError, match="5 lessons and at most 4 are taken; train a head with"):
        taught(head, [*lessons, lessons[0]])
    with pytest.raises(DataError, match="label at least one pair"):
        taught(head, [])


def test_the_command_says_what_teaching_brings_and_writes_a_head(
    head, head_folder, tmp_path, capsys
):
    own = tmp_path / "own"
    save_head(own, head)
    every = load_embeddings(head_folder.parent / "set.safetensors")
    pairs = every.in_domain("OF Real-sim")
    save_embeddings(tmp_path / "few.safetensors", every.select(np.arange(0, len(every), 2)))
    command = ["teach", "--embeddings", str(tmp_path / "few.safetensors"), "--head", str(own)]
    command += ["--domain", "OF Real-sim"]
    assert main([*command, "--out", str(tmp_path / "new"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["pairs"] == len(found["held_out"]) == len(pairs) // 2
    assert found["after"] == sum(one["after"] == one["label"] for one in found["held_out"])
    assert found["after"] >= found["before"]
    assert found["curve"]["points"][-1]["right"] == found["after"] / found["pairs"]
    assert 0 <= found["share"] <= 1
    assert load_head(tmp_path / "new").settings.taught
    assert main([*command, "--out", str(tmp_path / "new")]) == 0
    told = capsys.readouterr().out
    assert f"right before {found['before']}, after {found['after']} of" in told
    assert found["curve"]["words"] in told
