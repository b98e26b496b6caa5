"""A head as ONNX gives the fast head's readings at any order."""

from functools import partial

import numpy as np
import pytest
import torch

from omnivat.head.checkpoint import Head
from omnivat.head.head import build_head
from omnivat.head.teach import Lesson, taught
from tests.builders import head_settings

pytest.importorskip("onnx", reason="the extra [onnx] is not installed")
runtime = pytest.importorskip("onnxruntime", reason="the extra [onnx] is not installed")
pytest.importorskip("onnxscript", reason="the extra [onnx] is not installed")

from omnivat.head.portable import STAGED, PortableHead, write_head  # noqa: E402
from omnivat.maps.sweep.walk import stage_features  # noqa: E402

pytestmark = pytest.mark.slow  # an export takes seconds
ORDERS = (0.0, 0.31, 1.0, 2.7, -3.99)


def head_of(**changes):
    settings = head_settings(classes=("a", "b", "c"), width=10, **changes)
    model = build_head(settings, seed=3).eval().requires_grad_(False)
    if settings.standardize:
        model.input_mean.normal_()
        model.input_scale.uniform_(0.5, 2)
    if settings.mffa:
        model.mffa.bank.normal_()
        model.mffa.bank_seen.fill_(True)
    model.temperatures = {"fused": 1.3, "vis": 2.9, "tac": 0.7}
    return Head(model=model, encoder={}, provenance={})


def both(orders):
    return torch.tensor([orders, orders], dtype=torch.float64)


def taught_twice(head):
    """Return a head that is taught two classes that it lacks, one after the other."""
    for new in ("d", "e"):
        rows = torch.randn(2, 4, 1, 24)
        lessons = [
            Lesson(label=label, vis=vis, tac=tac)
            for label, vis, tac in zip(("a", "a", new, new), *rows, strict=True)
        ]
        head = taught(head, lessons)
    return head


OTHER = {"complex_to_real": "magnitude", "fusion": "product", "generation": "series"}


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A taught head of moduli and of embeddings as they come, and what runs its file."""
    head = taught_twice(head_of(standardize=False, **OTHER))
    file = tmp_path_factory.mktemp("portable") / "head.onnx"
    write_head(file, head)
    session = runtime.InferenceSession(file, providers=["CPUExecutionProvider"])
    names = [one.name for one in session.get_outputs()]

    def run(vis, tac, orders):
        given = {"vis": vis, "tac": tac, "orders": both(orders)}
        found = session.run(None, {name: value.numpy() for name, value in given.items()})
        return {n: torch.from_numpy(np.asarray(v)) for n, v in zip(names, found, strict=True)}

    return head, run


@pytest.fixture(params=["default", "file"])
def portable(request):
    """A head as it is by default with its graph before the export, or the file of another one."""
    if request.param == "file":
        return request.getfixturevalue("written")
    head = head_of()
    return head, lambda vis, tac, orders: PortableHead(head.model)(vis, tac, both(orders))


def test_a_portable_head_gives_every_reading_of_the_fast_head_at_any_order(portable):
    head, run = portable
    vis, tac = torch.randn(2, 1, 24, generator=torch.Generator().manual_seed(1))
    orders = torch.tensor(ORDERS, dtype=torch.float64)
    found = run(*(row.expand(len(ORDERS), -1) for row in (vis, tac)), ORDERS)
    many = torch.zeros(len(ORDERS), dtype=torch.long)
    for given in ({"vis": vis, "tac": tac}, {"vis": vis, "tac": None}, {"vis": None, "tac": tac}):
        out = head.model.from_coefficients(head.model.coefficients(**given)[many], orders)
        alone = next((name for name in ("vis", "tac") if given[name] is None), "")
        for name, wanted in out.readings.items():
            if name == "fused" and alone:  # one image: the reading of that image
                name = "tac" if alone == "vis" else "vis"
            assert torch.allclose(found[f"p_{name}"], wanted, atol=2e-6), name
        for name, wanted in out.frft.items():
            assert torch.allclose(found[f"{name}_size"], wanted.norm(dim=0), atol=1e-5)


def test_the_stages_and_trees_of_many_pairs_are_those_of_the_fast_head(portable):
    head, run = portable
    vis, tac = torch.randn(2, 5, 24)
    given = run(vis, tac, [0.31] * 5)
    wanted, *alone = (
        head.model(v, t, order=0.31, nodes=True) for v, t in ((vis, tac), (vis, None), (None, tac))
    )
    same = partial(torch.testing.assert_close, atol=1e-5, rtol=1e-4)
    for stage in STAGED:
        for name, rows in stage_features(wanted, stage).items():
            same(given[f"{stage}_{name}"], rows)
    same(given["nodes"], wanted.nodes)
    same(given["shares"], head.model.classify(wanted.nodes).softmax(-1))
    for name, one in zip(("vis", "tac"), alone, strict=True):
        same(given[f"{name}_nodes"], one.nodes)
        same(given[f"{name}_f_hat"], one.f_hat[name])
