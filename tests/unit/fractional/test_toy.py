"""The toy: the transform keeps every distance, the ReLU does not, and one p makes a spike."""

import numpy as np

from omnivat.fractional.toy import SPIKE_ORDER, SPIKES, toy

ORDERS = [k / 20 for k in range(21)]


def test_the_transform_keeps_distances_and_the_relu_makes_them_depend_on_p():
    for apart in toy(ORDERS)["distances"].values():
        assert np.ptp(apart["turned"]) == 0
        assert np.ptp(apart["clipped"]) > 0.2


def test_at_its_own_p_each_signal_is_mostly_one_spike():
    found = toy([0.0, SPIKE_ORDER])
    for place, signal in zip(SPIKES, found["signals"].values(), strict=True):
        size = np.hypot(signal["re"], signal["im"])
        assert size[1].argmax() == place
        assert size[1].max() > 2 * size[0].max()
