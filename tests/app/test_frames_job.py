"""The map's frames as a job: shown early, cached, retried and cancelled."""

from dataclasses import replace
from threading import Event

import numpy as np
import pytest
import torch

from app.shared import frames_job
from app.shared.frames_job import cache_name
from app.shared.places import head_in
from app.shared.resources import Resources, Shared
from omnivat.cli import main
from omnivat.data.store import load_embeddings, save_embeddings
from omnivat.head.checkpoint import load_head
from omnivat.maps.frames import read_frames


@pytest.fixture
def new(small_places):
    """Return a function that makes a new job for the frames of the small set."""
    shared = Shared()
    yield lambda **more: Resources(replace(small_places, **more), shared, owner="own").frames
    shared.close()


@pytest.fixture(autouse=True)
def few_stops(monkeypatch, tmp_path):
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "cache"))
    # the learned order lies outside, so that no stop is added at it
    monkeypatch.setattr(frames_job, "STOPS", (0.0, 0.1, 0.2))
    monkeypatch.setattr(frames_job, "COARSE", (0.0, 0.2))
    monkeypatch.setattr("omnivat.maps.frames.builder.DEFAULT_MAPS", {"pca/f_hat": 3})


@pytest.fixture
def other_encoder(make_embeddings, tmp_path):
    """Return a folder as `omnivat try` writes it: the same pairs in another order, by another
    encoder, and a head.
    """
    found = make_embeddings(width=20, seed=1)
    found = replace(found, header=replace(found.header, encoder="other-encoder"))
    folder = tmp_path / "other"
    folder.mkdir()
    save_embeddings(folder / "set.safetensors", found.select(np.arange(len(found))[::-1]))
    few = ["--set", "width=16", "--set", "epochs=2"]
    where = ["--embeddings", str(folder / "set.safetensors"), "--out", str(folder / "head")]
    assert main(["train", *where, "--source", "TAG-sim", *few]) == 0
    return folder


@pytest.fixture
def building(monkeypatch):
    """Return a function: `before` is called with the options of each map that is built."""
    import omnivat.maps.frames

    whole = omnivat.maps.frames.build_frames

    def watch(before, **instead):
        def built(*arguments, **options):
            before(options)
            return whole(*arguments, **{**options, **instead})

        monkeypatch.setattr(omnivat.maps.frames, "build_frames", built, raising=False)

    return watch


def test_frames_are_computed_once_and_kept_where_the_cache_was_named(new, tmp_path, building):
    built = []
    building(built.append)
    state = new().wait()
    assert state.problem == ""
    assert state.file.parent == tmp_path / "cache" / "frames"
    assert new().wait() == state and len(built) == 2
    assert read_frames(state.file).orders == (0.0, 0.1, 0.2)


def test_a_cache_that_cannot_be_written_costs_time_and_not_frames(new, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "file" / "cache"))
    made = (job := new()).wait()
    assert made.file.parent == job._of.shared.scratch.folder("maps") and not made.problem
    assert read_frames(made.file).orders


def test_one_stop_is_exactly_the_learned_order(new, resources, monkeypatch):
    monkeypatch.setattr(frames_job, "STOPS", (0.0, 0.25, 1.0))
    learned = resources.head().model.order
    frames = read_frames(new().wait().file)
    assert learned in frames.orders
    assert frames.head["learned_order"] == learned
    assert None not in frames.curves["accuracy/unseen"]


def test_the_coarse_map_is_shown_before_the_fine_one_makes_a_step(new, building):
    seen, go = Event(), Event()
    building(lambda options: len(options["orders"]) < 3 or (seen.set(), go.wait(300)))
    job = new()
    job.state()
    assert seen.wait(300)
    state = job.state()
    assert read_frames(state.file).orders == (0.0, 0.2)
    assert state.step is not None
    go.set()
    assert read_frames(job.wait().file).orders == (0.0, 0.1, 0.2)


