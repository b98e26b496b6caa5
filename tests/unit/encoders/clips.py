"""Small CLIPs with random weights, written in each layout that people have.

OpenAI's names are made here from those of transformers, one rule a line, apart from the code under
test, which goes the other way.
"""

import json
import re
import warnings

import torch
import transformers
from safetensors.torch import save_file
from torch import nn

WIDTH, EMBED, PATCH, SIDE, VOCABULARY, LONGEST = 64, 24, 32, 96, 600, 16
TEXTS = ["a wood", "steel!", "x" * 99]

RENAMED = (
    (r"^vision_model\.encoder\.layers\.", "visual.transformer.resblocks."),
    (r"^text_model\.encoder\.layers\.", "transformer.resblocks."),
    (r"^vision_model\.embeddings\.class_embedding$", "visual.class_embedding"),
    (r"^vision_model\.embeddings\.patch_embedding\.", "visual.conv1."),
    (r"^vision_model\.embeddings\.position_embedding\.weight$", "visual.positional_embedding"),
    (r"^vision_model\.pre_layrnorm\.", "visual.ln_pre."),
    (r"^vision_model\.post_layernorm\.", "visual.ln_post."),
    (r"^text_model\.embeddings\.token_embedding\.", "token_embedding."),
    (r"^text_model\.embeddings\.position_embedding\.weight$", "positional_embedding"),
    (r"^text_model\.final_layer_norm\.", "ln_final."),
    (r"\.layer_norm([12])\.", r".ln_\1."),
    (r"\.self_attn\.out_proj\.", ".attn.out_proj."),
    (r"\.mlp\.fc1\.", ".mlp.c_fc."),
    (r"\.mlp\.fc2\.", ".mlp.c_proj."),
)


def small_model(*, activation="quick_gelu", seed=0, **vision):
    """Return a `CLIPModel` of transformers: D = 24, patch 32, one attention head."""
    sizes = {
        "hidden_size": WIDTH,
        "num_hidden_layers": 2,
        "num_attention_heads": 1,
        "intermediate_size": 96,
        "hidden_act": activation,
    }
    text = {
        "vocab_size": VOCABULARY,
        "bos_token_id": VOCABULARY - 2,
        "eos_token_id": VOCABULARY - 1,
        "pad_token_id": VOCABULARY - 1,
        "max_position_embeddings": LONGEST,
    }
    config = transformers.CLIPConfig(
        text_config={**sizes, **text},
        vision_config={**sizes, "image_size": SIDE, "patch_size": PATCH, **vision},
        projection_dim=EMBED,
    )
    torch.manual_seed(seed)
    model = transformers.CLIPModel(config).eval()
    with torch.no_grad():
        for name, weight in model.named_parameters():
            if name != "logit_scale":
                weight.copy_(torch.randn_like(weight) / max(1, weight.shape[-1]) ** 0.5)
    return model


def openai_names(state):
    """Return weights of transformers under the names and in the shapes that OpenAI published."""
    found = {}
    for key, value in state.items():
        if "position_ids" in key or re.search(r"self_attn\.[kv]_proj", key):
            continue
        if (match := re.match(r"(.*)\.self_attn\.q_proj\.(weight|bias)$", key)) is not None:
            layer, kind = match.groups()
            parts = [state[f"{layer}.self_attn.{which}_proj.{kind}"] for which in "qkv"]
            key, value = f"{layer}.attn.in_proj_{kind}", torch.cat(parts)
        elif key in ("visual_projection.weight", "text_projection.weight"):
            key, value = {"v": "visual.proj", "t": "text_projection"}[key[0]], value.T.contiguous()
        for pattern, new in RENAMED:
            key = re.sub(pattern, new, key)
        found[key] = value.clone()
    return found


def tokenizer():
    """Return a tokenizer that spells words by letters."""
    letters = [chr(code) for code in range(33, 127)]
    words = [*letters, *(letter + "</w>" for letter in letters)]
    words += [f"spare{i}" for i in range(VOCABULARY - 2 - len(words))]
    words += ["<|startoftext|>", "<|endoftext|>"]
    vocabulary = {word: index for index, word in enumerate(words)}
    return transformers.CLIPTokenizer(vocab=vocabulary, merges=[])


class Archive(nn.Module):
    """What gives a TorchScript archive with the given names in it."""

    def __init__(self, state):
        super().__init__()
        for key, value in state.items():
            *path, leaf = key.split(".")
            owner = self
            for name in path:
                if name not in owner._modules:
                    owner.add_module(name, nn.Module())
                owner = owner._modules[name]
            owner.register_buffer(leaf, value)

    def forward(self, x):
        return x


