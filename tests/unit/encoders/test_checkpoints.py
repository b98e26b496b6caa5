"""Checkpoints as trainers write them give the weights of the plain file, bit by bit."""

import json
from argparse import Namespace
from contextlib import suppress
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
import pytest
import torch
from safetensors.torch import save_file

from omnivat.encoders.clip import open_clip
from omnivat.kit.errors import DataError

pytest.importorskip("transformers")
pytestmark = pytest.mark.usefixtures("nothing_outside")


def prefixed(state, prefix):
    return {prefix + key: value for key, value in state.items()}


def split_text(state):
    return {k if k.startswith("visual.") else f"text.{k}": v for k, v in state.items()}


def inner(state):
    return {key.replace("visual.", "visual._orig_mod."): value for key, value in state.items()}


WRITTEN = {
    "of an epoch": lambda s: {"epoch": 3, "state_dict": prefixed(s, "module.")},
    "data parallel": lambda s: prefixed(s, "module."),
    "compiled, then data parallel": lambda s: prefixed(s, "module._orig_mod."),
    "of a compiled image tower": inner,
    "Lightning": lambda s: {
        "state_dict": prefixed(s, "model.") | {"loss.weight": torch.ones(1)},
        "optimizer_states": [{"state": {0: {"exp_avg": torch.ones(2)}}}],
        "hyper_parameters": Namespace(rate=0.1, folder=Path("x")),
    },
    "a text tower of its own": split_text,
    "both": lambda s: {"model_state_dict": prefixed(split_text(s), "net.clip.")},
    "numpy numbers": lambda s: {"best": np.float64(0.3), "at": np.arange(3), "state_dict": s},
    "an average beside": lambda s: {"model": s, "model_ema": {k: v + 1 for k, v in s.items()}},
    "another encoder": lambda s: prefixed(s, "a.") | {"b.token_embedding.weight": torch.ones(1)},
}  # fmt: skip


def same(found, plain):
    for tower in ("image", "text"):
        own, wanted = getattr(found.weights, tower), getattr(plain.weights, tower)
        assert own.keys() == wanted.keys() and all(torch.equal(own[k], wanted[k]) for k in wanted)
    assert found.weights.logit_scale == plain.weights.logit_scale


@pytest.fixture
def plain(clips, tmp_path):
    """Return the names and weights of OpenAI, and the CLIP of their plain file."""
    state = clips.openai_names(clips.small_model().state_dict())
    torch.save(state, tmp_path / "plain.pt")
    return state, open_clip("clip", tmp_path / "plain.pt")


@pytest.mark.parametrize(("name", "zipped"), [*((n, True) for n in WRITTEN), ("Lightning", False)])
def test_a_trainers_checkpoint_is_the_plain_file(plain, tmp_path, name, zipped):
    state, wanted = plain
    torch.save(WRITTEN[name](state), tmp_path / "its.ckpt", _use_new_zipfile_serialization=zipped)
    same(open_clip("clip", tmp_path / "its.ckpt"), wanted)


def test_a_safetensors_file_has_the_same_names(plain, tmp_path):
    state, wanted = plain
    save_file(WRITTEN["a text tower of its own"](state), tmp_path / "its.safetensors")
    same(open_clip("clip", tmp_path / "its.safetensors"), wanted)


def test_a_whole_model_is_read_without_its_classes(plain, clips, tmp_path):
    model = clips.small_model()
    torch.save(model, tmp_path / "whole.pt")
    same(open_clip("clip", tmp_path / "whole.pt"), plain[1])


@pytest.mark.parametrize("ending", ["safetensors", "bin"])
def test_shards_are_read_by_their_index(plain, clips, tmp_path, ending):
    folder, state = tmp_path / "sharded", clips.small_model().state_dict()
    folder.mkdir()
    stem = {"safetensors": "model", "bin": "pytorch_model"}[ending]
    places = {key: f"{stem}-{1 + k % 2:05d}-of-00002.{ending}" for k, key in enumerate(state)}
    for file in set(places.values()):
        part = {key: state[key].contiguous() for key in state if places[key] == file}
        (save_file if ending == "safetensors" else torch.save)(part, folder / file)
    index = folder / f"{stem}.{ending}.index.json"
    index.write_text(json.dumps({"metadata": {}, "weight_map": places}))
    same(open_clip("clip", folder), plain[1])
    same(open_clip("clip", index), plain[1])
    (folder / places["logit_scale"]).unlink()
    with pytest.raises(DataError, match="00001-of-00002"):
        open_clip("clip", folder)
    index.write_text(json.dumps({"weight_map": {"a": "../plain.pt"}}))
    with pytest.raises(DataError, match="a file of another folder"):
        open_clip("clip", folder)


def test_two_models_in_one_file_are_a_question(plain, tmp_path):
    state = prefixed(plain[0], "teacher.") | prefixed(plain[0], "student.")
    torch.save(state, tmp_path / "two.pt")
    with pytest.raises(DataError, match=r"begin with 'student\.' and 'teacher\.'"):
        open_clip("clip", tmp_path / "two.pt")


class Runs:
    """A pickle of it touches a file."""

    def __init__(self, file):
        self.file = file

    def __reduce__(self):
        return Path.touch, (self.file,)


def stretched(state, tmp_path):
    name, value = next((n, v) for n, v in state.items() if v.dim() == 2)
    return state | {name: value[:1, :1].expand(100_000, 100_000)}


@pytest.mark.parametrize("zipped", [True, False])
def test_a_checkpoint_runs_nothing(plain, tmp_path, zipped):
    content = {"args": Runs(tmp_path / "ran"), "state_dict": plain[0]}
    torch.save(content, tmp_path / "x.pt", _use_new_zipfile_serialization=zipped)
    with suppress(DataError):
        open_clip("clip", tmp_path / "x.pt")
    assert not (tmp_path / "ran").exists()


def test_a_few_numbers_that_are_stretched_to_many_are_refused(plain, tmp_path):
    torch.save(stretched(plain[0], tmp_path), tmp_path / "x.pt")
    with pytest.raises(DataError, match="more cells than its bytes"):
        open_clip("clip", tmp_path / "x.pt")


def test_a_compressed_archive_is_refused(plain, tmp_path):
    with (
        ZipFile(tmp_path / "plain.pt") as good,
        ZipFile(tmp_path / "x.pt", "w", ZIP_DEFLATED) as to,
    ):
        for name in good.namelist():
            to.writestr(name, good.read(name))
    with pytest.raises(DataError, match="compressed"):
        open_clip("clip", tmp_path / "x.pt")