def test_a_damaged_file_is_made_again(new):
    file = new().wait().file
    good = file.read_bytes()
    file.write_bytes(good[:-9])
    assert new().wait().file == file
    assert file.read_bytes() == good


def test_the_name_changes_with_the_part_of_the_set_the_version_of_the_file_and_the_recipe(
    small_places, monkeypatch
):
    files = small_places.head, small_places.embeddings
    names = {cache_name(*files, part) for part in (0, 20_000)}
    monkeypatch.setattr("omnivat.maps.frames.file.VERSION", 99)
    names.add(cache_name(*files, 0))
    monkeypatch.setattr(frames_job, "RECIPE", 99)
    names.add(cache_name(*files, 0))
    assert len(names) == 4


def test_a_compared_head_of_another_encoder_draws_the_same_pairs_by_the_set_beside_it(
    small_places, other_encoder
):
    where = replace(small_places, compare=(head_in(other_encoder),))
    resources = Resources(where, Shared(), owner="own")
    (name,) = set(resources.frame_jobs) - {""}
    state = resources.frame_jobs[name].wait()
    assert (name, state.problem) == (other_encoder.name, "")
    made, page = read_frames(state.file), resources.embeddings()
    own = load_embeddings(other_encoder / "set.safetensors")
    rows = [own.rows["vis"].index(text) for text in page.rows["vis"]]
    vis, tac = (torch.from_numpy(np.array(part[rows])) for part in (own.vis, own.tac))
    with torch.inference_mode():
        right = load_head(other_encoder / "head").model(vis, tac, order=0.1).reading("fused")
    assert rows != sorted(rows) and made.embeddings["encoder"] == "other-encoder"
    assert (made.prediction[1] == right.argmax(1).numpy()).all()
    save_embeddings(other_encoder / "set.safetensors", own.select(np.arange(9)))
    again = Resources(where, resources.shared, owner="own").frame_jobs[name].wait()
    assert "do not hold the same pairs" in again.problem
    resources.shared.close()


def test_a_failure_is_told_and_tried_again_after_a_while_and_not_at_once(new, monkeypatch):
    tried = []

    def fails(*_):
        tried.append(1)
        raise UnicodeEncodeError("utf-8", "\udc80", 0, 1, "surrogate")

    job = new()
    with monkeypatch.context() as patched:
        patched.setattr(frames_job, "cache_name", fails)
        assert all(job.wait().problem.endswith(".") for _ in range(20))
    assert len(tried) == 1
    monkeypatch.setattr(frames_job, "RETRY_S", 0.0)
    job.state()
    assert job.wait().file is not None


def test_a_map_that_waits_says_its_place(new):
    go, there = Event(), Event()
    job = new()
    job._of.shared.jobs.start(
        lambda _: (there.set(), go.wait(300)), lane="long", owner="other", priority=-1
    )
    there.wait(300)
    assert "number 1 in the queue" in job.state().step.text
    go.set()
    assert job.wait().file is not None


def test_a_cancelled_map_writes_nothing(new, tmp_path, building):
    seen, go = Event(), Event()
    building(lambda _: (seen.set(), go.wait(300)))
    job = new(computed=tmp_path)
    job.state()
    assert seen.wait(300)
    job._of.shared.jobs.cancel_owner("own")
    go.set()
    assert "cancelled" in job.wait().problem
    assert not [*tmp_path.glob("*.bin")]


def test_a_large_set_is_first_shown_by_its_principal_components_alone(new, monkeypatch, building):
    monkeypatch.setattr(frames_job, "LARGE_SET", 10)
    both = {"pca/f_hat": 3, "umap/f_hat": 3}
    monkeypatch.setattr("omnivat.maps.frames.builder.DEFAULT_MAPS", both)
    seen = []
    building(seen.append, maps={"pca/f_hat": 3})
    assert new().wait().problem == ""
    assert len(seen[0]["orders"]) == 2
    kinds = [{name.split("/")[0] for name in options["maps"]} for options in seen]
    assert kinds == [{"pca"}, {"pca", "umap"}, {"pca", "umap"}]
