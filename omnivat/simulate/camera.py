"""From radiance to a photograph: exposure, white balance, tone, softness, grain."""

import numpy as np
from scipy.ndimage import gaussian_filter

from omnivat.simulate.noise import Array
from omnivat.simulate.scenes import Scene

_GAIN = 2.0  # largest gain for dark pictures


def exposed(radiance: Array, scene: Scene, *, seed: int) -> Array:
    """Return the photograph (H, W, 3), 0 to 1, that the scene's camera takes of `radiance`."""
    rng = np.random.default_rng(seed)
    image = gaussian_filter(radiance, (scene.blur, scene.blur, 0.0), mode="nearest")
    image = image * np.asarray(scene.balance) * (1.0 + scene.drift * rng.normal(size=3))
    bright = float(np.quantile(image.mean(-1), 0.9))
    goal = float(np.clip(scene.goal * rng.uniform(0.85, 1.2), 0.3, 0.9))
    # Automatic exposure is partial: dark things stay darker than bright ones.
    image = image * min((goal / max(bright, 1e-3)) ** 0.8, _GAIN)
    toned = np.clip(image, 0.0, 1.6) / (1.0 + 0.25 * np.clip(image, 0.0, 1.6) ** 2)
    shown = np.clip(toned, 0.0, 1.0) ** (1 / 2.2)
    shown = 0.5 + (shown - 0.5) * scene.contrast
    grain = rng.normal(size=shown.shape) * scene.noise
    return np.asarray(np.clip(shown + grain, 0.0, 1.0))
