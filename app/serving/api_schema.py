"""The API's tools: what each takes and returns (JSON Schema), and the OpenAPI document of all."""

from typing import Any

from app.shared.limits import MAX_API_BYTES, MAX_IMAGE_BYTES
from omnivat import __version__
from omnivat.kit.stages import LIMIT, STAGES
from omnivat.measure.gaps import GAPS

Schema = dict[str, Any]
TEXT: Schema = {"type": "string"}
COUNT: Schema = {"type": "integer"}
NUMBER: Schema = {"type": "number"}
MAYBE: Schema = {"type": ["number", "null"]}
IMAGE = (
    "'row:3' (a pair of the set), 'example:NAME' (see about), 'data:image/png;base64,…', or"
    " 'image:…', the embeddings that POST /omnivat/image returns; leave it out for a missing one"
)
ORDER: Schema = {
    **NUMBER,
    "minimum": -LIMIT,
    "maximum": LIMIT,
    "description": "fractional order p, in quarter turns; the learned one if left out",
}
SET: Schema = {**TEXT, "description": "a shipped set (see about) or one from POST /omnivat/load"}


def _list(items: Schema) -> Schema:
    return {"type": "array", "items": items}


def _by_name(of: Schema) -> Schema:
    return {"type": "object", "additionalProperties": of}


def _given(**properties: Schema) -> Schema:
    return {
        "type": "object",
        "properties": {**properties, "set": SET},
        "additionalProperties": False,
    }


def _returned(**properties: Schema) -> Schema:
    return {"type": "object", "properties": properties, "required": list(properties)}


RECORD = _returned(
    **dict.fromkeys(("part", "measure", "modality", "note", "from", "to"), TEXT),
    **dict.fromkeys(("value", "low", "high"), MAYBE),
    n={"type": ["integer", "string"]},
)
SHARES = _by_name(NUMBER)
TABLE = _by_name(_by_name(_by_name(MAYBE)))

# name -> (what it does, what it takes, what it returns)
TOOLS: dict[str, tuple[str, Schema, Schema]] = {
    "about": (
        "Name what is loaded: classes, domains, examples, heads, sets.",
        _given(),
        _returned(
            classes=_list(TEXT),
            domains=_list(TEXT),
            pairs=COUNT,
            simulated={"type": "boolean"},
            encoder=TEXT,
            source={**TEXT, "description": "the domain that the head was trained on"},
            learned_order=NUMBER,
            examples=_list(TEXT),
            heads=_list(TEXT),
            sets=_list(TEXT),
        ),
    ),
    "predict": (
        (
            "Predict the material of a pair of a photo (vis) and a tactile image (tac), or of one"
            " of them."
        ),
        _given(
            vis={**TEXT, "description": f"the photo: {IMAGE}"},
            tac={**TEXT, "description": f"the tactile image: {IMAGE}"},
            order=ORDER,
            head={**TEXT, "description": "a head to compare (see about); the first if left out"},
        ),
        _returned(
            prediction=TEXT,
            probabilities=SHARES,
            modalities={**_by_name(SHARES), "description": "from each image alone"},
            temperature={"type": "object"},
            familiarity={
                "type": "object",
                "description": "of each image to the training images, if the head keeps those",
            },
            order=NUMBER,
            source=TEXT,
        ),
    ),
    "gaps": (
        "Measure the gaps of the loaded set between photos and touches, and between domains.",
        _given(
            stage={**TEXT, "enum": list(STAGES), "default": STAGES[-1]},
            order=ORDER,
            measure={**TEXT, "enum": list(GAPS), "default": "centroid"},
        ),
        _returned(
            stage=TEXT,
            order=MAYBE,
            measure=TEXT,
            pairs=COUNT,
            simulated={"type": "boolean"},
            modality_gap=_by_name(MAYBE),
            domain_gap=TABLE,
            floor={
                **_by_name(MAYBE),
                "description": "the same gap between two random halves of one domain, mean over"
                " domains",
            },
        ),
    ),
    "report": (
        (
            "Report the domain shift of the loaded set's features, without a head: both gaps by"
            " every measure with intervals, retrieval, neighbours, probes. It may take minutes."
        ),
        _given(),
        _returned(
            pairs=COUNT,
            domains=_list(TEXT),
            simulated={"type": "boolean"},
            numbers=_list(RECORD),
            notes={**_list(TEXT), "description": "what the set cannot show"},
            methods={**TEXT, "description": "a paragraph for a paper, with versions"},
        ),
    ),
}


def document() -> Schema:
    """Return the OpenAPI 3.1 document of the API."""
    error = _returned(error={**TEXT, "description": "one sentence"})

    def reply(of: Schema, what: str) -> Schema:
        return {"description": what, "content": {"application/json": {"schema": of}}}

    refused = reply(error, "a refusal; docs/api.md lists the statuses")

    def posted(what: str, body: Schema, schema: Schema, **more: Any) -> Schema:
        content = {"required": True, "content": body}
        replies = {"200": reply(schema, "the result"), "default": refused}
        return {"post": {"summary": what, "requestBody": content, "responses": replies, **more}}

    image = {"schema": {**TEXT, "format": "binary", "maxLength": MAX_IMAGE_BYTES}}
    sent = _returned(ref=TEXT, width=COUNT, height=COUNT, preview=TEXT)
    paths = {
        f"/omnivat/api/{name}": posted(
            what, {"application/json": {"schema": given}}, found, operationId=name
        )
        for name, (what, given, found) in TOOLS.items()
    }
    paths["/omnivat/image"] = posted(
        "Read one picture, of which nothing is kept; predict takes its `ref` in its place.",
        {"image/*": image},
        sent,
        operationId="image",
    )
    return {
        "openapi": "3.1.0",
        "info": {
            "title": "OmniVaT",
            "version": __version__,
            "description": (
                f"Bodies have at most {MAX_API_BYTES:,} bytes, pictures {MAX_IMAGE_BYTES:,}. The"
                " same tools are at /omnivat/mcp (Model Context Protocol, streamable HTTP)."
            ),
        },
        "paths": paths,
    }
