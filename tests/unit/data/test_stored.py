"""Pairs whose pictures lie in one file: Parquet by `datasets`, NPZ, HDF5, safetensors."""

import numpy as np
import pytest
from PIL import Image

from omnivat.cli import main
from omnivat.data import named_columns
from omnivat.data.images import from_array
from omnivat.data.readers import read_pairs
from omnivat.data.recordings import clips_of
from omnivat.kit.errors import DataError
from tests.unit.data.test_tracks import shown

COUNT = 4
NAMES = ["Wood", "steel"]


def greys(first, shape=(16, 24, 3)):
    return np.stack([np.full(shape, first + k, np.uint8) for k in range(COUNT)])


def written_by_datasets(file):
    datasets = pytest.importorskip("datasets")
    features = datasets.Features(
        wrist=datasets.Image(),
        gelsight=datasets.Image(),
        label=datasets.ClassLabel(names=NAMES),
        item=datasets.Value("string"),
    )
    rows = {
        "wrist": [Image.fromarray(one) for one in greys(50)],
        "gelsight": [Image.fromarray(one) for one in greys(150)],
        "label": [0, 1, 0, 1],
        "item": ["mug", "fork"] * 2,
    }
    file.parent.mkdir(parents=True, exist_ok=True)
    datasets.Dataset.from_dict(rows, features=features).to_parquet(file, batch_size=3)


def imported(source, out, *more):
    return main(["import", str(source), "--out", str(out), *more])


def labels(folder):
    return [(p.domain, p.material, p.object, p.split) for p in read_pairs(folder).pairs]


def test_parquet_of_the_model_hub_keeps_classes_objects_splits_and_subsets(tmp_path, capsys):
    root = tmp_path / "press"
    written_by_datasets(root / "data" / "train-00000-of-00001.parquet")
    written_by_datasets(root / "new gel" / "validation-00000-of-00001.parquet")
    assert (
        imported(root, tmp_path / "out", "--vis", "wrist", "--look", str(tmp_path / "a.png")) == 0
    )
    assert labels(tmp_path / "out") == [
        (domain, *both, split)
        for domain, split in (("press", "train"), ("new gel", "val"))
        for both in (("wood", "mug"), ("steel", "fork")) * 2
    ]
    assert shown(tmp_path / "out" / "press", "vis") == [51, 53, 50, 52]  # by class
    assert shown(tmp_path / "out" / "new gel", "tac") == [151, 153, 150, 152]
    said = capsys.readouterr().out
    assert "cameras: photo wrist, touch gelsight" in said and (tmp_path / "a.png").is_file()


@pytest.mark.parametrize("ending", [".npz", ".h5", ".safetensors"])
def test_arrays_of_pictures_become_pairs(tmp_path, ending):
    arrays = {
        "rgb": greys(50),
        "tactile": greys(150, (3, 16, 24)),
        "class": np.arange(COUNT) % 2,
        "sensor": np.array(["new", "old"] * 2),
    }
    file = tmp_path / f"a{ending}"
    if ending == ".npz":
        np.savez(file, **arrays)
    elif ending == ".safetensors":
        pytest.importorskip("safetensors.numpy").save_file(
            {name: a for name, a in arrays.items() if name != "sensor"}, file
        )
    else:
        with pytest.importorskip("h5py").File(file, "w") as handle:
            for name, array in arrays.items():
                handle[f"press/{name}"] = array.tolist() if name == "sensor" else array
    assert imported(file, tmp_path / "out", "--classes", "wood,felt") == 0
    found = read_pairs(tmp_path / "out")
    assert {p.material for p in found.pairs} == {"wood", "felt"}
    assert found.modalities() == ("vis", "tac")
    assert set(found.domains()) == ({"new", "old"} if ending != ".safetensors" else {tmp_path.name})
    assert sorted(shown(tmp_path / "out", "tac")) == [150, 151, 152, 153]


