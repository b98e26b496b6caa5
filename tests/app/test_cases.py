"""The rules of the table of cases; tests/web/cases.test.js holds the page without a server to
it.
"""

import base64
import json
from math import ceil
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.numpy import save_file
from torch.nn.functional import normalize

from app.views.pair import spectrum
from omnivat.data.images import draft_scale, factor
from omnivat.data.profile import Channels, joined, load_profile, moved, require_key
from omnivat.head.calibration import nearest_cosines, quantile_of
from omnivat.kit.errors import DataError
from omnivat.maps.projection.neighbours import nearest, placed

CASES = json.loads((Path(__file__).parents[1] / "cases.json").read_text(encoding="utf-8"))
KEY, WIDTH = ("e", "w", "p"), 2
close = np.testing.assert_allclose


def channels(mean, variance, count):
    return Channels(mean=np.float32(mean), variance=np.float32(variance), count=count)


@pytest.fixture
def read(tmp_path):
    """Return what reads a file of the table, as a profile for the encoder of the table."""

    def reader(file):
        path = tmp_path / "profile.safetensors"
        vectors = {name: np.array(row, dtype=np.float32) for name, row in file["tensors"].items()}
        save_file(vectors, path, metadata=file["metadata"])
        profile = load_profile(path)
        require_key(profile, KEY, WIDTH)
        return profile

    return reader


@pytest.mark.parametrize("case", CASES["profiles"]["good"])
def test_a_sound_profile_is_taken_with_its_step(case, read):
    profile = read(case)
    assert profile.step == float(case["metadata"].get("step", 1))
    assert profile.counts == {"vis": 3, **({"tac": 7} if "tac_mean" in case["tensors"] else {})}


@pytest.mark.parametrize("name", CASES["profiles"]["bad"])
def test_a_damaged_profile_is_refused_before_anything_computes_with_it(name, read):
    with pytest.raises(DataError, match="is no profile"):
        read(CASES["profiles"]["bad"][name])


@pytest.mark.parametrize("name", CASES["profiles"]["other"])
def test_a_profile_of_another_encoder_is_refused(name, read):
    with pytest.raises(DataError, match="The profile comes from"):
        read(CASES["profiles"]["other"][name])


@pytest.mark.parametrize("case", CASES["moved"])
def test_a_heads_source_says_how_much_of_the_step_is_taken(case):
    target, source = channels(**case["target"]), channels(**case["source"])
    found = moved(np.float32([case["row"]]), target, source, case["step"])
    close(found, [case["moved"]], atol=1e-5)


@pytest.mark.parametrize("case", CASES["joined"])
def test_statistics_of_two_sets_of_pictures_join(case):
    found, wanted = joined(channels(**case["one"]), channels(**case["other"])), case["joined"]
    assert found.count == wanted["count"]
    close(found.mean, wanted["mean"], rtol=1e-6)
    close(found.variance, wanted["variance"], rtol=1e-6)


@pytest.mark.parametrize("case", CASES["familiarity"])
def test_familiarity_is_a_cosine_and_its_place_among_quantiles(case):
    cosines = nearest_cosines(torch.tensor([case["row"]]), torch.tensor(case["rows"]))
    close(cosines[0, 0], case["cosine"], atol=1e-6)
    place = quantile_of(cosines.mean(1), torch.tensor(case["quantiles"]))
    close(place[0], case["quantile"], atol=1e-5)


@pytest.mark.parametrize("case", CASES["nearest"])
def test_the_nearest_rows_are_those_of_the_largest_cosines(case):
    others = [k for k in range(len(case["rows"])) if k != case.get("except")]
    rows = normalize(torch.tensor(case["rows"])[others], dim=1)
    found = nearest(rows, case["count"], queries=torch.tensor([case["query"]]))
    assert [others[k] for k in found.index[0]] == [point for point, _ in case["found"]]
    cosines = 1 - found.distance[0] ** 2 / 2
    close(cosines, [cosine for _, cosine in case["found"]], atol=1e-6)


@pytest.mark.parametrize("case", CASES["place"])
def test_a_linear_map_places_any_row(case):
    axes = torch.tensor(case["map"])
    points = torch.randn(40, 2, generator=torch.Generator().manual_seed(0))
    flat = points @ axes[:, :-1].T + axes[:, -1]
    found = placed(torch.tensor([case["row"]]), points, flat)
    assert found.exact
    close(found.places, [case["place"]], atol=1e-5)


@pytest.mark.parametrize("case", CASES["factor"])
def test_a_large_picture_is_made_smaller_in_steps(case):
    first = (draft_scale if case["jpeg"] else factor)(*case["size"])
    rest = factor(*(ceil(side / first) for side in case["size"])) if case["jpeg"] else 1
    assert [first, rest] == case["factors"]


@pytest.mark.parametrize("case", CASES["spectrum"])
def test_a_spectrum_is_a_picture_of_bytes(case):
    pixels = base64.b64decode(spectrum(np.array(case["moduli"]))["pixels"])
    assert np.frombuffer(pixels, np.uint8).tolist() == np.ravel(case["pixels"]).tolist()