def save_script(state, file):
    """Write a TorchScript archive, as OpenAI does."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        torch.jit.save(torch.jit.script(Archive(state)), file)


def hf_folder(folder, model):
    """Write a folder as `transformers` saves it."""
    model.save_pretrained(folder)
    return folder


def hf_bare(folder, model):
    """Write a `.safetensors` with the names of transformers and nothing beside it."""
    state = {key: value.contiguous() for key, value in model.state_dict().items()}
    save_file(state, folder / "weights.safetensors")
    return folder / "weights.safetensors"


def openai_state(folder, model):
    """Write OpenAI's state dict as a PyTorch file."""
    torch.save(openai_names(model.state_dict()), folder / "ViT.pt")
    return folder / "ViT.pt"


def openai_script(folder, model):
    """Write OpenAI's TorchScript archive, with the three numbers it also holds."""
    sizes = {"input_resolution": SIDE, "context_length": LONGEST, "vocab_size": VOCABULARY}
    state = openai_names(model.state_dict())
    save_script(state | {k: torch.tensor(v) for k, v in sizes.items()}, folder / "ViT.pt")
    return folder / "ViT.pt"


def open_clip_folder(folder, model):
    """Write a folder as open_clip pushes it to the hub."""
    save_file(openai_names(model.state_dict()), folder / "open_clip_model.safetensors")
    quick = model.config.vision_config.hidden_act == "quick_gelu"
    vision = {"image_size": SIDE, "layers": 2, "width": WIDTH, "patch_size": PATCH}
    text = {"context_length": LONGEST, "vocab_size": VOCABULARY, "width": WIDTH, "heads": 1}
    config = {"embed_dim": EMBED, "quick_gelu": quick, "vision_cfg": vision, "text_cfg": text}
    (folder / "open_clip_config.json").write_text(json.dumps({"model_cfg": config}))
    return folder


LAYOUTS = {
    "transformers folder": hf_folder,
    "bare safetensors": hf_bare,
    "OpenAI state dict": openai_state,
    "OpenAI TorchScript": openai_script,
    "open_clip folder": open_clip_folder,
}


def write(layout, folder, model):
    """Write `model` in a layout, with a tokenizer in the folder; return what --weights takes."""
    folder.mkdir(parents=True, exist_ok=True)
    tokenizer().save_pretrained(folder)
    return LAYOUTS[layout](folder, model)


def image_embeddings(model, images):
    """Return what transformers makes of preprocessed images."""
    with torch.inference_mode():
        pooled = model.vision_model(pixel_values=images).pooler_output
        embedded = model.visual_projection(pooled)
    return embedded


def text_embeddings(model, texts):
    """Return what transformers makes of texts, padded in one batch."""
    tokens = tokenizer()(
        texts, padding=True, truncation=True, max_length=LONGEST, return_tensors="pt"
    )
    with torch.inference_mode():
        embedded = model.text_projection(model.text_model(**tokens).pooler_output)
    return embedded


def rn50_state(width=8, blocks=(2, 1, 1, 1)):
    """Random weights under the published names. The published tower: width 64, (3, 4, 6, 3)."""
    torch.manual_seed(1)
    state = {}

    def conv(name, norm, out, into, kernel):
        state[f"{name}.weight"] = torch.randn(out, into, kernel, kernel) / (into * kernel**2) ** 0.5
        state[f"{norm}.weight"] = torch.rand(out) + 0.5
        state[f"{norm}.bias"] = torch.randn(out) / 10
        state[f"{norm}.running_mean"] = torch.randn(out) / 10
        state[f"{norm}.running_var"] = torch.rand(out) + 0.5
        state[f"{norm}.num_batches_tracked"] = torch.tensor(3)

    for i, (out, into) in enumerate(
        [(width // 2, 3), (width // 2, width // 2), (width, width // 2)]
    ):
        conv(f"conv{i + 1}", f"bn{i + 1}", out, into, 3)
    into = width
    for stage, count in enumerate(blocks):
        middle = width * 2**stage
        for block in range(count):
            name = f"layer{stage + 1}.{block}"
            conv(f"{name}.conv1", f"{name}.bn1", middle, into, 1)
            conv(f"{name}.conv2", f"{name}.bn2", middle, middle, 3)
            conv(f"{name}.conv3", f"{name}.bn3", 4 * middle, middle, 1)
            if block == 0:
                conv(f"{name}.downsample.0", f"{name}.downsample.1", 4 * middle, into, 1)
            into = 4 * middle
    state["attnpool.positional_embedding"] = torch.randn(50, into) / into**0.5
    for name in "qkvc":
        out = EMBED if name == "c" else into
        state[f"attnpool.{name}_proj.weight"] = torch.randn(out, into) / into**0.5
        state[f"attnpool.{name}_proj.bias"] = torch.randn(out) / 10
    return state


def published_resnet(state):
    """Return an image tower beside the text tower of `small_model`, as OpenAI publishes RN50."""
    whole = {f"visual.{key}": value for key, value in state.items()}
    rest = openai_names(small_model().state_dict())
    return whole | {k: v for k, v in rest.items() if not k.startswith("visual.")}
