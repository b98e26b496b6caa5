"""A head of all domains: what it reads, what it keeps, and that its maps decide."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from omnivat.head.checkpoint import load_head, save_head
from omnivat.head.linear_maps import fit_maps
from omnivat.head.predict import predict_embeddings
from omnivat.head.teach import Lesson, taught
from omnivat.kit.errors import DataError
from omnivat.study import pooled
from omnivat.study.pooled import ALL, _pooled, pooled_head, with_maps
from omnivat.training import TrainSettings
from tests.builders import move_domains

DOMAINS = ("TAG-sim", "OF Real-sim", "TQ-DIGIT-sim")


@pytest.fixture(scope="module")
def shifted(make_embeddings):
    """Three domains, each with an offset of its own."""
    return move_domains(make_embeddings(domains=DOMAINS, per_class=12, split=True), 6)


@pytest.fixture(scope="module")
def head(shifted):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pooled, "BODY", {"width": 16})
        patch.setattr(pooled, "TRAINING", TrainSettings(epochs=2, lang=False))
        patch.setattr(pooled, "DRAWS", 2)
        return pooled_head(shifted, seed=0)


def pairs(embeddings, rows):
    return [torch.from_numpy(np.array(x[rows])) for x in (embeddings.vis, embeddings.tac)]


def test_pictures_without_labels_bring_back_a_domain_left_out(head):
    found = head.metrics["left_out"]
    assert set(found) == {"0", "5", "20"}
    assert found["20"]["fused"] > found["0"]["fused"] + 0.2
    assert found["20"]["fused"] > 0.8
    # calibrated with 20 pictures: without any, the maps would be wrong and hot
    assert max(head.provenance["maps"]["temperature"].values()) < 1


def test_the_maps_decide_each_reading_and_their_mean_a_pair(head, shifted):
    rows = np.arange(6)
    vis, tac = pairs(shifted, rows)
    raw = {"vis": vis, "tac": tac}
    labels = torch.from_numpy(shifted.label)
    fitted = fit_maps(
        {n: torch.from_numpy(np.array(getattr(shifted, n))) for n in raw},
        labels,
        len(shifted.header.classes),
        profile=head.source_profile.channels,
    )
    plain = dict.fromkeys(("vis", "tac", "both"), 1.0)
    readings = with_maps(head.model, fitted, plain)(vis, tac).readings
    wanted = fitted(raw)
    for name in ("fused", "vis", "tac"):
        torch.testing.assert_close(readings[name], wanted[name], atol=1e-4, rtol=1e-3)
    alone = with_maps(head.model, fitted, plain)(vis, None).readings
    torch.testing.assert_close(alone["fused"], wanted["vis"], atol=1e-4, rtol=1e-3)
    cooler = with_maps(head.model, fitted, {"vis": 2.0, "tac": 1.0, "both": 1.0})(vis, tac).readings
    assert float(cooler["vis"].max()) < float(readings["vis"].max())
    torch.testing.assert_close(cooler["tac"], readings["tac"])


def test_it_is_an_ordinary_head_on_disk_and_can_be_taught(head, shifted, tmp_path):
    loaded = load_head(save_head(tmp_path / "own", head))
    given = pairs(shifted, np.arange(4))
    torch.testing.assert_close(loaded.model(*given).probabilities, head.model(*given).probabilities)
    assert (loaded.source, loaded.metrics["left_out"]) == (ALL, head.metrics["left_out"])
    lessons = [
        Lesson(label=f"new {k % 2}", vis=given[0][k : k + 1], tac=given[1][k : k + 1])
        for k in range(4)
    ]
    after = taught(loaded, lessons)
    assert after.settings.classes[-1] == "new 1"
    assert predict_embeddings(after, *given)[1]["prediction"] == "new 1"


def test_two_domains_are_too_few(make_embeddings):
    with pytest.raises(DataError, match="has 2 domain.* needs three or more"):
        pooled_head(make_embeddings(), seed=0)


def test_pairs_of_all_domains_are_one_object_only_if_domain_and_name_agree(shifted):
    some = shifted.select(np.arange(3))
    two_domains = replace(some, domain=np.array([0, 0, 1]))
    for names, objects in ((["a", "a", "a"], 2), (["", "", ""], 3)):
        pooled = _pooled(replace(two_domains, rows={**some.rows, "object": names}))
        assert len(set(pooled.rows["object"])) == objects
