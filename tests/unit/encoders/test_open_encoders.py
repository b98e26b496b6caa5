"""Encoders that the project does not list: one's own code, and one for each modality."""

import os
import sys

import numpy as np
import pytest
import torch
from torch import nn

from omnivat.encoders import PairEncoder, TorchEncoder, base, load_encoder
from omnivat.encoders.base import for_modality, made_by
from omnivat.encoders.cache import EmbeddingCache, embed_image, embed_pair
from omnivat.kit.errors import DataError, MissingNameError, SettingsError

pytestmark = pytest.mark.usefixtures("nothing_outside")

# One's own code

OWN = """
import torch
from omnivat.encoders import TorchEncoder

def load(weights=None, device="cpu"):
    torch.manual_seed(0)
    network = torch.nn.Sequential(torch.nn.AdaptiveAvgPool2d(2), torch.nn.Flatten(),
                                  torch.nn.Linear(12, 5))
    if weights is not None:
        network.load_state_dict(torch.load(weights, weights_only=True))
    return TorchEncoder(network, side=32, device=device, about="a test")

def tiny():
    return object()

def nameless():
    found = load()
    found.weights_hash = ""
    return found

def wrong_width():
    found = load()
    found.width = 7
    return found

def nan():
    found = load()
    found.network[2].bias.data.fill_(float("nan"))
    return found

def vanishing():
    found = load()
    for value in found.network.parameters():
        value.data *= 1e-9
    return found
"""


@pytest.fixture
def module(tmp_path, monkeypatch):
    (tmp_path / "own_encoder.py").write_text(OWN)
    monkeypatch.syspath_prepend(str(tmp_path))
    return "own_encoder"


def test_a_function_of_a_module_or_of_a_file_loads(module, tmp_path):
    by_module = load_encoder(f"{module}:load")
    by_file = load_encoder(f"{tmp_path / module}.py:load")
    assert (by_module.name, by_module.width) == ("own_encoder:load", 5)
    assert by_module.preprocessing.endswith("std 0.229 0.224 0.225, a test")
    assert by_module.weights_hash == by_file.weights_hash


def test_an_entry_of_the_table_of_encoders_is_loaded_again_by_its_short_name(module, monkeypatch):
    monkeypatch.setitem(base.ENCODERS, "mine", f"{module}:load")
    assert load_encoder("mine").name == "mine"
    assert load_encoder("mine#1").name == "mine#1"


def test_a_picture_is_embedded_again_once_the_code_of_its_encoder_has_changed(tmp_path, picture):
    file, cache = tmp_path / "pooled.py", EmbeddingCache(tmp_path / "cache")
    vectors, keys = [], []
    for number, pooling in enumerate(("Avg", "Max", "Avg")):
        file.write_text(OWN.replace("AdaptiveAvgPool2d", f"Adaptive{pooling}Pool2d"))
        os.utime(file, (number, number))  # Python keeps compiled code by the second of the change
        encoder = load_encoder(f"{file}:load")
        vectors.append(embed_image(encoder, picture, cache))
        keys.append(made_by(PairEncoder(encoder, encoder)))  # of unfinished parts of a set
    assert not np.array_equal(vectors[0], vectors[1])
    np.testing.assert_array_equal(vectors[0], vectors[2])
    assert keys[0] == keys[2] != keys[1]


def test_an_entry_point_is_an_encoder(module, monkeypatch):
    from importlib.metadata import EntryPoint

    point = EntryPoint(name="theirs", value=f"{module}:load", group="omnivat.encoders")
    monkeypatch.setattr(base, "entry_points", lambda group: [point])
    assert load_encoder("theirs").name == "theirs"
    with pytest.raises(MissingNameError, match="theirs, hf:NAME_OR_FOLDER and module:function"):
        load_encoder("unknown")


@pytest.mark.parametrize(
    ("name", "match"),
    [
        ("own_encoder:tiny", "returned object, which has no preprocess, embed"),
        ("own_encoder:nameless", "has no text in weights_hash; it identifies the weights"),
        ("own_encoder:wrong_width", "gave 5 values for one image, and its width is 7"),
        ("own_encoder:nan", "expected a finite vector"),
        ("own_encoder:vanishing", "A vector of 'own_encoder:vanishing' has no value above"),
        ("own_encoder:absent", "no function 'absent'"),
        ("no_such_module:load", "cannot be imported .ModuleNotFoundError"),
        ("nowhere.py:load", "no file 'nowhere.py'"),
        ("imported:mine", "of 'mine' were made elsewhere and imported"),
    ],
)
@pytest.mark.usefixtures("module")
def test_code_that_gives_no_encoder_is_refused_in_one_sentence(name, match):
    with pytest.raises(DataError, match=match):
        load_encoder(name)


def test_a_network_that_draws_at_random_is_refused():
    class Noisy(nn.Module):
        def forward(self, x):
            return x.mean(dim=(2, 3)) + torch.rand(1, 3)

    with pytest.raises(DataError, match="another embedding each time"):
        TorchEncoder(Noisy())


