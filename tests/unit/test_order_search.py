"""The search for p: it finds the order of chirps from any start, and uses the source only."""

import numpy as np
import pytest

from omnivat.evaluate import predicted_probabilities
from omnivat.model.settings import HeadSettings
from omnivat.simulate.chirps import ChirpSettings, chirp_embeddings
from omnivat.train import TrainingCancelled, TrainSettings, Watch, order_search, train
from omnivat.train.order_search import lowest_point, search_steps

CHIRPS = ChirpSettings(order=0.62, seed=3, domains=2)


@pytest.fixture(scope="module")
def chirps():
    return chirp_embeddings(CHIRPS)


@pytest.fixture
def few_steps(monkeypatch):
    """Searches of few steps: what they find does not matter."""
    monkeypatch.setattr(order_search, "COARSE_STEPS", 3)
    monkeypatch.setattr(order_search, "FINE_STEPS", 3)


def head(**changes):
    values = {"classes": CHIRPS.class_names, "input_width": 64, "lang_width": 1, "width": 64}
    return HeadSettings(**(values | changes))


def searched(chirps, *, epochs=40, stops=21, watch=None, **changes):
    source = chirps.in_domain(CHIRPS.domain_names[0], split="train")
    settings = TrainSettings(epochs=epochs, lang=False, order_search=True, order_stops=stops)
    return train(source, head(theta_init="signed", **changes), settings, watch=watch)


@pytest.fixture(scope="module")
def found(chirps):
    return searched(chirps, order=-1.3)


@pytest.mark.slow
def test_the_order_of_chirps_is_found_from_a_far_start(chirps, found):
    unseen = chirps.in_domain(CHIRPS.domain_names[1])
    answers = predicted_probabilities(found.model, unseen)["fused"].argmax(1).numpy()
    assert found.model.order == pytest.approx(CHIRPS.order, abs=0.01)
    assert (answers == unseen.label).mean() >= 0.97


def test_the_gradient_alone_stays_where_it_starts(chirps):
    source = chirps.in_domain(CHIRPS.domain_names[0], split="train")
    trained = train(source, head(order=0.2), TrainSettings(epochs=10, lang=False))
    assert abs(trained.model.order - 0.2) < 0.05


@pytest.mark.slow
def test_the_record_of_a_search_holds_its_curve_and_what_it_cost(chirps, found):
    search = found.search
    coarse = [
        score
        for score, kind in zip(search["score"], search["round"], strict=True)
        if kind == "coarse"
    ]
    assert len(coarse) == 21 and search["orders"][:21] == [k / 20 for k in range(21)]
    assert len(search["orders"]) == len(search["spread"]) == len(search["score"])
    assert search["orders"][int(np.argmin(coarse))] == pytest.approx(CHIRPS.order, abs=0.05)
    source = chirps.in_domain(CHIRPS.domain_names[0], split="train")
    assert search["steps"] == search_steps(len(source), TrainSettings(order_search=True))
    assert search["found"] == found.model.order


def test_the_start_that_a_head_states_does_not_matter(chirps, few_steps):
    """Shortened, and to the bit: the search's trainings set p themselves."""
    runs = [searched(chirps, epochs=1, stops=2, order=p).search["score"] for p in (0.1, 0.9)]
    assert runs[0] == runs[1]


def test_steps_of_search_and_training_are_counted_as_one_work(chirps, few_steps):
    steps = []
    searched(chirps, epochs=1, stops=2, watch=Watch(on_step=steps.append))
    assert [step.done for step in steps] == list(range(1, steps[-1].total + 1))
    assert len({step.total for step in steps}) == 1


def test_a_search_can_be_cancelled(chirps, few_steps):
    seen = []
    watch = Watch(on_step=seen.append, cancelled=lambda: len(seen) >= 5)
    with pytest.raises(TrainingCancelled, match="nothing was written"):
        searched(chirps, watch=watch)
    assert len(seen) == 5


def test_a_curve_without_a_valley_gives_its_best_order():
    assert lowest_point([(0.1, 1.0), (0.2, 2.0), (0.3, 1.5)]) == 0.1
    assert lowest_point([(0.1, 1.0), (0.2, 0.5), (0.3, 1.0)]) == pytest.approx(0.2)


def test_a_stopped_training_does_not_search_again(chirps, few_steps, tmp_path):
    source = chirps.in_domain(CHIRPS.domain_names[0], split="train")
    settings = TrainSettings(epochs=2, lang=False, order_search=True, order_stops=2)
    whole = train(source, head(), settings)
    state = tmp_path / "training.safetensors"
    first = []
    later = Watch(
        on_step=first.append, cancelled=lambda: len(first) > search_steps(len(source), settings)
    )
    with pytest.raises(TrainingCancelled):
        train(source, head(), settings, resume=state, watch=later)
    again = []
    resumed = train(source, head(), settings, resume=state, on_step=again.append)
    assert len(again) == settings.epochs * 7  # batches an epoch
    assert resumed.model.order == whole.model.order
    assert not list(tmp_path.iterdir())


def test_a_source_of_one_object_a_class_is_searched_without_a_held_out_part(chirps, few_steps):
    source = chirps.in_domain(CHIRPS.domain_names[0], split="train")
    one = source.select(np.array([int(np.flatnonzero(source.label == k)[0]) for k in range(5)]))
    settings = TrainSettings(epochs=1, lang=False, order_search=True, order_stops=2)
    assert np.isfinite(train(one, head(), settings).model.order)
