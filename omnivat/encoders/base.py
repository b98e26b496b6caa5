"""The contract of an encoder, the table of encoders, their loading, and two encoders as one."""

import importlib
import importlib.util
import inspect
import re
import sys
from collections.abc import Callable, Mapping
from functools import partial
from importlib.metadata import entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, cast

from omnivat.kit.errors import DataError, MissingNameError, SettingsError
from omnivat.kit.tables import load, suggestion

if TYPE_CHECKING:
    import torch
    from PIL import Image

    from omnivat.data.relief import Lamps
    from omnivat.encoders.wrapping import WithoutDots


GROUP = "omnivat.encoders"  # group of entry points of other packages
IMPORTED = "imported:"  # prefix of an encoder that is not available here
HUB = "hf:"  # prefix of a folder or hub name of a transformers model
JOINED = " | "  # separator of the two names, VIS first
# an encoder's name, the kind of sensor, and a layer: "t3@digit#6"
CHOSEN = re.compile(r"(.+?)(?:@([\w .-]+))?(?:#([\w.]+))?")


class PairEncoder:
    """Two encoders: `vis` for photos, `tac` for tactile images.

    If their widths differ, the narrower embeddings are padded with zeros, which changes no length,
    distance or cosine within a modality. The name combines both names, so it can be loaded again.
    """

    vis: "Encoder"
    tac: "Encoder"

    def __init__(self, vis: "Encoder", tac: "Encoder") -> None:
        from omnivat.encoders.wrapping import NamedEncoder

        self.width = max(vis.width, tac.width)
        self.vis, self.tac = (
            encoder
            if encoder.width == self.width
            else NamedEncoder(encoder, encoder.name, self.width)
            for encoder in (vis, tac)
        )
        self.name = JOINED.join((vis.name, tac.name))
        self.weights_hash = JOINED.join((vis.weights_hash, tac.weights_hash))
        self.precision = (
            vis.precision if vis.precision == tac.precision else f"{vis.precision}/{tac.precision}"
        )
        self.preprocessing = f"VIS: {self.vis.preprocessing}; TAC: {self.tac.preprocessing}"

    def preprocess(self, _: Any) -> "torch.Tensor":
        """Refuse: each modality has its own (`for_modality`). Raises DataError."""
        raise DataError(f"'{self.name}' has an encoder for each modality; say which one is meant.")

    embed = preprocess


class DotsFilled(PairEncoder):
    """An encoder of photos as they are and of tactile images without their printed dots."""

    tac: "WithoutDots"

    def __init__(self, inner: "Encoder") -> None:
        from omnivat.data.dots import FILLED
        from omnivat.encoders.wrapping import WithoutDots

        touches, self.plain = for_modality(inner, "tac"), inner
        self.vis, self.tac = for_modality(inner, "vis"), WithoutDots(touches)
        self.one_network = self.vis is touches
        self.name, self.width, self.precision = inner.name, inner.width, inner.precision
        self.weights_hash, self.text_hash = inner.weights_hash, getattr(inner, "text_hash", "")
        self.preprocessing = inner.preprocessing + FILLED


class ReliefDrawn(DotsFilled):
    """An encoder whose tactile images are drawn as their relief.

    lamps  domain -> its lamps; a touch of another domain, as with `tac`, is drawn by itself alone
    touch  "relief", or "both": a touch's embedding in colours is followed by that of its relief,
           and a photo's by as many zeros
    """

    def __init__(
        self, inner: "Encoder", lamps: "Mapping[str, Lamps]", touch: str = "relief"
    ) -> None:
        from omnivat.data.relief.files import MARKS
        from omnivat.encoders.wrapping import NamedEncoder, WithoutDots

        super().__init__(inner.plain if isinstance(inner, DotsFilled) else inner)
        self.preprocessing += MARKS[touch]
        self.touch, touches = touch, self.tac.inner
        self.tac = WithoutDots(touches, touch=touch)
        self.of = {name: WithoutDots(touches, own, touch=touch) for name, own in lamps.items()}
        if self.tac.width > self.width:
            self.width, self.one_network = self.tac.width, False
            self.vis = NamedEncoder(self.vis, self.vis.name, self.width)
            self.text_hash = ""  # texts are not of this width


def for_modality(encoder: "Encoder", modality: str, domain: str = "") -> "Encoder":
    """Return the encoder for "vis" or "tac"; a single encoder serves both.

    domain  of a tactile image, whose lamps draw its relief
    """
    if not isinstance(encoder, PairEncoder):
        return encoder
    if modality == "vis":
        return encoder.vis
    return encoder.of.get(domain, encoder.tac) if isinstance(encoder, ReliefDrawn) else encoder.tac


def made_by(encoder: "Encoder") -> tuple[str, ...]:
    """Return what an embedding depends on beside its image, for caches and unfinished files."""
    if isinstance(encoder, PairEncoder):
        drawn = encoder.of if isinstance(encoder, ReliefDrawn) else {}
        lit = (part for name, drawing in drawn.items() for part in (name, *made_by(drawing)))
        return *made_by(encoder.vis), *made_by(encoder.tac), *lit
    probe = getattr(encoder, "probe", "")
    return encoder.name, encoder.weights_hash, encoder.precision, encoder.preprocessing, probe