def test_pictures_are_told_from_vectors(tmp_path, capsys):
    np.savez(tmp_path / "a.npz", rgb=greys(50), tactile=greys(9))
    np.savez(tmp_path / "b.npz", vis=np.eye(3), tac=np.eye(3))
    assert imported(tmp_path / "b.npz", tmp_path / "out") == 1
    assert "holds no pictures; of vectors, name their encoder with" in capsys.readouterr().err
    assert imported(tmp_path / "a.npz", tmp_path / "b.safetensors", "--encoder", "x") == 1
    assert "a.npz --out PAIRS`, without --encoder" in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["external", "virtual"])
def test_values_of_hdf5_that_lie_in_other_files_are_refused(tmp_path, capsys, kind):
    h5py = pytest.importorskip("h5py")
    (tmp_path / "secret").write_bytes(bytes(COUNT * 48 * 48))
    with h5py.File(tmp_path / "a.h5", "w") as file:
        shape = (COUNT, 48, 48)
        if kind == "external":
            other = [(str(tmp_path / "secret"), 0, COUNT * 48 * 48)]
            file.create_dataset("tactile", shape, np.uint8, external=other)
        else:
            layout = h5py.VirtualLayout(shape, np.uint8)
            layout[:] = h5py.VirtualSource("missing.h5", "tactile", shape)
            file.create_virtual_dataset("tactile", layout)
    assert imported(tmp_path / "a.h5", tmp_path / "out") == 1
    assert "the values of tactile lie in other files" in capsys.readouterr().err


def test_an_array_that_states_a_billion_pictures_is_refused(tmp_path, capsys):
    with pytest.importorskip("h5py").File(tmp_path / "a.h5", "w") as file:
        file.create_dataset("tactile", (10**9, 48, 48), np.uint8, chunks=(1, 48, 48))
    assert imported(tmp_path / "a.h5", tmp_path / "out") == 1
    assert "states 1,000,000,000 pictures in one array" in capsys.readouterr().err


def test_a_name_is_found_among_thousands_without_a_look_at_each(monkeypatch):
    looks = []
    monkeypatch.setattr(named_columns, "_plain", lambda name: looks.append(name) or name)
    names = tuple(f"demo_{k}/array_{k}" for k in range(3000))
    table = named_columns.Columns(place=None, names=names, read=None, pictures=None)
    assert all(table.path(name) == name for name in names) and len(looks) <= 3 * len(names)


@pytest.mark.parametrize("kind", ["of any length", "padded"])
def test_files_of_pictures_in_hdf5_are_pictures_and_a_plain_row_of_bytes_is_none(tmp_path, kind):
    h5py = pytest.importorskip("h5py")
    files = []
    for grey in greys(50):
        Image.fromarray(grey).save(tmp_path / "a.png")
        files.append(np.frombuffer((tmp_path / "a.png").read_bytes(), np.uint8))
    longest = max(map(len, files))
    with h5py.File(tmp_path / "a.h5", "w") as file:
        if kind == "padded":
            file["rgb"] = np.stack([np.pad(one, (0, longest - len(one))) for one in files])
        else:
            stored = file.create_dataset("rgb", (COUNT,), h5py.vlen_dtype(np.uint8))
            for k, one in enumerate(files):
                stored[k] = one
        file["tactile"], file["force_rgb"] = greys(150), np.zeros((COUNT, 9), np.uint8)
    assert imported(tmp_path / "a.h5", tmp_path / "out") == 0
    assert shown(tmp_path / "out", "vis") == [50, 51, 52, 53]


