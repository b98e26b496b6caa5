"""The Ray engine on a local cluster of two workers, one of which is killed half-way."""

import importlib.util
import json
import os
import subprocess
import sys

import pytest

from omnivat.data.readers import read_pairs
from omnivat.kit.errors import MissingPackageError

from .small_pairs import embed, make_pairs

HAS_RAY = importlib.util.find_spec("ray") is not None

# A lost machine is noticed after a second or two instead of a quarter of a minute, and workers do
# not
# stand back for whatever else runs, as Ray has it: on a busy machine they would start for minutes.
QUICK = {
    "RAY_worker_niceness": "0",
    "RAY_health_check_initial_delay_ms": "0",
    "RAY_health_check_period_ms": "500",
    "RAY_health_check_timeout_ms": "2000",
    "RAY_health_check_failure_threshold": "3",
    "RAY_USAGE_STATS_ENABLED": "0",
}

# Ray warns of its own affairs and logs a great deal, so it runs in a process of its own.
SCRIPT = """
import json, sys
from pathlib import Path
import ray
from ray.cluster_utils import Cluster
from omnivat.encoders.embed import job
job.CHUNK = 4
from omnivat.data.readers import read_pairs
from omnivat.encoders.embed import embed_pairs

folder, kill_at = Path(sys.argv[1]), int(sys.argv[2])
# the head is one of the two workers: a node less to start; the other is the one to be killed
cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
workers = [cluster.head_node, cluster.add_node(num_cpus=1)]
ray.init(address=cluster.address, log_to_driver=False)
seen = []

def on_step(step):
    seen.append(step.done)
    if step.done >= kill_at and len(workers) == 2:
        cluster.remove_node(workers.pop(), allow_graceful=False)

report = embed_pairs(
    read_pairs(folder / "pairs"), "efficientnet-lite0", folder / "ray.safetensors",
    engine="ray", workers=2, on_step=on_step,
)
lost = 2 - len(workers)
ray.shutdown()
cluster.shutdown()
print(json.dumps({"embedded": report.embedded, "skipped": len(report.skipped), "lost": lost,
                  "steps": seen}))
"""


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.skipif(not HAS_RAY, reason="ray is not installed: pip install 'ray[data]'")
def test_with_one_of_two_workers_killed_nothing_is_lost_doubled_or_changed(tmp_path):
    make_pairs(tmp_path / "pairs", 40, bad=(5,))
    local = embed(read_pairs(tmp_path / "pairs"), tmp_path / "local.safetensors")
    command = [sys.executable, "-c", SCRIPT, str(tmp_path), "16"]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, env={**os.environ, **QUICK}
    )
    assert done.returncode == 0, done.stderr[-3000:]
    said = json.loads(done.stdout.strip().splitlines()[-1])
    assert said["lost"] == 1
    assert (said["embedded"], said["skipped"]) == (39, 1)
    assert said["steps"][-1] == 40
    assert (tmp_path / "ray.safetensors").read_bytes() == local.out.read_bytes()


def test_without_ray_the_engine_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(MissingPackageError, match=r"pip install 'ray\[data\]'"):
        embed(make_pairs(tmp_path, 6), tmp_path / "a.safetensors", engine="ray")
