"""Train here: what it states of a run."""

from types import SimpleNamespace

import pytest

from app.train.words import earlier, standing, status, unfit


def run(state, epochs=0, *, place=0, text="", left="", problem="", left_out=0, loaded="", **last):
    """Return a run as the words read it; `last`: measures of its last epoch."""
    step = SimpleNamespace(text=text, left=left) if text else None
    settings = SimpleNamespace(width=64)
    training = SimpleNamespace(epochs=40)
    plan = SimpleNamespace(training=training, left_out=left_out, settings=settings, source="<A>")
    records = [{"order": 0.5} for _ in range(epochs)]
    if records:
        records[-1] |= last
    job = SimpleNamespace(state=state, place=place, step=step, problem=problem)
    active = state in ("waiting", "running")
    return SimpleNamespace(
        job=job, plan=plan, epochs=records, loaded=loaded, words="<A>, D = 64", active=active
    )


@pytest.mark.parametrize(
    ("of", "words"),
    [
        (
            run("waiting", place=2, left_out=12),
            "Waiting: place 2 in the queue. One training runs at a time. 12 pairs without a class"
            " are left out.",
        ),
        (run("running", 3, text="epoch 3", left="9 s left"), "Training: epoch 3 of 40, 9 s left."),
        (run("running", 40, text="epoch 40"), "Calibrating probabilities on held-out pairs."),
        (run("failed", problem="The loss is nan.", left_out=12), "The loss is nan."),
        (run("done", 40, left_out=1), "Done: 40 epochs. 1 pair without a class is left out."),
    ],
)
def test_a_run_states_its_place_its_epoch_or_its_end(of, words):
    assert standing(of) == words


def test_no_name_or_sentence_becomes_markup():
    remedy = {"remedy": "<b>", "command": "omnivat <x>"}
    for text in (status("<i>"), unfit("<i>", remedy), earlier([run("done", 40, loaded="a")])):
        assert not {"<i>", "<b>", "<x>", "<A>"} & {text[k : k + 3] for k in range(len(text))}


def test_two_finished_runs_are_compared_and_one_is_not():
    runs = [run("done", 40, **{"accuracy/unseen": share}) for share in (0.5, 0.512)]
    assert "1.2 points above the one before it. Train the same settings" in earlier(runs)
    assert "1.2 points below" in earlier(runs[::-1])
    assert "points" not in earlier(runs[1:]) and earlier([]) == ""
    assert "–" in earlier([run("done", 40)])  # of a set of one domain


def test_a_run_states_which_pairs_its_figures_are_of():
    assert "tested on its own test pairs" in status("", run("running", 3))
    assert "of the unseen domains" in status("", run("running", 3, **{"accuracy/unseen": 0.5}))
