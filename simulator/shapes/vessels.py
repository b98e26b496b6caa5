"""Vessels: solids of revolution with a wall, a rim and a foot."""

import numpy as np

from simulator.noise import Rng
from simulator.shapes.solid import Made, Profile, Solid, joined, lathed, sawn, swept, turned


def wall(
    foot: float,
    waist: tuple[float, float],
    rim: float,
    height: float,
    *,
    thick: float,
    ring: float = 0.0,
) -> Profile:
    """Return the profile of an open vessel: up outside, over the rim, down inside. All in mm.

    waist  radius and height of the corner between foot and rim
    ring   height of a foot ring; 0 has none
    """
    soft, soft_rim = 0.8 * height, 0.5 * thick
    under = [(foot * 0.82, ring, 0.8), (foot * 0.86, 0.0, 0.8)] if ring else []
    base = max(foot - thick, 2.0)
    return [
        *under, (foot, 0.0, 1.5), (waist[0], waist[1], soft), (rim, height, 0.5 * thick),
        (rim - thick, height, soft_rim), (waist[0] - thick, waist[1] + 0.5 * thick, soft),
        (base, ring + thick, 3.0),
    ]  # fmt: skip


def bowl(rng: Rng, made: Made) -> Solid:
    """Return a bowl, 100 to 170 mm across."""
    rim = rng.uniform(50, 85)
    height, foot = rim * rng.uniform(0.55, 0.9), rim * rng.uniform(0.4, 0.6)
    waist = (rim * rng.uniform(0.82, 1.0), height * rng.uniform(0.12, 0.35))
    ring = rng.choice([0.0, 3.0])
    return lathed(wall(foot, waist, rim, height, thick=made.wall, ring=ring))


def cup(rng: Rng, made: Made) -> Solid:
    """Return a cup without a handle."""
    rim, height = rng.uniform(33, 44), rng.uniform(65, 95)
    foot = rim * rng.uniform(0.65, 0.95)
    waist = (rim * rng.uniform(0.85, 1.02), height * rng.uniform(0.2, 0.5))
    return lathed(wall(foot, waist, rim, height, thick=made.wall))


def mug(rng: Rng, made: Made) -> Solid:
    """Return a cup with a handle."""
    rim, height = rng.uniform(36, 46), rng.uniform(80, 105)
    foot = rim * rng.uniform(0.8, 1.0)
    waist = (rim * rng.uniform(0.97, 1.1), height * rng.uniform(0.2, 0.5))
    body = lathed(wall(foot, waist, rim, height, thick=made.wall))
    angle = np.linspace(-0.55 * np.pi, 0.55 * np.pi, 30)
    reach, tall = rng.uniform(20, 30), height * rng.uniform(0.28, 0.36)
    path = np.stack(
        [rim - 6 + reach * np.cos(angle), 0 * angle, height * 0.52 + tall * np.sin(angle)], axis=1
    )
    half = np.repeat([[rng.uniform(4.5, 7), 1.5 + 0.6 * made.wall]], 30, 0)
    return joined(body, swept(path, half, power=2.5))


def tumbler(rng: Rng, made: Made) -> Solid:
    """Return a drinking glass: tall, straight, sometimes facetted."""
    rim, height = rng.uniform(31, 42), rng.uniform(90, 145)
    foot = rim * rng.uniform(0.72, 0.95)
    waist = ((foot + rim) / 2, height * 0.5)
    power = rng.choice([2.0, 2.0, 3.0])
    return lathed(wall(foot, waist, rim, height, thick=made.wall), power=power)


def plate(rng: Rng, made: Made) -> Solid:
    """Return a plate with a flat well and a raised rim; seen from above, so cut from a block."""
    rim, rise, thick = rng.uniform(80, 130), rng.uniform(12, 24), made.wall
    well = rim * rng.uniform(0.6, 0.72)
    line: Profile = [
        (well * 0.9, 2.0, 1.0), (well * 0.93, 0.0, 1.0), (well, 0.0, 2.0),
        (rim * 0.85, rise * 0.7, 8.0), (rim, rise, thick / 2), (rim - 1.0, rise + thick * 0.7, 2.0),
        (rim * 0.84, rise * 0.7 + thick, 8.0), (well * 0.97, thick + 2.0, 9.0),
    ]  # fmt: skip
    return sawn(lathed(line))


