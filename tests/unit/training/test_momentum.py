"""SGD with momentum: the same steps as torch's, without its compiler."""

import subprocess
import sys

import torch

from omnivat.training.momentum import Momentum

SHAPES = ((5,), (7, 33), (1000,), ())


def parameters():
    generator = torch.Generator().manual_seed(1)
    kinds = (torch.float32,) * 3 + (torch.float64,)
    return [
        torch.randn(s, generator=generator, dtype=kind).requires_grad_() for s, kind in zip(SHAPES, kinds, strict=True)
    ]


def groups(ours, **more):
    return [{"params": ours[:2], "weight_decay": 1e-3, **more}, {"params": ours[2:], "weight_decay": 0.0, **more}]


def test_steps_equal_those_of_torch_to_the_bit():
    theirs, ours = parameters(), parameters()
    optimisers = torch.optim.SGD(groups(theirs), lr=0.1, momentum=0.9, fused=True), Momentum(groups(ours, lr=0.1), 0.9)
    for k in range(20):
        for one, other in zip(theirs, ours, strict=True):
            one.grad = torch.randn(one.shape, generator=torch.Generator().manual_seed(k), dtype=one.dtype)
            other.grad = one.grad.clone()
        for optimiser in optimisers:
            for group in optimiser.param_groups:
                group["lr"] = 0.1 / (k + 1)
            optimiser.step()
    assert all(torch.equal(one, other) for one, other in zip(theirs, ours, strict=True))


def test_a_parameter_without_gradient_stays_and_takes_its_first_gradient_whole():
    ours = parameters()
    before = [one.detach().clone() for one in ours]
    optimiser = Momentum(groups(ours, lr=0.5), 0.9)
    ours[0].grad = torch.ones(5)
    optimiser.step()
    assert all(torch.equal(one, other) for one, other in zip(ours[1:], before[1:], strict=True))
    ours[2].grad = torch.ones(1000)
    optimiser.step()
    assert torch.allclose(ours[2], before[2] - 0.5)
    assert set(optimiser.buffers) == {ours[0], ours[2]}


def test_a_training_does_not_load_torchs_compiler():
    code = (
        "import sys, torch; from omnivat.training.momentum import Momentum;"
        "x = torch.zeros(3, requires_grad=True); x.sum().backward();"
        "Momentum([{'params': [x], 'weight_decay': 0.0, 'lr': 0.1}], 0.9).step();"
        "print('torch._dynamo' in sys.modules, x.tolist()[0])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split()[0] == "False"
    assert abs(float(done.stdout.split()[1]) + 0.1) < 1e-6
