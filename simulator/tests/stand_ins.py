"""Stand-ins for Mitsuba and Taxim: they note what is to be rendered, and draw patterns of it."""

from types import SimpleNamespace

import numpy as np


class Transform:
    """Notes the steps of a transform."""

    def __init__(self, *steps):
        self.steps = steps

    def __getattr__(self, name):
        return lambda *values, **named: Transform(*self.steps, name, values, named)


class Mitsuba(SimpleNamespace):
    """Keeps every rendered scene; an image is seeded noise."""

    Bitmap = staticmethod(np.asarray)
    Properties = dict
    LogLevel = SimpleNamespace(Error=0)
    ScalarTransform4f = Transform
    load_dict = staticmethod(lambda record: record)
    traverse = staticmethod(lambda shape: shape)
    Mesh = staticmethod(lambda name, **facts: {"name": name, **facts})

    def set_variant(self, name):
        self.rendered = [name]

    def set_log_level(self, level):
        pass

    def render(self, scene, *, spp, seed, integrator=None):
        self.rendered.append((scene, spp, seed, integrator))
        film = scene["sensor"]["film"]
        return np.random.default_rng(seed).random((film["height"], film["width"], 6))


class Taxim:
    """Draws waves of the distance."""

    def __init__(self, *, calib_folder, backend, device):
        self.phase = len(calib_folder)

    def render(self, distance, *, with_shadow, press_depth):
        waves = distance / 10 + with_shadow + (press_depth or 0.0)
        return 0.5 + np.stack([np.sin(waves * k + self.phase) for k in (1, 2, 3)], -1)


def packages():
    """Return modules by name, as in `sys.modules`."""
    names = ("CALIB_GELSIGHT", "CALIB_GELSIGHT_MINI")
    calibrations = {name: name.lower() for name in names}
    return {
        "mitsuba": Mitsuba(),
        "jax": SimpleNamespace(),
        "taxim": SimpleNamespace(Taxim=Taxim, **calibrations),
    }
