"""Commands on a local Ray cluster of two workers give the results of one machine."""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from omnivat.cli import main
from omnivat.data.store import save_embeddings
from omnivat.study.protocol import records

needs_ray = pytest.mark.skipif(importlib.util.find_spec("ray") is None, reason="needs ray")
ROOT = Path(__file__).resolve().parents[3]

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


def on_two_workers(words):
    environ = {**os.environ, **QUICK, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, *words, "--engine", "ray"],
        capture_output=True,
        text=True,
        timeout=180,
        env=environ,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]


@pytest.mark.slow
@needs_ray
@pytest.mark.long
def test_two_workers_give_the_curves_of_one_machine(head_folder, tmp_path):
    assert main(asked(head_folder, "--json", tmp_path / "here.json")) == 0
    on_two_workers(asked(head_folder, "--json", tmp_path / "ray.json"))
    here, far = (json.loads((tmp_path / f"{n}.json").read_text()) for n in ("here", "ray"))
    assert far["curves"].keys() == here["curves"].keys()
    for name, values in here["curves"].items():
        assert far["curves"][name] == pytest.approx(values, abs=1e-5), name


@pytest.mark.long
@pytest.mark.slow
@needs_ray
def test_two_workers_give_the_records_of_one_machine(make_embeddings, tmp_path):
    file = tmp_path / "set.safetensors"
    save_embeddings(file, make_embeddings(domains=("A-sim", "B-sim"), split=True))
    small = ("--methods", "omnivat,nearest_mean", "--set", "width=16", "--set", "epochs=1")

    def protocol(out):
        words = (
            "protocol",
            "--embeddings",
            file,
            *small,
            "--seeds",
            "0,1",
            "--out",
            tmp_path / out,
        )
        return [str(word) for word in words]

    assert main(protocol("here")) == 0
    on_two_workers(protocol("far"))
    here, far = (
        {record["key"]: record for record in records.read(tmp_path / out / "runs.jsonl")}
        for out in ("here", "far")
    )
    assert len(here) == 8  # two methods, two sources, two seeds
    assert far.keys() == here.keys()
    for key, record in here.items():
        assert without_time(far[key]) == without_time(record)


def without_time(record):
    return {name: value for name, value in record.items() if name != "seconds"}
