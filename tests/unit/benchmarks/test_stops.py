"""A command that is ended at any moment and run again makes the bytes of an undisturbed run."""

from random import Random

import numpy as np
import pytest

from benchmarks.stops import COMMANDS, SIGNALS, disturbed, made_in
from omnivat.kit.files import write_json


@pytest.mark.slow
def test_an_import_that_is_ended_and_run_again_makes_the_same_bytes(tmp_path):
    rows = np.random.default_rng(0).random((300, 16)).astype("f4")
    np.savez(tmp_path / "v.npz", vis=rows, tac=rows, material=["wood", "steel"] * 150)
    names = {"vectors": tmp_path / "v.npz"}
    found = list(disturbed("import", names, Random(1), len(SIGNALS)))
    assert [faults for _, faults in found] == [[]] * len(SIGNALS)


def test_other_bytes_are_seen_and_figures_of_time_are_not(tmp_path):
    hashes = [
        write_json(tmp_path / "a.json", {"seconds": k, "right": right}) or made_in(tmp_path)
        for k, right in ((1, 0.5), (2, 0.5), (2, 0.6))
    ]
    assert hashes[0] == hashes[1] != hashes[2]
    assert all("{out}" in words for words in COMMANDS.values())
