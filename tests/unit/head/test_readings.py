"""Readings: one modality alone is not a branch of the pair, and each fusion has the effect of
its name.
"""

import pytest
import torch

from omnivat.head.checkpoint import load_head
from omnivat.head.fusion import FUSIONS, fused_logs
from omnivat.head.predict import predict_embeddings


@pytest.mark.parametrize("settings", [{}, {"generation": "none"}, {"mffa": False}])
@pytest.mark.parametrize("name", ["vis", "tac"])
def test_one_modality_alone_is_the_head_called_without_the_other(
    make_head, make_pairs, settings, name
):
    model, pairs = make_head(**settings), make_pairs(7)
    single = model(*(x if n == name else None for n, x in zip(("vis", "tac"), pairs, strict=True)))
    torch.testing.assert_close(model(*pairs).readings[name], single.readings["fused"])
    assert set(single.readings) == {"fused", name}


@torch.no_grad()
@pytest.mark.parametrize("fusion", FUSIONS)
def test_a_fusion_gives_probabilities_and_a_temperature_changes_no_prediction(
    make_head, make_pairs, fusion
):
    model, pairs = make_head(fusion=fusion), make_pairs(9)
    before = model(*pairs).readings
    model.temperatures = {"fused": 3.0, "vis": 0.5, "tac": 2.0}
    after = model(*pairs).readings
    for name in ("fused", "vis", "tac"):
        torch.testing.assert_close(after[name].sum(-1), torch.ones(9, dtype=torch.float64))
        assert torch.equal(before[name].argmax(-1), after[name].argmax(-1))
    assert (after["fused"].amax(-1) < before["fused"].amax(-1)).all()
    assert (after["vis"].amax(-1) > before["vis"].amax(-1)).all()


def test_each_fusion_is_its_formula():
    vis, tac = torch.tensor([[2.0, 0.0, -1.0]]).double(), torch.tensor([[0.0, 0.5, 0.3]]).double()
    p, q = vis.softmax(-1), tac.softmax(-1)
    torch.testing.assert_close(fused_logs("mean", vis, tac).exp(), (p + q) / 2)
    product = (p * q).sqrt()
    torch.testing.assert_close(fused_logs("product", vis, tac).exp(), product / product.sum())
    sure = [torch.log(torch.tensor(3.0).double()) + (x * x.log()).sum() for x in (p, q)]
    confident = (sure[0] * p + sure[1] * q) / (sure[0] + sure[1])
    torch.testing.assert_close(fused_logs("confidence", vis, tac).exp(), confident)


def test_confidence_fusion_of_two_uniform_branches_is_uniform():
    even = torch.zeros(1, 4).double()
    torch.testing.assert_close(fused_logs("confidence", even, even).exp(), even + 0.25)


def test_predicted_records_name_every_reading_and_familiarity(head_folder, make_embeddings):
    head, pairs = load_head(head_folder), make_embeddings(domains=("TAG-sim",))
    vis, tac = torch.from_numpy(pairs.vis[:2]), torch.from_numpy(pairs.tac[:2])
    (first, _), (photo, _) = predict_embeddings(head, vis, tac), predict_embeddings(head, vis, None)
    assert set(first["modalities"]) == set(first["branches"]) == {"vis", "tac"}
    assert first["modalities"]["vis"] == pytest.approx(photo["probabilities"])
    assert first["branches"]["vis"] != pytest.approx(photo["probabilities"])
    assert photo["prediction"] == max(photo["probabilities"], key=photo["probabilities"].get)
    assert "branches" not in photo
    assert set(photo["familiarity"]) == {"vis"}
    assert first["familiarity"]["tac"]["words"] == "familiar"
    assert first["temperature"]["fused"] != 1


def test_one_image_counts_twice_in_a_taught_head(make_head, make_pairs):
    """Scores of both images are the mean of those of one alone."""
    model, (vis, tac) = make_head(taught=(5,)), make_pairs(4)
    random = torch.Generator().manual_seed(3)
    model.taught_rows.copy_(torch.randn(model.taught_rows.shape, generator=random))
    model.taught_bias.copy_(torch.randn(model.taught_bias.shape, generator=random))
    scores = model.lessons({"vis": vis, "tac": tac}).scores
    torch.testing.assert_close(scores["vis"] + scores["tac"], 2 * scores["fused"])
    wanted = 2 * model.standing("vis", vis) @ model.taught_rows[0, 0].T + model.taught_bias[0]
    torch.testing.assert_close(scores["vis"][:, 0], wanted)
    alone = model.lessons({"vis": vis}).scores
    torch.testing.assert_close(alone["fused"], scores["vis"])
