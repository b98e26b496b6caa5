"""Points that tests of maps share."""

import torch


def noise(*shape, seed=0, dtype=torch.float32):
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed), dtype=dtype)


def clusters(each=40, groups=5, width=16, seed=0):
    """Groups of rows, far apart; and the group of each row."""
    group = torch.arange(groups).repeat_interleave(each)
    return 8 * noise(groups, width, seed=seed)[group] + noise(
        each * groups, width, seed=seed + 1
    ), group