@pytest.mark.parametrize(
    ("pixels", "grey"),
    [
        (np.full((16, 24, 3), 200.0, np.float32), 200),  # whole, so not of 0 to 1
        (np.full((16, 24), 1.0), 255),
        (np.linspace(0, 65535, 16 * 24 * 3).reshape(16, 24, 3).astype(np.uint16), 127),
        (np.full((16, 24, 3), 200), 200),  # of a list
        (np.full((16, 24, 3), 30000, np.uint16), "16-bit colour, of which 8 bits keep 0 levels"),
        (np.full((16, 24, 3), 2.5), "or of floats from 0 to 1"),
    ],
)
def test_an_array_is_a_picture_by_a_stated_rule_or_refused(pixels, grey):
    if isinstance(grey, str):
        with pytest.raises(DataError, match=grey):
            from_array(pixels, "a")
    else:
        assert round(np.asarray(from_array(pixels, "a")).mean()) == grey


def test_bytes_of_pictures_in_a_column_of_any_name_are_read_once_it_is_named(tmp_path):
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    Image.fromarray(greys(9)[0]).save(tmp_path / "a.png")
    content = (tmp_path / "a.png").read_bytes()
    columns = {"image": [content, content, b"no picture"], "indenter": ["a", "b", None]}
    pq.write_table(pa.table(columns), tmp_path / "a.parquet")
    with pytest.raises(
        DataError, match="name one with --tac, or the photos alone with --vis.*image"
    ):
        clips_of(tmp_path / "a.parquet")
    out = tmp_path / "out"
    assert (
        imported(tmp_path / "a.parquet", out, "--tac", "image", "--column", "material=indenter")
        == 0
    )
    assert read_pairs(out).modalities() == ("tac",) and [one[1] for one in labels(out)] == [
        "a",
        "b",
    ]


def test_pixels_in_lists_are_pictures_and_a_list_of_them_is_a_film(tmp_path):
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    columns = {"rgb": greys(50).tolist(), "tactile": [[one] for one in greys(150).tolist()]}
    pq.write_table(pa.table(columns), tmp_path / "a.parquet")
    assert imported(tmp_path / "a.parquet", tmp_path / "out") == 0
    assert shown(tmp_path / "out", "vis") == [50, 51, 52, 53]
    assert shown(tmp_path / "out", "tac") == [150, 151, 152, 153]


def test_folders_that_are_named_become_pairs_and_a_half_alone_is_told(tmp_path, capsys):
    for k, name in enumerate(("cam/wood/1.png", "skin/wood/1.png", "skin/wood/2.png")):
        file = tmp_path / "press" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        Image.fromarray(greys(50 * k)[0]).save(file)
    assert imported(tmp_path / "press", tmp_path / "out", "--vis", "cam", "--tac", "skin") == 0
    assert labels(tmp_path / "out") == [("press", "wood", "", "")]
    assert (shown(tmp_path / "out", "vis"), shown(tmp_path / "out", "tac")) == ([0], [50])
    assert "no _vis image beside the other" in capsys.readouterr().out


def test_a_list_of_pictures_in_a_row_is_a_film_of_one_object(tmp_path, capsys):
    """The frames are chosen as those of films are; a shorter list gives what it has."""
    datasets = pytest.importorskip("datasets")
    films = [[Image.fromarray(one) for one in greys(10 * k)[: 4 - k]] for k in range(2)] + [[]]
    features = {"wrist": datasets.Image(), "label": datasets.Value("string")}
    features["tactile"] = datasets.Sequence(datasets.Image())
    rows = {"wrist": [Image.fromarray(greys(90)[k]) for k in range(3)], "label": ["a", "b", "a"]}
    made = datasets.Dataset.from_dict(
        {**rows, "tactile": films}, features=datasets.Features(features)
    )
    made.to_parquet(tmp_path / "a.parquet", batch_size=2)
    for frames, touches in (("2", [1, 3, 11, 12]), ("9", [0, 1, 2, 3, 10, 11, 12])):
        out = tmp_path / frames
        assert imported(tmp_path / "a.parquet", out, "--frames", frames) == 0
        assert shown(out, "tac") == touches
        assert {*shown(out, "vis")} == {90, 91}
        assert {one[2] for one in labels(out)} == {"a 000000", "a 000001"}
    assert "Its list of tac is empty" in capsys.readouterr().out
