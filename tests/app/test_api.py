"""The API for programs: its tools by HTTP and MCP, its schema, hostile calls, and the document's
examples.
"""

import asyncio
import base64
import json
import os
import re
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from app.serving.api import WORK
from app.serving.api_schema import TOOLS, document
from app.shared.limits import MAX_API_BYTES

from .conftest import served

ROOT = Path(__file__).resolve().parents[2]
JSON_RPC = {"jsonrpc": "2.0", "id": 7}
CALL = {**JSON_RPC, "method": "tools/call"}


@pytest.fixture
def client(resources):
    with served(resources, api=True) as client:
        yield client
    resources.shared.close()


def data(png):
    return "data:image/png;base64," + base64.b64encode(png).decode()


def sentence(reply, status):
    """Return the sentence of an error, by HTTP or MCP."""
    assert reply.status_code == status, reply.text
    said = reply.json()["error"]
    said = said if isinstance(said, str) else said["message"]
    assert said.endswith(".") and "\n" not in said and "Traceback" not in said
    return said


@pytest.mark.parametrize("name", TOOLS)
def test_every_tool_keeps_its_schema(client, name):
    jsonschema = pytest.importorskip("jsonschema")
    given = {"vis": "row:3", "tac": "row:3"} if name == "predict" else {}
    takes, returns = TOOLS[name][1:]
    jsonschema.validate(given, takes)
    got = client.post(f"/omnivat/api/{name}", json=given)
    assert got.status_code == 200, got.text
    jsonschema.validate(got.json(), returns)


def test_the_schema_is_at_an_address_and_lists_every_tool(client):
    got = client.get("/omnivat/api/schema").json()
    assert got == document() and got["openapi"] == "3.1.0"
    assert set(got["paths"]) == {*(f"/omnivat/api/{name}" for name in WORK), "/omnivat/image"}
    assert set(WORK) == set(TOOLS)


def test_a_prediction_is_the_library_s_and_a_picture_can_be_used_again(client, resources, png):
    from omnivat.head.predict import predict_embeddings

    first = client.post("/omnivat/api/predict", json={"vis": data(png()), "tac": "row:2"}).json()
    read = client.post("/omnivat/image", content=png()).json()["ref"]
    again = client.post("/omnivat/api/predict", json={"vis": read, "tac": "row:2"}).json()
    assert again == first
    import torch

    vis, tac = (
        torch.from_numpy(rows[2:3])
        for rows in (resources.embeddings().vis, resources.embeddings().tac)
    )
    got = client.post("/omnivat/api/predict", json={"vis": "row:2", "tac": "row:2", "order": 0.3})
    wanted = predict_embeddings(resources.head(), vis, tac, order=0.3)[0]
    assert got.json()["probabilities"] == pytest.approx(wanted["probabilities"], abs=1e-6)


def test_gaps_are_those_of_the_command(client, resources, capsys):
    from omnivat.cli import main

    where = resources.where
    main(["gaps", "--head", str(where.head), "--embeddings", str(where.embeddings), "--json"])
    wanted = json.loads(capsys.readouterr().out)
    got = client.post("/omnivat/api/gaps", json={}).json()
    assert set(got) == set(wanted)
    assert got["modality_gap"] == pytest.approx(wanted["modality_gap"], abs=1e-5)
    for modality, table in wanted["domain_gap"].items():
        for name, row in table.items():
            assert got["domain_gap"][modality][name] == pytest.approx(row, abs=1e-5)


def test_without_api_every_address_refuses_and_says_how_to_open_it(resources):
    with served(resources) as client:
        for name in (*(f"api/{tool}" for tool in TOOLS), "mcp"):
            assert "--api" in sentence(client.post(f"/omnivat/{name}", json={}), 404)
        assert "--api" in sentence(client.get("/omnivat/api/schema"), 404)


HOSTILE = [
    ("predict", b'{"vis": "row:3", "order": 9}', 400, "-4 to 4"),
    ("predict", b'{"vis": 3}', 400, "vis has to be a string"),
    ("predict", b'{"vis": "row:3", "p": 0.5}', 400, "takes no 'p'"),
    ("predict", b'{"vis": "data:image/png;base64,!!!"}', 400, "no data address"),
    ("predict", b'{"vis": "data:image/png;base64,aGFsbG8="}', 400, "not an image"),
    ("gaps", b'{"stage": "tree"}', 400, "choose one of raw"),
    ("gaps", b'{"\\ud800": 1}', 400, "takes no"),
    ("gaps", b'{"set": "mine"}', 410, "no longer has"),
    ("about", b"[" * 100_000, 400, "not JSON"),
    ("about", b"[]", 400, "not a JSON object"),
    ("predict", b"x" * (MAX_API_BYTES + 1), 413, "larger than 4 MB"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "body", "status", "words"), HOSTILE)
def test_a_hostile_call_is_refused_in_a_sentence(client, name, body, status, words):
    assert words in sentence(client.post(f"/omnivat/api/{name}", content=body), status)


def test_a_broken_picture_another_address_and_another_method_are_refused(client, png):
    cut = data(png()[:200])
    assert "'vis'" in sentence(client.post("/omnivat/api/predict", json={"vis": cut}), 400)
    assert "predict" in sentence(client.post("/omnivat/api/shell"), 404)
    for name, method in {"api/predict": "POST", "api/schema": "GET", "mcp": "POST"}.items():
        wrong = client.put(f"/omnivat/{name}")
        sentence(wrong, 405)
        assert wrong.headers["allow"] == method
        sentence(client.options(f"/omnivat/{name}"), 405)


