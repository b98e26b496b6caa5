"""The programs of a page without a server give what the library computes."""

import numpy as np
import pytest
import torch

from omnivat.head.ridge import sharpness
from omnivat.head.teach import Lesson, Work, taught

from .test_cases import CASES

pytest.importorskip("onnx", reason="the extra [onnx] is not installed")
runtime = pytest.importorskip("onnxruntime", reason="the extra [onnx] is not installed")
pytest.importorskip("onnxscript", reason="the extra [onnx] is not installed")

from app.pictures import STEPS, hidden, over_cells  # noqa: E402
from app.site_programs import programs, write_programs  # noqa: E402
from omnivat.head.checkpoint import load_head  # noqa: E402
from omnivat.head.output import READINGS  # noqa: E402
from omnivat.maps.projection.neighbours import place  # noqa: E402

pytestmark = pytest.mark.slow  # an export takes seconds
close = np.testing.assert_allclose


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Return what runs a program by its name."""
    folder = tmp_path_factory.mktemp("programs")
    write_programs(folder)
    options = {"providers": ["CPUExecutionProvider"]}
    sessions = {
        name: runtime.InferenceSession(folder / f"{name}.onnx", **options) for name in programs()
    }

    def results(name, *given):
        kinds = {"tensor(float)": "f4", "tensor(double)": "f8", "tensor(uint8)": "u1"}
        inputs = zip(sessions[name].get_inputs(), given, strict=True)
        return sessions[name].run(
            None, {one.name: np.asarray(value, kinds[one.type]) for one, value in inputs}
        )

    return results


def statistics(mean, variance, count):
    return mean, variance, count


@pytest.mark.parametrize("case", CASES["moved"])
def test_a_row_is_moved_as_the_table_has_it(run, case):
    both = (*statistics(**case["target"]), *statistics(**case["source"]))
    close(run("move", case["row"], *both, case["step"])[0], case["moved"], atol=1e-5)


@pytest.mark.parametrize("case", CASES["joined"])
def test_statistics_join_as_the_table_has_it(run, case):
    found = run("join", *statistics(**case["one"]), *statistics(**case["other"]))
    for values, wanted in zip(found, statistics(**case["joined"]), strict=True):
        close(values, wanted, rtol=1e-6)


@pytest.mark.parametrize("case", CASES["familiarity"])
def test_an_image_is_as_familiar_as_the_table_has_it(run, case):
    found = run("look", case["row"], case["rows"], case["quantiles"])
    close(found, [case["cosine"], case["quantile"]], atol=1e-5)


@pytest.mark.parametrize("count", [2, 9, 25, 60])
def test_quantiles_of_labelled_pictures_leave_out_the_picture_itself(run, count):
    rows = np.random.default_rng(count).normal(size=(count, 16))
    units = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    cosines = np.sort(units @ units.T - 2 * np.eye(count), axis=1)
    wanted = np.sort(cosines[:, -max(1, count // 10) :].mean(1))
    close(run("among", rows)[0], wanted, atol=1e-6)


def test_a_row_lies_between_its_neighbours_or_on_its_own_point(run):
    points, flat = torch.randn(50, 6).double(), torch.randn(50, 2).double()
    for query in (torch.randn(6).double(), points[3]):
        index, share = run("place", query, points)
        near = torch.from_numpy(share) @ flat[index]
        # the points come in single precision
        close(near, place(query[None], points.float().double(), flat)[0], atol=1e-6)


def test_attention_is_in_signed_bytes_of_its_largest_distance_from_even(run):
    weights = np.random.default_rng(0).dirichlet(np.ones(5), 60).reshape(1, -1).astype("f4")
    coded, scale = run("attention", weights, 0.2)
    assert scale == pytest.approx(np.abs(weights - 0.2).max())
    close(coded / 127 * scale, weights - 0.2, atol=0.51 * scale / 127)
    assert run("attention", [[0.5, 0.5]], 0.5)[1] == 1  # there is no distance to divide by


def test_parts_are_hidden_and_their_falls_averaged_as_the_server_does(run):
    picture, colour = torch.randint(255, (1, 71, 45, 3)), torch.tensor([[[[1, 2, 3]]]])
    close(run("parts", picture, colour)[0], hidden(picture, colour))
    falls = torch.rand(STEPS**2)
    close(run("drops", falls)[0], over_cells(falls), atol=1e-6)


@pytest.mark.parametrize("missing", ["", "vis", "tac"])
def test_a_taught_head_reads_as_the_library_reads(run, missing, head_folder):
    head = load_head(head_folder)
    random = torch.Generator().manual_seed(0)
    pairs = torch.randn(2, 6, 1, head.settings.input_width, generator=random)
    images = {"vis": pairs[0], "tac": pairs[1]}
    if missing:
        images[missing] = [None] * 6  # of all but the first
        images[missing][0] = pairs[0, 0]
    labels = [*head.settings.classes[:2], "cork"] * 2
    lessons = [
        Lesson(label=label, vis=vis, tac=tac)
        for label, vis, tac in zip(labels, images["vis"], images["tac"], strict=True)
    ]
    wanted = taught(head, lessons)
    classes = wanted.settings.classes
    there = [[float(one.vis is not None), float(one.tac is not None)] for one in lessons]

    def read(vis, tac):
        """Return the head's readings and rows of pairs of both images."""
        out = head.model(vis, tac)
        rows = [head.model.standing(*one) for one in (("vis", vis), ("tac", tac))]
        return {name: out.reading(name) for name in READINGS}, rows

    # a missing image is of zeros, and only the readings of the other one count
    zeros = torch.zeros(1, head.settings.input_width)
    whole = [torch.cat([zeros if one is None else one for one in some]) for some in images.values()]
    shown, rows = read(*whole)
    targets = np.array([[label == name for name in classes] for label in labels])
    *maps, share, _, _ = run(
        "lessons", *(shown[name] for name in ("fused", "vis", "tac")), *rows, there, targets
    )
    assert share == pytest.approx(wanted.provenance["head_share"], abs=1e-5)
    vis, tac = torch.randn(2, 3, head.settings.input_width, generator=random)
    before, rows = read(vis, tac)
    found = run("taught", *before.values(), *rows, *maps)
    out = wanted.model(vis, tac)
    for name, values in zip(READINGS, found, strict=True):
        close(values, out.reading(name), atol=3e-5, err_msg=name)


