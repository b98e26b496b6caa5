"""The programs of a page without a server give what the library computes."""

import numpy as np
import pytest
import torch

pytest.importorskip("onnx", reason="the extra [onnx] is not installed")
runtime = pytest.importorskip("onnxruntime", reason="the extra [onnx] is not installed")
pytest.importorskip("onnxscript", reason="the extra [onnx] is not installed")

from app.site.programs import programs, write_programs  # noqa: E402
from omnivat.head.calibration import nearest_cosines, quantile_of  # noqa: E402

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


@pytest.mark.parametrize("count", [9, 30])
def test_an_image_is_as_familiar_as_the_library_has_it(run, count):
    rows, levels = torch.randn(count, 16), torch.linspace(0, 1, 11)
    cosines = nearest_cosines(rows[:1] + 0.5, rows)
    wanted = cosines[0, 0], quantile_of(cosines.mean(1), levels)[0]
    close(run("look", rows[0] + 0.5, rows, levels), wanted, atol=1e-5)


def test_attention_is_in_signed_bytes_of_its_largest_distance_from_even(run):
    weights = np.random.default_rng(0).dirichlet(np.ones(5), 60).reshape(1, -1).astype("f4")
    coded, scale = run("attention", weights, 0.2)
    assert scale == pytest.approx(np.abs(weights - 0.2).max())
    close(coded / 127 * scale, weights - 0.2, atol=0.51 * scale / 127)
    assert run("attention", [[0.5, 0.5]], 0.5)[1] == 1  # there is no distance to divide by
