"""What all tests share: Hypothesis profiles, and small sets and heads made on the spot."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

# The same examples in every run, and no limit on time; `--hypothesis-profile=search` draws others.
EVERY = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow]}
settings.register_profile("same", derandomize=True, max_examples=40, **EVERY)
settings.register_profile("search", max_examples=300, **EVERY)
settings.load_profile("same")


def pytest_collection_modifyitems(config, items):
    """Mark browser tests as slow; run tests that start an event loop first: the browser keeps one.

    Tests marked as long run with `-m long` alone.
    """
    items.sort(key=lambda item: not item.nodeid.startswith("tests/app/"))
    if "long" not in config.option.markexpr:
        long = [item for item in items if item.get_closest_marker("long")]
        config.hook.pytest_deselected(items=long)
        items[:] = [item for item in items if item not in long]
    for item in items:
        if item.get_closest_marker("browser"):
            item.add_marker("slow")


@pytest.fixture(scope="session")
def clips():
    """Return the maker of small CLIPs in each layout; skips where transformers is not installed."""
    pytest.importorskip("transformers")
    file = Path(__file__).parent / "unit" / "encoders" / "clips.py"
    spec = importlib.util.spec_from_file_location("small_clips", file)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def paint():
    """Return a function that writes a picture of noise, another one for each name and folder."""
    from PIL import Image

    def write(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        random = np.random.default_rng([*"/".join(path.parts[-4:]).encode()])
        Image.fromarray(random.integers(0, 256, (32, 32, 3), dtype=np.uint8)).save(path)

    return write


@pytest.fixture(scope="session")
def presses():
    """Return a reader of real frames: "gelsight" or "gelsight_mini" -> the no-contact picture, and
    presses of a ball.

    Pictures are (H, W, 3) bytes. They are those that the package `taxim` carries (MIT).
    """
    found = importlib.util.find_spec("taxim")  # its code is not run
    if found is None or not found.submodule_search_locations:
        pytest.skip("taxim is not installed")
    folder = Path(found.submodule_search_locations[0]) / "calib"

    def read(name):
        with np.load(folder / name / "dataPack.npz") as data:
            return data["f0"], list(data["imgs"])

    return read


@pytest.fixture
def two_threads():
    """Give torch two threads, whatever the machine has."""
    import torch

    before = torch.get_num_threads()
    torch.set_num_threads(2)
    yield
    torch.set_num_threads(before)


@pytest.fixture(scope="session")
def make_embeddings():
    """Return a maker of small, learnable embeddings: classes are directions, domains are shifts."""
    from tests.builders import CLASSES, embeddings_of

    def make(
        *,
        domains=("TAG-sim", "OF Real-sim"),
        per_class=8,
        width=24,
        seed=0,
        classes=CLASSES,
        split=False,
    ):
        random = np.random.default_rng(seed)
        directions = 3 * random.normal(size=(len(classes), width))
        shifts = random.normal(size=(len(domains), 2, width))
        domain = np.repeat(np.arange(len(domains)), per_class * len(classes))
        label = np.tile(np.repeat(np.arange(len(classes)), per_class), len(domains))
        noise = random.normal(size=(4, len(label), width))
        vis, tac, vis_flip, tac_flip = (
            (directions[label] + shifts[domain, m % 2] + noise[m]).astype(np.float32)
            for m in range(4)
        )
        names = [
            f"{domains[d]}/{classes[c]}/{i}"
            for i, (d, c) in enumerate(zip(domain, label, strict=True))
        ]
        rows = {
            "vis": [name + "_vis.png" for name in names],
            "tac": [name + "_tac.png" for name in names],
            "object": [f"{name.rsplit('/', 1)[0]}/{i // 2}" for i, name in enumerate(names)],
            "split": [("train", "test")[i // 2 % 2] if split else "" for i in range(len(names))],
        }
        flips = {"vis_flip": vis_flip, "tac_flip": tac_flip}
        return embeddings_of(
            vis, tac, domain, label, domains=domains, classes=classes, rows=rows, **flips
        )

    return make


@pytest.fixture(scope="session")
def without_classes():
    """Return a function of embeddings and a count that takes the last classes from their pairs."""
    from dataclasses import replace

    def without(embeddings, count):
        known = embeddings.header.classes[: len(embeddings.header.classes) - count]
        header = replace(embeddings.header, classes=(*known, "unlabelled"))
        return replace(embeddings, header=header, label=np.minimum(embeddings.label, len(known)))

    return without


@pytest.fixture(scope="session")
def head_folder(make_embeddings, tmp_path_factory):
    """Return the folder of a small head, trained for two epochs on made-up embeddings."""
    from omnivat.cli import main
    from omnivat.data.store import save_embeddings

    folder = tmp_path_factory.mktemp("head")
    save_embeddings(folder / "set.safetensors", make_embeddings())
    code = main(
        [
            "train",
            "--embeddings",
            str(folder / "set.safetensors"),
            "--source",
            "TAG-sim",
            "--out",
            str(folder / "head"),
            "--set",
            "width=16",
            "--set",
            "epochs=2",
        ]
    )
    assert code == 0
    return folder / "head"


@pytest.fixture
def fetched(tmp_path: Path) -> Path:
    """Return a folder of touch-and-go as it is fetched: two pairs of pictures made here."""
    from PIL import Image

    from omnivat.data.fetching import fetched_sets

    folder, random = tmp_path / "here" / "touch-and-go", np.random.default_rng(0)
    rows = ["vis,tac,domain,material,object"]
    for name in ("brick", "tree"):
        files = [f"{name}_{half}.png" for half in ("vis", "tac")]
        rows.append(",".join([*files, "Touch and Go", name, name]))
        for file in files:
            folder.mkdir(parents=True, exist_ok=True)
            Image.fromarray(random.integers(0, 255, (40, 60, 3), dtype=np.uint8)).save(
                folder / file
            )
    (folder / "pairs.csv").write_text("\n".join(rows))
    commit = fetched_sets()["touch-and-go"].commit
    (folder / "fetched.json").write_text(f'{{"name": "touch-and-go", "commit": "{commit}"}}')
    return folder
