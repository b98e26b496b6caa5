"""The page as a folder for a file server: what is in it, and how it is written."""

import json
import re
import shutil
from urllib.parse import urlsplit

import numpy as np
import pytest
import torch
from safetensors.numpy import load_file
from torch.nn.functional import normalize

from app.serving.routes import FACTS, QUESTIONS
from app.shared import map_place
from app.shared.resources import Resources
from app.site import folder as site
from app.site.folder import MARK, OWN, export_site
from app.site.models import files_in, write_places, write_set
from omnivat.cli import main
from omnivat.kit.errors import DataError, SettingsError, WriteError

from .conftest import own_image


@pytest.fixture(scope="module")
def written(framed, tmp_path_factory):
    """Return the site of the small set alone."""
    out = tmp_path_factory.mktemp("sites") / "of 2% é"
    export_site(framed, out, sets=(), models=False)
    return out


def held(out):
    text = (out / "index.html").read_text(encoding="utf-8")
    return json.loads(re.search(r'id="omnivat-held">(.*?)</script>', text)[1])


def names_in(out):
    return [file.relative_to(out).as_posix() for file in files_in(out)]


def test_every_address_is_relative_and_of_a_file_in_the_folder(written):
    text = (written / "index.html").read_text(encoding="utf-8")
    named = [*re.findall(r'(?:src|href)="([^"]+)"', text), *held(written)["files"].values()]
    for address in named:
        parts = urlsplit(address)
        assert not parts.scheme and not parts.netloc and not address.startswith("/"), address
        assert (written / address).is_file(), address
    assert len(named) > 30


def test_the_worker_keeps_every_file_below_the_page_and_examples_last(written):
    script = (written / "sw.js").read_text()
    kept = json.loads(re.match(r"globalThis.omnivatSite = (.*);", script)[1])
    assert sorted(kept["first"] + kept["rest"]) == [n for n in names_in(written) if "/" in n]
    assert {name.split("-")[0] for name in kept["first"]} == {"web"}
    examples = [name for name in kept["rest"] if "-example-" in name]
    assert len(examples) == 5 and examples == kept["rest"][-5:]  # four pictures and a journey


def test_no_file_of_the_page_names_another_host(written):
    files = [file for file in files_in(written) if file.suffix in (".js", ".css", ".html")]
    found = {
        (file.name, host)
        for file in files
        for host in re.findall(r"(?:https?:)?//([\w.-]+\.[a-z]{2,})", file.read_text())
    }
    assert {host for _, host in found} <= {"www.w3.org"}  # the name of SVG, never fetched
    assert "default-src 'none'" in (written / "index.html").read_text()


def test_replies_are_those_of_the_server(written, framed):
    index, resources = held(written), Resources(framed)
    assert index["home"] == OWN and index["sets"] == [OWN]
    for name in ("about", "unseen", "pairs", "examples", "first"):
        file = index["files"][f"{OWN}/{name}"]
        assert json.loads((written / file).read_text()) == json.loads(
            json.dumps(FACTS[name](resources))
        )
    file = index["files"][f'{OWN}/votes {{"head":""}}']
    assert json.loads((written / file).read_text()) == QUESTIONS["votes"](resources, {"head": ""})
    picture = index["files"][f"{OWN}/example/OF Real-sim/steel/new/tac"]
    assert (written / picture).read_bytes() == resources.examples()["OF Real-sim/steel/new"][
        "tac"
    ].read_bytes()


def test_the_models_of_a_set_are_its_embeddings_in_parts_and_a_record_of_its_heads(
    framed, tmp_path, monkeypatch
):
    monkeypatch.setattr("omnivat.head.portable.write_head", lambda file, _: file.touch())
    resources = Resources(framed)
    write_set(resources, tmp_path)
    record = json.loads((tmp_path / "models.json").read_text())
    assert {name: head["file"] for name, head in record["heads"].items()} == {"": "first.onnx"}
    names = [f"set-{k}.safetensors" for k in range(-(-record["pairs"] // record["part"]))]
    assert {*names, "first.onnx"} < {file.name for file in tmp_path.iterdir()} and len(names) > 1
    for image in ("vis", "tac"):
        parts = np.concatenate([load_file(tmp_path / name)[image] for name in names])
        assert (parts == getattr(resources.embeddings(), image).astype("f2")).all()


def test_own_pictures_are_placed_on_a_linear_map_as_the_server_places_them(framed, tmp_path):
    resources = Resources(framed)
    stops = write_places(resources, tmp_path / "places.safetensors")
    places = load_file(tmp_path / "places.safetensors")
    assert {name.split()[0] for name in places} == {"pca"}  # no map between neighbours
    sent = own_image(resources, resources.embeddings().vis[7] + 0.2)
    wanted = map_place.journey(resources, {"tac": sent})
    assert [stop for stop, _ in stops] == list(wanted["stops"])
    for at, (stop, order) in enumerate(stops):
        row = resources.head().model(
            None, torch.tensor(resources.embeddings().vis[7:8] + 0.2), order=order
        )
        row = normalize(row.f_hat["tac"][0].double(), dim=0).numpy()
        found = places[f"pca {stop}"] @ np.append(row, 1)
        np.testing.assert_allclose(found, wanted["maps"]["pca"]["places"]["tac"][at], atol=1e-4)


def test_a_reply_that_is_a_refusal_is_held_as_its_sentence(framed, tmp_path, monkeypatch):
    def broken():
        raise DataError("The set has no map.")

    monkeypatch.setattr(site, "replies", lambda *_: [("toy", broken)])
    export_site(framed, tmp_path / "site", sets=(), models=False)
    assert held(tmp_path / "site")["refused"] == {f"{OWN}/toy": "The set has no map."}


def test_a_new_export_replaces_old_files_under_the_same_names_and_leaves_what_was_added(
    written, framed, tmp_path
):
    out = shutil.copytree(written, tmp_path / "site")
    listed = json.loads((out / MARK).read_text())["files"]
    (out / MARK).write_text(json.dumps({"files": [*listed, "data/stale.json"]}))
    (out / "data" / "stale.json").write_text("{}")
    (out / "README.md").write_text("sdk: static")
    export_site(framed, out, sets=(), models=False)
    assert names_in(out) == sorted([*names_in(written), "README.md"])
    assert (out / "README.md").read_text() == "sdk: static"
    assert all(re.fullmatch(r"[\w./-]+", name, re.ASCII) for name in listed)


@pytest.mark.parametrize("kind", ["folder", "file"])
def test_nothing_foreign_is_overwritten(framed, tmp_path, kind):
    out = tmp_path / "thesis"
    if kind == "folder":
        out.mkdir()
        (out / "thesis.tex").write_text("years")
    else:
        out.write_text("years")
    before = {file: file.read_text() for file in files_in(tmp_path)}
    with pytest.raises(WriteError, match="name a"):
        export_site(framed, out)
    assert {file: file.read_text() for file in files_in(tmp_path)} == before


def test_a_set_that_the_project_lacks_is_refused(framed, tmp_path):
    with pytest.raises(SettingsError, match="No set is called 'chirp'; there are sensors, chirps"):
        export_site(framed, tmp_path / "site", sets=["chirp"])


def test_the_command_takes_a_file_or_a_folder(tmp_path, capsys):
    with pytest.raises(SystemExit):
        main(["export", "--site", str(tmp_path / "a"), "--out", str(tmp_path / "b.html")])
    assert main(["export", "--out", str(tmp_path / "b.png"), "--sets", "chirps"]) == 1
    assert "belong to --site" in capsys.readouterr().err