def test_tokens_without_a_pooling_are_refused():
    class Tokens(nn.Module):
        def forward(self, x):
            return x.flatten(2).mT

    with pytest.raises(DataError, match="With TorchEncoder, set pool="):
        TorchEncoder(Tokens())
    assert TorchEncoder(Tokens(), pool=lambda tokens: tokens[:, 0]).width == 3


# One encoder for each modality


def test_photos_and_touches_have_their_own_encoders_of_one_width(module, picture):
    pair = load_encoder(f"efficientnet-lite0 | {module}:load")
    assert isinstance(pair, PairEncoder)
    vis, tac = load_encoder("efficientnet-lite0"), load_encoder(f"{module}:load")
    assert pair.width == 1280
    assert pair.weights_hash == f"{vis.weights_hash} | {tac.weights_hash}"
    assert "5 values and zeros up to 1280" in pair.preprocessing
    seen, felt = embed_pair(pair, picture, picture)
    assert seen is not None and felt is not None
    assert np.array_equal(seen, vis.embed(vis.preprocess(picture)[None])[0].numpy())
    wanted = tac.embed(tac.preprocess(picture)[None])[0].numpy()
    assert np.array_equal(felt[:5], wanted) and not felt[5:].any()
    assert for_modality(vis, "tac") is vis
    with pytest.raises(DataError, match="an encoder for each modality"):
        pair.preprocess(picture)


def test_a_pair_is_loaded_again_by_its_name_and_hash(module, tmp_path):
    torch.manual_seed(1)
    other = nn.Sequential(nn.AdaptiveAvgPool2d(2), nn.Flatten(), nn.Linear(12, 5))
    torch.save(other.state_dict(), tmp_path / "other.pt")
    name = f"{module}:load | {module}:load"
    first = load_encoder(name, tac_weights=tmp_path / "other.pt")
    again = load_encoder(name, weights_hash=first.weights_hash)
    assert again.weights_hash == first.weights_hash
    assert len(set(first.weights_hash.split(" | "))) == 2


def test_code_in_this_folder_and_beside_a_file_is_found_by_the_installed_command(
    tmp_path, monkeypatch
):
    """`omnivat` does not look in the folder it runs in, as `python -m omnivat` does."""
    (tmp_path / "deeper").mkdir()
    code = (
        "import torch\nfrom omnivat.encoders import TorchEncoder\n"
        "def load():\n    return TorchEncoder(torch.nn.Sequential(torch.nn.Conv2d(3, 4, 32),"
        " torch.nn.AdaptiveAvgPool2d(1), torch.nn.Flatten()), side=32)\n"
    )
    (tmp_path / "here_touch.py").write_text(code)
    (tmp_path / "deeper" / "beside_touch.py").write_text(code)
    (tmp_path / "deeper" / "wrap_touch.py").write_text("from beside_touch import load\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [place for place in sys.path if place])
    assert load_encoder("here_touch:load").width == 4
    assert load_encoder("deeper/wrap_touch.py:load").width == 4


# A layer

LAYERS = """
import torch
from omnivat.encoders import TorchEncoder

def load():
    torch.manual_seed(0)
    body = torch.nn.Sequential(torch.nn.Conv2d(3, 4, 8, 8), torch.nn.ReLU(),
                               torch.nn.Flatten(2), torch.nn.Linear(16, 7))
    return TorchEncoder(torch.nn.ModuleDict({"body": body})["body"], side=32,
                        pool=lambda tokens: tokens.mean(1), about="tokens")
"""


def test_a_layer_is_the_mean_of_its_output_over_its_places(tmp_path, picture):
    (tmp_path / "layered.py").write_text(LAYERS)
    name = f"{tmp_path / 'layered'}.py:load"
    whole = load_encoder(name)
    image = whole.preprocess(picture)[None]
    made = {layer: load_encoder(f"{name}#{layer}") for layer in ("1", "2", "3", "0")}
    with torch.inference_mode():
        first = whole._inner.network[0](image)
        wanted = {"1": first.mean((2, 3)), "2": first.relu().mean((2, 3))}
    wanted |= {"3": first.relu().flatten(2).mean(1), "0": wanted["1"]}  # 0: the name of a part
    for layer, encoder in made.items():
        torch.testing.assert_close(encoder.embed(image), wanted[layer])
        assert encoder.name == f"{name}#{layer}" and f"layer {layer}," in encoder.preprocessing
        assert encoder.weights_hash == whole.weights_hash
    assert len({made_by(encoder) for encoder in made.values()}) == 4


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("efficientnet-lite0#17", "no layer '17'; give a number from 1 to 16, or a part of stem,"),
        ("efficientnet-lite0#tail", "no layer 'tail'"),
        ("strip#1", "'strip' has no layers; leave out --layer 1"),
    ],
)
def test_a_layer_that_is_not_there_is_refused(name, message):
    with pytest.raises(SettingsError, match=message):
        load_encoder(name)


@pytest.mark.usefixtures("module")
def test_a_checkpoint_for_code_that_takes_none_is_refused(tmp_path):
    with pytest.raises(SettingsError, match="takes no weights"):
        load_encoder("own_encoder:tiny", weights=tmp_path)