def call(client, method, params=None, **more):
    message = {**JSON_RPC, "method": method, "params": params, **more}
    return client.post("/omnivat/mcp", json=message)


def test_mcp_lists_and_runs_the_tools_without_a_session(client):
    hello = call(client, "initialize", {"protocolVersion": "2025-06-18"}).json()["result"]
    assert hello["protocolVersion"] == "2025-06-18" and "mcp-session-id" not in hello
    assert call(client, "initialize", {"protocolVersion": "1"}).json()["result"]["protocolVersion"]
    note = client.post(
        "/omnivat/mcp", json={"jsonrpc": "2.0", "method": "notifications/initialized"}
    )
    assert (note.status_code, note.content) == (202, b"")
    listed = call(client, "tools/list").json()["result"]["tools"]
    assert [one["name"] for one in listed] == list(TOOLS)
    got = call(client, "tools/call", {"name": "predict", "arguments": {"vis": "row:1"}}).json()
    direct = client.post("/omnivat/api/predict", json={"vis": "row:1"}).json()
    assert got["id"] == 7 and got["result"]["structuredContent"] == direct
    assert json.loads(got["result"]["content"][0]["text"]) == direct
    assert call(client, "ping").json()["result"] == {"resultType": "complete"}


def test_mcp_is_discovered_without_a_handshake_and_an_unknown_version_names_the_known(client):
    found = call(client, "server/discover").json()["result"]
    assert found["supportedVersions"][0] == "2026-07-28" and found["capabilities"] == {"tools": {}}
    listed = call(client, "tools/list").json()["result"]
    for one in (found, listed):  # the fields that this version requires
        assert (one["resultType"], one["cacheScope"], one["ttlMs"]) == (
            "complete",
            "public",
            60_000,
        )
    stated = {"_meta": {"io.modelcontextprotocol/protocolVersion": "2026-07-28"}}
    got = call(client, "tools/call", {"name": "about", **stated}).json()["result"]
    assert got["resultType"] == "complete" and got["structuredContent"]["classes"]
    stated["_meta"]["io.modelcontextprotocol/protocolVersion"] = "2031-01-01"
    got = call(client, "server/discover", stated).json()["error"]
    assert got["code"] == -32022 and got["data"]["supported"] == found["supportedVersions"]


def test_mcp_gives_a_tool_s_refusal_as_a_result_that_a_model_can_read(client):
    wrong = {"name": "predict", "arguments": {"vis": "row:1", "order": 9}}
    got = call(client, "tools/call", wrong).json()["result"]
    assert got["isError"] and "-4 to 4" in got["content"][0]["text"]


@pytest.mark.parametrize(
    ("message", "status", "code"),
    [
        ({**JSON_RPC, "method": "prompts/list"}, 200, -32601),
        ({**CALL, "params": {"name": "shell"}}, 200, -32602),
        ({**CALL, "params": {"name": "about", "arguments": []}}, 200, -32602),
        ({**JSON_RPC, "jsonrpc": "1.0", "method": "ping"}, 400, -32600),
        ({**JSON_RPC, "method": 3}, 400, -32600),
        ({"id": 1, "method": "x"}, 400, -32600),
        ([], 400, -32700),
    ],
)
def test_a_fault_of_the_protocol_is_an_error_of_json_rpc(client, message, status, code):
    got = client.post("/omnivat/mcp", content=json.dumps(message))
    sentence(got, status)
    assert got.json()["error"]["code"] == code


@pytest.mark.parametrize("number", ["1e999", "[1]", '"\\ud800"'])
def test_an_odd_id_is_no_fault_of_the_server(client, number):
    body = '{"jsonrpc": "2.0", "id": ' + number + ', "method": "ping"}'
    assert client.post("/omnivat/mcp", content=body).status_code == 200


@pytest.fixture
def address(resources):
    """Return the address of a server of the small set."""
    import uvicorn

    config = uvicorn.Config(served(resources, api=True).app, port=0, log_level="error")
    server = uvicorn.Server(config)
    thread = threading.Thread(target=lambda: asyncio.run(server.serve()), daemon=True)
    thread.start()
    while not server.started:
        threading.Event().wait(0.01)
    yield f"127.0.0.1:{server.servers[0].sockets[0].getsockname()[1]}"
    server.should_exit = True
    thread.join(120)
    resources.shared.close()


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "number"), [("bash", 0), ("python", 0), ("python", 1)])
def test_the_document_s_clients_run(address, kind, number):
    text = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    source = re.findall(rf"```{kind}\n(.*?)```", text, re.DOTALL)[number]
    if "from mcp" in source:
        pytest.importorskip("mcp")
    line = ["bash", "-ec"] if kind == "bash" else [sys.executable, "-c"]
    done = subprocess.run(
        [*line, source.replace("127.0.0.1:7860", address)],
        cwd=ROOT,
        env={**os.environ, "PYTHONWARNINGS": "ignore"},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    assert any(name in done.stdout for name in ("wood", "steel", "plastic", "ceramic", "glass"))