@pytest.mark.parametrize(("count", "classes", "width"), [(4, 2, 4), (11, 4, 6), (60, 9, 128)])
@pytest.mark.parametrize("said", ["guesses", "is right", "is wrong"])
def test_lessons_teach_in_the_graph_what_the_library_solves(run, count, classes, width, said):
    random = np.random.default_rng(count)
    work = Work.__new__(Work)  # of plain numbers, in place of a head's rows and predictions
    work.labels = np.concatenate((np.arange(classes), random.integers(0, classes, count - classes)))
    work.rows = random.normal(size=(count, width)) + 3 * np.eye(classes, width)[work.labels]
    work.rows /= np.linalg.norm(work.rows, axis=1, keepdims=True)
    work.before = random.dirichlet(np.ones(classes), count)
    if said != "guesses":
        work.before = np.eye(classes)[(work.labels + (said == "is wrong")) % classes]
    # as the program gets them
    work.rows, work.before = (x.astype("f4").astype(float) for x in (work.rows, work.before))
    work.objects = [np.array([k]) for k in range(count)]
    work.lessons, work.classes = list(work.labels), tuple(range(classes))
    solved = work.ridge(slice(None), work.objects)
    share = solved.share(work.objects)
    factor = sharpness(solved.apart(share), work.labels)
    weights = factor * solved.weights(share)
    maps = weights.T @ work.rows, weights.sum(0), factor * share
    wanted = *maps, share, work.before.argmax(1), work.after()
    halves = np.split(work.rows, 2, axis=1)
    targets = np.eye(classes)[work.labels]
    found = run("lessons", *[work.before] * 3, *halves, np.ones((count, 2)), targets)
    for one, value in zip(found, wanted, strict=True):
        close(one, value, atol=1e-6, rtol=1e-6)