DEFAULT_ENCODER = "efficientnet-lite0"
ENCODERS = {
    "efficientnet-lite0": "omnivat.encoders.efficientnet:load_lite0",
    "clip-vit-b32": "omnivat.encoders.clip_towers:load",
    "clip-vit-b16": "omnivat.encoders.clip_towers:load",
    "clip-vit-l14": "omnivat.encoders.clip_towers:load",
    "clip-vit-l14-336": "omnivat.encoders.clip_towers:load",
    "clip-rn50": "omnivat.encoders.clip_towers:load",
    "clip-rn101": "omnivat.encoders.clip_towers:load",
    "clip": "omnivat.encoders.clip_towers:load",
    "sitr": "omnivat.encoders.sitr:load",
    "sparsh": "omnivat.encoders.tactile:load_sparsh",
    "t3": "omnivat.encoders.tactile:load_t3",
    "anytouch2": "omnivat.encoders.tactile:load_anytouch2",
    "strip": "omnivat.encoders.strip:StripReader",
}


class Encoder(Protocol):
    """An image encoder with frozen weights.

    name            its name for `load_encoder`
    width           D, the length of an embedding
    preprocessing   a description of the preprocessing, also written to file headers
    weights_hash    a hash of the weights
    precision       "fp32", "bf16" or "fp32-onnx", for computation; embeddings are float32

    An encoder with a text tower also has `text_hash`, a hash of the tower's weights.
    """

    name: str
    width: int
    preprocessing: str
    weights_hash: str
    precision: str

    def preprocess(self, image: "Image.Image") -> "torch.Tensor":
        """Convert an RGB image to the (C, H, W) float32 tensor for `embed`."""
        ...

    def embed(self, images: "torch.Tensor") -> "torch.Tensor":
        """Return the embeddings (B, D), float32, of preprocessed images (B, C, H, W).

        An image has the same embedding, to the last bit, alone and in any batch.
        """
        ...


def load_encoder(
    name: str,
    *,
    weights: str | Path | None = None,
    tac_weights: str | Path | None = None,
    device: str = "cpu",
    precision: str = "fp32",
    download: str = "ask",
    weights_hash: str = "",
    dots: str = "keep",
    touch: str = "colours",
    lamps: "Mapping[str, Lamps] | None" = None,
) -> Encoder:
    """Load the encoder called `name`.

    name            a key of ENCODERS; `hf:NAME_OR_FOLDER` for a vision model of transformers;
                    `module:function` or `file.py:function` for your own; the name of an entry point
                    of the group "omnivat.encoders"; or two of these, "VIS | TAC", one for each.
                    "NAME@SENSOR" holds one kind of sensor for every image, where an encoder takes
                    it; "NAME#LAYER" gives the mean of a layer's output (`TorchEncoder.at`)
    weights         a checkpoint instead of the default one
    tac_weights     the same for the TAC encoder of two
    device          "cpu", "cuda" or "auto"
    precision       "fp32"; "bf16" is faster, with slightly different embeddings; "fp32-onnx" (the
                    default encoder on a CPU) is faster and changes only the last digits
    download        "ask", "yes" or "no": permission to fetch missing weights from the hub
    weights_hash    expected hash, if known: without `weights`, the last file with that hash is read
    dots            "fill": printed dots of tactile images are filled before they are encoded; a
                    picture of stripes, which the encoder "strip" reads, has none
    touch           "colours", or "relief": tactile images are drawn as their relief after their
                    dots are filled, by the `lamps` of their domain or each by itself; "both": the
                    two embeddings of a touch are one of twice the width, and photos have zeros

    Raises MissingNameError for an unknown name, SettingsError for an unavailable precision or
    device, DataError if the encoder violates the contract or a checkpoint is missing; the message
    then has the command that fetches it.

    >>> from PIL import Image
    >>> encoder = load_encoder("strip")
    >>> picture = encoder.preprocess(Image.new("RGB", (96, 96), "teal"))
    >>> tuple(encoder.embed(picture[None]).shape), encoder.width
    ((1, 64), 64)
    """
    settings = {"device": device, "precision": precision, "download": download}
    encoder: Encoder
    if JOINED not in name:
        encoder = _load_one(name, weights, weights_hash, settings)
    else:
        names, hashes = name.partition(JOINED)[::2], weights_hash.partition(JOINED)[::2]
        encoder = PairEncoder(
            *map(_load_one, names, (weights, tac_weights), hashes, (settings,) * 2)
        )
    if touch != "colours":
        require_filled(name, dots)
        return ReliefDrawn(encoder, lamps or {}, touch)
    return DotsFilled(encoder) if dots == "fill" and name != "strip" else encoder


def require_filled(name: str, dots: str) -> None:
    """Raise SettingsError for an encoder, or a choice of `dots`, with which no relief is drawn."""
    if name == "strip" or dots != "fill":
        raise SettingsError(
            "A relief is drawn from pictures of a gel whose printed dots were filled; leave out"
            f" {'the encoder strip' if name == 'strip' else '--dots keep'}."
        )


