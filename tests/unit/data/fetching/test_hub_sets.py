"""Sets of the model hub on which only the sensor changes, on trees made in their layout."""

from collections import Counter
from io import BytesIO
from zipfile import ZipFile

import numpy as np
import pytest
from PIL import Image

from omnivat.cli import main
from omnivat.data.fetching import fetch, layouts
from omnivat.data.readers import read_pairs
from omnivat.data.rest import with_rest
from omnivat.kit.errors import DataError


@pytest.fixture(autouse=True)
def few(monkeypatch):
    monkeypatch.setattr(layouts, "EACH", 3)


def picture(value, kind="PNG"):
    with BytesIO() as handle:
        Image.fromarray(np.full((16, 24, 3), value, np.uint8)).save(handle, kind)
        return handle.getvalue()


def written(root, names):
    for name in names:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_bytes(picture(9, "JPEG" if name.endswith("jpg") else "PNG"))
    return root


def counted(out):
    found = read_pairs(out)
    assert found.modalities() == ("tac",) and (out / "TERMS.txt").is_file()
    return Counter((p.domain, p.split, p.material) for p in found.pairs), found


def test_sitr_gives_a_few_presses_of_each_class_and_each_sensor_its_rest_picture(tmp_path, capsys):
    with ZipFile(tmp_path / "classification_dataset.zip", "w") as archive:
        for part in ("train_set", "val_set"):
            for sensor in (0, 1):
                folder = f"classification_dataset/{part}/sensor_{sensor:04d}"
                for k in range(2):
                    archive.writestr(f"{folder}/calibration/{k:04d}.png", picture(100 + k))
                for kind in (0, 17):
                    for k in range(5):
                        name = f"{folder}/samples/class_{kind:04d}/{k:04d}.png"
                        archive.writestr(name, picture(10 * sensor + k))
    out = tmp_path / "out"
    assert main(["fetch", "sitr", "--from", str(tmp_path), "--out", str(out)]) == 0
    domains = ("SITR 0 (GelSight Mini)", "SITR 1")
    counts, found = counted(out)
    assert counts == {
        (domain, split, kind): 3
        for domain in domains
        for split in ("train", "val")
        for kind in ("object 0", "object 17")
    }
    assert len({pair.object for pair in found.pairs}) == len(found.pairs) == 24
    rests = {pair.tac_rest for pair in with_rest(found, "auto").pairs}
    assert {np.asarray(Image.open(rest))[0, 0, 0] for rest in rests} == {100}
    assert "Terms, in the authors' words: license: mit" in capsys.readouterr().out


def test_the_pads_of_the_gelsight_mini_are_domains_and_folders_are_classes(tmp_path):
    names = [f"star/x1_y2_F{k}.jpg" for k in range(5)] + ["star/initial.jpg", "round/a/b.png"]
    pads = [f"gelsight_mini/mini_pad{pad}/{name}" for pad in (0, 1) for name in names]
    objects = ["gelsight_mini/mini_pad0_ob/rope/1.jpg", "gelsight_mini/mini_pad2/alone.jpg"]
    other = ["glowtact/glowtact0_pad0/star/1.jpg", "gelsight_mini/gelsight mini_images/1.jpg"]
    written(tmp_path / "files", [*pads, *objects, *other])
    counts, found = counted(
        fetch("glowtact-mini", tmp_path / "out", source=str(tmp_path / "files"))
    )
    mini = "GelSight Mini, pad"
    assert counts == {
        **{(f"{mini}{k}", "", kind): n for k in (0, 1) for kind, n in (("star", 3), ("round", 1))},
        (f"{mini}0", "", "rope"): 1,
        (f"{mini}2", "", "unlabelled"): 1,
    }
    rested = with_rest(found, "auto").pairs
    assert {pair.material for pair in rested if pair.tac_rest} == {"star"}


def test_feats_gives_indenters_on_one_sensor_and_on_another_with_two_gels(tmp_path):
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    for name in ("train", "val", "test_unknown_indenters", "test_diff_sensor_new_gel"):
        file = tmp_path / "files" / "feats" / f"{name}-00000-of-00001.parquet"
        file.parent.mkdir(parents=True, exist_ok=True)
        columns = {
            "image": [picture(k, "JPEG") for k in range(10)],
            "split": [name] * 10,
            "domain": ["real"] * 10,
            "indenter": ["sphere"] * 5 + ["cube"] * 5,
            "indenter_param": ["10"] * 10,
            "f_z": [-1.0] * 10,
            "episode": pa.array([None] * 10, pa.string()),
        }
        pq.write_table(pa.table(columns), file)
    counts, found = counted(fetch("feats-mini", tmp_path / "out", source=str(tmp_path / "files")))
    domains = {"train": "GelSight Mini", "val": "GelSight Mini", "test": "GelSight Mini"}
    assert counts == {
        (domain, split, kind): 3
        for kind in ("sphere", "cube")
        for split, domain in (*domains.items(), ("test", "GelSight Mini, other, new gel"))
    }
    assert {pair.object for pair in found.pairs} == {"sphere 10", "cube 10"}


def test_a_set_that_is_not_there_or_is_damaged_is_one_sentence(tmp_path):
    with pytest.raises(DataError, match="has no pairs of sitr now"):
        fetch("sitr", tmp_path / "out", source=str(written(tmp_path / "a", ["x.png"])))
    (tmp_path / "a" / "classification_dataset.zip").write_bytes(b"PK no zip")
    with pytest.raises(DataError, match="is no whole archive"):
        fetch("sitr", tmp_path / "out", source=str(tmp_path / "a"))
    with pytest.raises(DataError, match="None of the 0 recordings"):
        fetch("feats-mini", tmp_path / "out", source=str(tmp_path / "a"))
    assert not (tmp_path / "out").exists()
