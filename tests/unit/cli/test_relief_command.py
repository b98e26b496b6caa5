"""`--touch relief` from pictures to a prediction: lamps, heads and sets that fit, what is named."""

import json
from contextlib import redirect_stdout
from functools import cache
from io import StringIO
from shutil import copytree

import numpy as np
import pytest

from omnivat import EXAMPLES, load_embeddings
from omnivat.cli import main

pytestmark = pytest.mark.slow
ALONE = "the lamps that each touch gives alone"
KNOWN = "lamps from 8 touches of the profile"
GELS = ("TQ-DIGIT-sim", "TQ-GelMini-sim")
TRAINED = ("--source", "TQ-DIGIT-sim", "--set", "width=16", "--set", "epochs=3")


@pytest.fixture(scope="module")
def work(tmp_path_factory):
    """Shipped pairs of two gels, and two pairs of a third."""
    root = tmp_path_factory.mktemp("relief")
    for name in GELS:
        copytree(EXAMPLES / "pairs" / name, root / "pairs" / name)
    copytree(EXAMPLES / "pairs" / "TAG-sim" / "glass", root / "pairs" / "few" / "glass")
    return root


@pytest.fixture(scope="module")
def embedded(work):
    """Return a function of `--touch` that gives what `embed` prints and the file it writes."""

    @cache
    def of(touch):
        out = work / f"{touch}-sides.safetensors"
        with StringIO() as said, redirect_stdout(said):
            words = ["embed", work / "pairs", "--touch", touch, "--no-flips", "--out", out]
            assert main([*map(str, words)]) == 0
            return said.getvalue(), out

    return of


def test_pictures_become_a_head_of_relief_that_reads_a_sensor_by_its_profile(work, embedded, run):
    said, relief = embedded("relief")
    assert "TQ-DIGIT-sim: touch is read as its relief, by lamps from 8 touches (conf" in said
    assert f"few: touch is read as its relief, by {ALONE}. Lamps need 3 pictures of one" in said
    run("train", "--embeddings", relief, *TRAINED, "--out", work / "head")
    record = json.loads(
        run("evaluate", "--head", work / "head", "--embeddings", relief, "--json").out
    )
    assert record["known"] == "nothing: pictures as they come; lamps from up to 8 touches"
    assert {one["domain"]: one["lamps_from"] for one in record["domains"]} == {
        "TQ-DIGIT-sim": 8, "TQ-GelMini-sim": 8, "few": 0,
    }  # fmt: skip

    mini = work / "pairs" / "TQ-GelMini-sim"
    pair = next(mini.glob("glass/*_vis.jpg")), next(mini.glob("glass/*_tac.jpg"))
    base = "predict", *pair, "--no-cache", "--head", work / "head"
    assert f"Touch was read as its relief, by {ALONE}." in run(*base).out
    run("profile", mini, "--out", work / "colours.safetensors")  # it serves heads of both
    both = "--profile", work / "colours.safetensors"
    assert f"Touch was read as its relief, by {KNOWN}" in run(*base, *both).out
    assert "Touch was read" not in run("predict", pair[0], "-", *base[3:], *both).out

    said = run("evaluate", "--head", work / "head", code=1)
    assert "Embed the pairs with --touch relief, or choose a head that fits" in said.err
    said = run("evaluate", "--embeddings", relief, code=1)
    assert "made with touch drawn as its relief" in said.err and "--touch colours" in said.err


def test_a_head_of_colours_and_relief_reads_both_side_by_side_in_a_command_and_on_the_page(
    work, embedded, run
):
    from app.pair.pictures import taken
    from app.pair.sensor import load_sensor
    from app.pair.tab import predicted
    from app.shared.places import Places
    from app.shared.resources import Resources

    said, file = embedded("both")
    both, relief = (load_embeddings(one) for one in (file, embedded("relief")[1]))
    assert "DIGIT-sim: touch is read in its colours and as its relief, by lamps from 8" in said
    assert np.array_equal(np.hsplit(both.tac, 2)[1], relief.tac)
    photo, rest = np.hsplit(both.vis, 2)
    assert np.array_equal(photo, relief.vis) and not rest.any()

    run("train", "--embeddings", file, *TRAINED, "--out", work / "both")
    mini = work / "pairs" / "TQ-GelMini-sim"
    pair = next(mini.glob("glass/*_vis.jpg")), next(mini.glob("glass/*_tac.jpg"))
    base = "predict", *pair, "--no-cache", "--head", work / "both"
    for touch in ("colours", "relief"):
        run("profile", mini, "--out", work / f"{touch}.profile.safetensors", "--touch", touch)
    profile = "--profile", work / "colours.profile.safetensors"
    assert f"in its colours and as its relief, by {KNOWN}" in run(*base, *profile).out
    said = run(*base, "--profile", work / "relief.profile.safetensors", code=1)
    assert "Make the profile with that encoder" in said.err

    sources = {"head": work / "both", "embeddings": file}
    page = Resources(Places(**sources, frames=None, pairs=None))
    sensor = load_sensor(page, profile[1], {})["profile"]
    for name, more in ((None, ()), (sensor, profile)):
        asked = {"profile": name}
        vis, tac = (taken(page, one.read_bytes(), asked)["ref"] for one in pair)
        shown = predicted(page, {"vis": vis, "tac": tac, **asked})["exact"]
        wanted = json.loads(run(*base, *more, "--json").out)["probabilities"]
        assert shown["readings"]["fused"] == pytest.approx([*wanted.values()], abs=1e-4)


def test_lamps_of_a_profile_are_taken_for_its_domain(work, run):
    run(
        "profile",
        work / "pairs" / GELS[0],
        "--out",
        work / "digit.safetensors",
        "--domain",
        "glass",
    )
    few = work / "pairs" / "few"
    base = "embed", few, "--touch", "relief", "--out", work / "known.safetensors"
    said = run(*base, "--no-flips", "--lamps", work / "digit.safetensors")
    assert "glass: touch is read as its relief, by lamps from 8 touches" in said.out
    alone = run(*base[:-1], work / "alone.safetensors", "--no-flips", "--lamps", "alone")
    assert f"Touch is read as its relief, by {ALONE}." in alone.out
    assert load_embeddings(work / "alone.safetensors").header.lit_by == {}
    run("profile", few, "--out", work / "few.safetensors")
    said = run("embed", few, "--out", work / "colours.safetensors", "--lamps", "alone", code=1)
    assert "touch is read in its colours; add --touch relief" in said.err
    said = run(*base, "--lamps", work / "few.safetensors", code=1)
    assert "few.safetensors' holds no lamps; make it again from five touches or more" in said.err