def vase(rng: Rng, made: Made) -> Solid:
    """Return a vase: foot, belly, neck and lip."""
    height = rng.uniform(130, 230)
    belly, neck = height * rng.uniform(0.24, 0.36), height * rng.uniform(0.1, 0.17)
    foot, lip, t = belly * rng.uniform(0.5, 0.75), neck * rng.uniform(1.1, 1.6), min(made.wall, 6.0)
    low, high = height * rng.uniform(0.3, 0.5), height * rng.uniform(0.75, 0.85)
    s = 0.6 * height
    return lathed([
        (foot, 0.0, 2.0), (belly * 1.15, low, s), (neck, high, s),
        (lip, height, t / 2), (lip - t, height, t / 2), (neck - t, high, s),
        (belly * 1.15 - t, low, s), (foot - t, t, 2.0),
    ])  # fmt: skip


def bottle(rng: Rng, made: Made) -> Solid:
    """Return a bottle with shoulders, neck and lip."""
    body, height = rng.uniform(28, 42), rng.uniform(170, 260)
    neck, t = body * rng.uniform(0.32, 0.48), min(made.wall, 4.0)
    shoulder = height * rng.uniform(0.52, 0.68)
    throat = shoulder + (body - neck) * rng.uniform(1.0, 1.8)
    return turned([
        (0.0, 4.0, 0.0), (body * 0.7, 3.0, 3.0), (body * 0.85, 0.0, 2.0), (body, 0.0, 4.0),
        (body, shoulder, 18.0), (neck, throat, 14.0), (neck, height - 8, 1.0),
        (neck + 2.2, height - 8, 1.0), (neck + 2.2, height, 1.2), (neck - t, height, 1.2),
        (neck - t, throat, 14.0), (body - t, shoulder, 18.0), (body - t, 5.0, 4.0),
        (0.0, 6.0, 0.0),
    ])  # fmt: skip


def can(rng: Rng, made: Made) -> Solid:
    """Return a closed tin: rolled rims, beads round the wall."""
    r, h = rng.uniform(30, 50), rng.uniform(60, 120)
    line = [(r - 4, 2.5, 1.0), (r - 2.5, 0.0, 1.0), (r, 0.0, 1.0), (r, 3.0, 0.8)]
    if rng.random() < 0.5:
        beads = np.arange(0.25, 0.76, 0.07) * h
        line += [(r - 1.0 + 0.8 * (k % 2), float(z), 1.5) for k, z in enumerate(beads)]
    line += [(r - 1.0, 4.0, 0.8)] if len(line) == 4 else []
    line += [(r - 1.0, h - 4, 0.8), (r, h - 3, 0.8), (r, h, 1.0), (r - 2.5, h, 1.0)]
    return lathed([*line, (r - 4, h - 3, 1.0)])


def candlestick(rng: Rng, made: Made) -> Solid:
    """Return a turned stem between a broad foot and a socket."""
    foot, height = rng.uniform(35, 55), rng.uniform(110, 210)
    stem, socket = rng.uniform(6, 11), rng.uniform(14, 20)
    line = [(foot, 0.0, 1.5), (foot, 6.0, 2.5), (stem * 1.8, 16.0, 8.0)]
    for share in np.linspace(0.22, 0.75, rng.integers(2, 5)):
        z, bulge = share * height, stem * rng.uniform(1.3, 2.3)
        line += [(stem, z - 9, 5.0), (bulge, z, 6.0), (stem, z + 9, 5.0)]
    line += [(socket, height * 0.86, 4.0), (socket, height, 1.2), (socket - 3, height, 1.0)]
    return lathed([*line, (socket - 4, height * 0.9, 1.0)])
