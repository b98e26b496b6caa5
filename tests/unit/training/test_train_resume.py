"""A stopped training resumes to the weights that it would have given."""

from functools import partial

import pytest

from omnivat.encoders.lang.bank import load_bank
from omnivat.kit.errors import DataError
from omnivat.training import TrainSettings, Watch, train
from tests.builders import equal_weights, head_settings


class Stop(Exception):
    """An error raised in the middle of training."""


def stopped_after(share):
    """Return a progress callback that raises once more than this share of the steps is done."""

    def on_step(step):
        if step.done > share * step.total:
            raise Stop

    return on_step


def test_resumed_training_equals_uninterrupted_training_to_the_bit(source, tmp_path):
    run = partial(train, source, head_settings(), TrainSettings(epochs=4), bank=load_bank(), seed=3)
    whole, state = run(), tmp_path / "training.safetensors"
    with pytest.raises(Stop):
        run(resume=state, watch=Watch(on_step=stopped_after(0.6)))
    assert state.is_file()
    steps = []
    resumed = run(resume=state, watch=Watch(on_step=steps.append))
    assert steps[0].done == steps[0].total // 2 + 1  # two of four epochs were not done again
    assert equal_weights(whole.model, resumed.model)
    assert whole.epochs == resumed.epochs
    assert not state.exists()


def test_the_state_of_another_training_is_refused(source, tmp_path):
    state = tmp_path / "training.safetensors"
    run = partial(
        train, source, head_settings(), TrainSettings(epochs=2), bank=load_bank(), resume=state
    )
    with pytest.raises(Stop):
        run(watch=Watch(on_step=stopped_after(0.5)))
    with pytest.raises(DataError, match="state of another training"):
        run(seed=9)
    state.write_bytes(b"cut short")
    with pytest.raises(DataError, match="cannot be read .*remove it to start again"):
        run()