def _load_one(
    name: str, weights: str | Path | None, weights_hash: str, settings: dict[str, Any]
) -> Encoder:
    """Load one encoder; raises as `load_encoder` does."""
    from omnivat.encoders.hub import recall, remember
    from omnivat.encoders.wrapping import TorchEncoder, checked, takes_of
    from omnivat.kit.devices import device_from

    given = Path(weights) if weights else None
    place = given or (recall(weights_hash) if weights_hash else None)
    wanted = {**settings, "device": device_from(settings["device"]), "weights": place}
    plain, sensor, layer = cast("re.Match[str]", CHOSEN.fullmatch(name)).groups("")
    loader = _loader_of(plain)
    named = {"name": plain} if plain in ENCODERS else {}
    made = loader(**_accepted(loader, plain, wanted | named))
    if sensor and "sensor" not in takes_of(made):
        raise SettingsError(
            f"The encoder '{plain}' takes no kind of sensor; leave out '@{sensor}'."
        )
    if layer and not isinstance(made, TorchEncoder):
        raise SettingsError(f"The encoder '{plain}' has no layers; leave out --layer {layer}.")
    made = made.at(layer) if layer else made
    if sensor:
        made.sensor = sensor
    encoder: Encoder = made if named else checked(made, name)
    if named:  # an entry of one's own names none
        own = encoder.name if encoder.name in ENCODERS else plain
        encoder.name = own + name.removeprefix(plain)
    if given is None and plain.startswith(HUB):
        given = Path(plain.removeprefix(HUB))  # a folder, or a name on the hub
    if given and given.exists():
        remember(encoder.weights_hash, given)
    return encoder


def _loader_of(name: str) -> Callable[..., Any]:
    """Return the function that loads the encoder called `name`.

    Raises MissingNameError for an unknown name, DataError if the named code cannot be imported.
    """
    if name in ENCODERS:
        return cast("Callable[..., Any]", load(ENCODERS, name, kind="encoder"))
    if name.startswith(IMPORTED):
        raise DataError(
            f"The embeddings of '{name.removeprefix(IMPORTED)}' were made elsewhere and imported;"
            " no image can be encoded here. Wrap that encoder (docs/encoders.md) and embed the"
            " pairs with it."
        )
    if name.startswith(HUB):
        from omnivat.encoders.huggingface import load as load_model

        return partial(load_model, name.removeprefix(HUB))
    declared = {entry.name: entry for entry in entry_points(group=GROUP)}
    if name in declared:
        return _imported(name, declared[name].load)
    if ":" in name:
        return _imported(name, partial(_attribute, name))
    known = [*ENCODERS, *declared]
    raise MissingNameError(
        f"No encoder is called '{name}'; there are {', '.join(known)}, hf:NAME_OR_FOLDER and "
        f"module:function.{suggestion(name, known)}"
    )


def _accepted(loader: Callable[..., Any], name: str, wanted: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings that a loader accepts.

    wanted  setting -> value. Default values that the loader lacks are dropped: weights None,
            precision "fp32", download "ask", and the device, which the loader then chooses.
    Raises SettingsError for any other setting that the loader lacks.
    """
    taken = inspect.signature(loader).parameters
    if any(parameter.kind is parameter.VAR_KEYWORD for parameter in taken.values()):
        return dict(wanted)
    for setting, value in (("weights", None), ("precision", "fp32")):
        if setting not in taken and wanted.get(setting) != value:
            raise SettingsError(
                f"The encoder '{name}' takes no {setting}, and '{wanted[setting]}' came; leave out "
                f"--{setting}, or give its function an argument of that name."
            )
    return {setting: value for setting, value in wanted.items() if setting in taken}


def _imported(name: str, importer: Callable[[], Any]) -> Callable[..., Any]:
    try:
        found = importer()
    except DataError:
        raise
    except Exception as error:  # any error of the imported module
        raise DataError(
            f"The encoder '{name}' cannot be imported ({type(error).__name__}: {error}); check the "
            "module and the folder this command runs in."
        ) from error
    return cast("Callable[..., Any]", found)


def _attribute(name: str) -> Any:
    """Return the function of "module:function" or "path/file.py:function"."""
    module, _, attribute = name.rpartition(":")
    file = Path(module)
    folder = str((file.parent if file.suffix == ".py" else Path()).resolve())
    # as `python -m` does; the installed command would not find code beside the file
    if folder not in sys.path:
        sys.path.append(folder)
    if file.suffix == ".py":
        spec = importlib.util.spec_from_file_location(f"omnivat_encoder_{file.stem}", file)
        if not file.is_file() or spec is None or spec.loader is None:
            raise DataError(f"There is no file '{file}' with an encoder; check its path.")
        loaded = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(loaded)
    else:
        loaded = importlib.import_module(module)
    if not hasattr(loaded, attribute):
        raise DataError(f"'{module}' has no function '{attribute}' to load an encoder.")
    return getattr(loaded, attribute)
