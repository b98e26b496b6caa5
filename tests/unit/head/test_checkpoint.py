"""A head on disk: a saved head loads unchanged, and errors name the file."""

import json
import shutil
from dataclasses import replace
from functools import partial

import pytest
import torch
from safetensors.torch import load_file, save_file

from omnivat.data.dots import FILLED
from omnivat.data.rest import RESTED
from omnivat.head.checkpoint import head_hash, load_head, require_head_folder, save_head
from omnivat.kit.errors import DataError


@pytest.fixture
def folder(head_folder, tmp_path):
    """A copy of the trained head for tests to damage."""
    return shutil.copytree(head_folder, tmp_path / "copy")


def test_a_head_comes_back_as_it_was_saved(folder, tmp_path):
    first = load_head(folder)
    first.model.temperatures = {"fused": 1.5, "vis": 2.0, "tac": 3.0}
    save_head(tmp_path / "again", first)
    second = load_head(tmp_path / "again")
    for name, tensor in first.model.state_dict().items():
        assert torch.equal(tensor, second.model.state_dict()[name])
    assert (first.settings, first.encoder) == (second.settings, second.encoder)
    assert first.provenance == second.provenance
    assert first.model.temperatures == second.model.temperatures
    rows = first.familiarity.rows["vis"][:3]
    assert first.familiarity.look(rows, None) == second.familiarity.look(rows, None)
    save_head(tmp_path / "third", second)
    assert head_hash(tmp_path / "again") == head_hash(tmp_path / "third") != head_hash(folder)


def test_a_loaded_head_is_frozen_and_its_order_stays_in_double_precision(folder):
    head = load_head(folder)
    assert not head.model.training
    assert not any(p.requires_grad for p in head.model.parameters())
    assert head.model.mffa.order.dtype == torch.float64


def test_saving_replaces_an_older_head_and_nothing_else(folder, tmp_path):
    head = load_head(folder)
    save_head(folder, head)
    other = tmp_path / "thesis"
    other.mkdir()
    (other / "chapter.txt").write_text("years of work")
    with pytest.raises(DataError, match=r"holds 'chapter.txt', which is not part of a head"):
        save_head(other, head)
    assert (other / "chapter.txt").read_text() == "years of work"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["copy", "thesis"]


def test_what_a_killed_training_was_writing_does_not_hold_up_the_next_run(tmp_path):
    (tmp_path / ".training.safetensors.ab12.tmp").write_text("half")
    require_head_folder(tmp_path)
    (tmp_path / ".notes").write_text("mine")
    with pytest.raises(DataError, match=r"holds '\.notes', which is not part of a head"):
        require_head_folder(tmp_path)


def test_a_save_that_fails_leaves_the_old_head_whole(folder, monkeypatch):
    before, head = head_hash(folder), load_head(folder)
    monkeypatch.setattr(
        "omnivat.head.checkpoint.write_json", lambda *_: (_ for _ in ()).throw(OSError("disk full"))
    )
    with pytest.raises(OSError, match=r"was not written \(disk full\)"):
        save_head(folder, head)
    assert head_hash(folder) == before
    assert [p.name for p in folder.parent.iterdir()] == ["copy"]


def break_weights(folder):
    path = folder / "weights.safetensors"
    path.write_bytes(path.read_bytes()[:100])


def change(folder, file, name, spoil):
    """Change one array of a head's file."""
    tensors = load_file(folder / file)
    save_file(tensors | {name: spoil(tensors[name])}, folder / file)


def edit(folder, place, **changes):
    """Change the settings of a head at a place such as "head" or "calibration/temperature"."""
    path = folder / "settings.json"
    record = part = json.loads(path.read_text())
    for name in place.split("/"):
        part = part[name]
    part |= changes
    path.write_text(json.dumps(record))


@pytest.mark.parametrize(
    ("spoil", "sentence"),
    [
        (break_weights, r"weights\.safetensors' cannot be read"),
        (
            lambda f: change(f, "weights.safetensors", "classifier", lambda x: x / 0),
            "holds no finite numbers as classifier",
        ),
        (
            lambda f: change(f, "familiarity.safetensors", "vis", lambda x: x[:, :5].clone()),
            "does not fit this head",
        ),
        (lambda f: (f / "weights.safetensors").unlink(), r"weights\.safetensors' is missing"),
        (lambda f: (f / "settings.json").write_text("{"), r"is not readable JSON"),
        (lambda f: (f / "settings.json").write_text("{}"), "is not the settings of a head"),
        (lambda f: edit(f, "head", width=32), r"does not fit its settings: .* shape"),
        (lambda f: edit(f, "head", levls=3), r"has no setting 'levls'\. Did you mean 'levels'"),
        (lambda f: edit(f, "head", width="wide"), "Setting 'width' is 'wide'; it must be int"),
        (shutil.rmtree, r"No head at .* Train one with"),
        *(
            (partial(edit, place="provenance", train=train), "does not describe a head")
            for train in ([], {"modalities": None})
        ),
        *(
            (partial(edit, place="calibration/temperature", vis=t), r"settings\.json' holds")
            for t in (-1, "warm")
        ),
    ],
)
def test_a_spoilt_head_is_refused_with_the_name_of_the_file(folder, spoil, sentence):
    spoil(folder)
    with pytest.raises(DataError, match=sentence):
        load_head(folder)


@pytest.mark.parametrize(
    ("mark", "sentence"),
    [
        (RESTED, "with a no-contact picture .* Embed the pairs without --tac-rest"),
        (FILLED, "with the dots of touch filled, and .* Embed the pairs with --dots keep"),
    ],
)
def test_embeddings_made_in_another_way_are_refused_in_words_of_their_own(folder, mark, sentence):
    head = load_head(folder)
    with pytest.raises(DataError, match=sentence):
        head.require(("test-encoder", "0" * 16, "none" + mark), 24, what="They")
    marked = replace(head, encoder=head.encoder | {"preprocessing": "none" + mark})
    with pytest.raises(DataError, match="made without .* trained with.* pairs with "):
        marked.require(("test-encoder", "0" * 16, "none"), 24, what="They")


@pytest.mark.parametrize(
    ("key", "width"),
    [
        (("test-encoder", "f" * 16, "none"), 24),
        (("test-encoder", "0" * 16, "crop"), 24),
        (("test-encoder", "0" * 16, "none"), 512),
    ],
)
def test_embeddings_that_the_head_was_not_trained_on_are_refused(folder, key, width):
    head = load_head(folder)
    head.require(("test-encoder", "0" * 16, "none"), 24, what="The embeddings")
    with pytest.raises(
        DataError, match="The embeddings come from .* and this head was trained with"
    ):
        head.require(key, width, what="The embeddings")
