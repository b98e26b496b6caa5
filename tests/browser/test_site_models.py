"""The routes of Try a pair in the browser reply as the server's functions do."""

import base64
from pathlib import Path

import pytest

pytest.importorskip("onnx", reason="the extra [onnx] is not installed")
pytest.importorskip("onnxscript", reason="the extra [onnx] is not installed")

from app.pair import tab as pair
from app.shared import familiar
from app.shared.places import places, shipped_places
from app.shared.resources import Resources
from app.site.folder import whole_files
from app.site.models import files_in
from benchmarks.site import ASK, make, served
from omnivat.kit.errors import DataError

pytestmark = pytest.mark.browser
NEAR = 0.005  # of a probability


class Both:
    """One request to the browser's routes and to the server's functions."""

    def __init__(self, page, resources, folder):
        self.page, self.resources, self.folder = page, resources, folder

    def browser(self, path, question, file=b""):
        sent = [path, question, base64.b64encode(file).decode()]
        status, reply, _ = self.page.evaluate(ASK, sent)
        assert status == 200, reply
        return reply

    def send(self, file):
        ref, _ = self.resources.take_image(file.read_bytes(), file.name)
        (reply,) = self.browser("pair", {"vis": "file:0"}, file.read_bytes())["pictures"]
        assert reply["preview"].startswith("data:image/jpeg;base64,")
        return str(ref), reply["ref"]


def near(shown, wanted, within=NEAR):
    """Compare plain values; numbers may differ by `within`."""
    if isinstance(wanted, dict):
        assert shown.keys() == wanted.keys()
        for key, value in wanted.items():
            near(shown[key], value, within)
    elif isinstance(wanted, list | tuple):
        assert len(shown) == len(wanted)
        for ours, theirs in zip(shown, wanted, strict=True):
            near(ours, theirs, within)
    elif isinstance(wanted, float):
        assert shown == pytest.approx(wanted, abs=within)
    else:
        assert shown == wanted


@pytest.fixture(scope="module")
def both(chromium, tmp_path_factory):
    resources = Resources(places())
    folder = Path(tmp_path_factory.mktemp("a site of 100 %, its models"))
    try:
        make(resources, folder, None)
    except DataError as error:  # no npm here, or no network
        pytest.skip(str(error))
    with served(folder) as address:
        context = chromium.new_context()
        page = context.new_page()
        page.goto(address)
        yield Both(page, resources, folder)
        context.close()


def test_a_first_own_pair_needs_less_than_30_mb_and_a_site_of_both_sets_less_than_60(both):
    def megabytes(files):
        return sum(file.stat().st_size for file in files) / 1e6

    def of_set(resources):
        return whole_files(resources, lambda _: None)

    sensors, chirps = of_set(both.resources), of_set(Resources(shipped_places("chirps")))
    # scripts, runtime, encoder, and the larger of both sets
    page = megabytes(files_in(both.folder))
    # of the head that reads no own picture
    later = megabytes(both.folder.rglob("familiarity.safetensors.gz"))
    seen = [sensors[name] for name in ("/frames", "/thumbnails.webp")]
    assert page - later + megabytes(seen) < 30
    assert page + megabytes({*sensors.values(), *chirps.values()}) < 60  # and the chirps' models


@pytest.mark.long
def test_every_route_of_try_a_pair_replies_as_the_server_does(both):
    resources = both.resources
    examples = list(resources.examples().values())[::6][:8]
    refs = [{m: both.send(file) for m, file in one.items()} for one in examples]
    server, browser = ([{m: ref[m][side] for m in ref} for ref in refs] for side in (0, 1))
    half = ({"vis": server[2]["vis"]}, {"vis": browser[2]["vis"]})

    for ours, theirs in (
        (browser[0], server[0]),
        half[::-1],
        ({"vis": "row:7", "tac": "row:7"},) * 2,
    ):
        wanted = pair.predicted(resources, theirs | {"order": 0.3})
        found = both.browser("pair", ours | {"order": 0.3})
        spectra = found.pop("spectra"), wanted.pop("spectra")
        near(found.pop("images"), wanted.pop("images"), 0.02)
        for branch in ("vis_branch", "tac_branch"):
            wanted["exact"]["readings"].pop(branch, None)  # no script shows them
        near(found, wanted)
        assert [one["columns"] for one in spectra[0].values()] == [64] * len(spectra[1])
        looked = familiar.familiar(resources, theirs)
        for image in looked["images"].values():
            image.pop("strays", None)
        near(both.browser("familiar", ours), looked, 0.02)

    shown, wanted = both.browser("attention", browser[0]), pair.attention(resources, server[0])
    assert shown["count"] == wanted["count"]
    assert shown["scale"] == pytest.approx(wanted["scale"], rel=0.01)
