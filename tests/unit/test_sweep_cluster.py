"""A sweep on a local Ray cluster of two workers gives the curves of one machine."""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from omnivat.cli import main

ROOT = Path(__file__).resolve().parents[2]

# no statistics; and by itself Ray runs workers after all other work of the machine
QUICK = {"RAY_USAGE_STATS_ENABLED": "0", "RAY_worker_niceness": "0"}

# Ray warns of its own affairs and logs a great deal, so it runs in a process of its own.
SCRIPT = """
import sys
import ray
from ray.cluster_utils import Cluster
cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
cluster.add_node(num_cpus=1)
ray.init(address=cluster.address, log_to_driver=False)
from omnivat.cli import main
code = main(sys.argv[1:])
ray.shutdown()
cluster.shutdown()
sys.exit(code)
"""


def asked(head_folder, *more):
    sweep = ["sweep", "--head", head_folder, "--embeddings", head_folder.parent / "set.safetensors"]
    return [str(word) for word in (*sweep, "--orders", "0,0.3,1", *more)]


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("ray") is None, reason="needs ray")
def test_two_workers_give_the_curves_of_one_machine(head_folder, tmp_path):
    assert main(asked(head_folder, "--json", tmp_path / "here.json")) == 0
    there = asked(head_folder, "--json", tmp_path / "ray.json", "--engine", "ray")
    environ = {**os.environ, **QUICK, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, *there],
        capture_output=True,
        text=True,
        timeout=180,
        env=environ,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    here, far = (json.loads((tmp_path / f"{n}.json").read_text()) for n in ("here", "ray"))
    assert far["curves"].keys() == here["curves"].keys()
    for name, values in here["curves"].items():
        assert far["curves"][name] == pytest.approx(values, abs=1e-5), name


def test_maps_are_not_made_on_a_cluster(head_folder, tmp_path, capsys):
    assert main(asked(head_folder, "--out", tmp_path / "f.bin", "--engine", "ray")) == 1
    assert "without --out" in capsys.readouterr().err
