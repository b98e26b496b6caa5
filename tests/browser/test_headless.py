"""A set of another encoder, and one without classes, in a real Chromium."""

from dataclasses import replace

import pytest

from omnivat.data.store import save_embeddings

from .gestures import MAP, faults, open_tab, plan

pytestmark = pytest.mark.browser

HEADLESS = "() => document.querySelector('.explore')?.dataset.kind === 'features'"


@pytest.fixture
def opened(open_page, loaded, tmp_path, make_embeddings):
    """Return a function that loads a set of another encoder and one domain, and opens it."""

    def load(**options):
        made = make_embeddings(width=12, per_class=12, domains=("my-sensor",), **options)
        made = replace(made, header=replace(made.header, encoder="other-encoder"))
        save_embeddings(tmp_path / "embeddings.safetensors", made)
        return open_page(f"?set={loaded(tmp_path / 'embeddings.safetensors')}", MAP)

    return load


def empty_panels(page):
    """Return the names of panels of Explore that are shown and hold neither words nor a picture."""
    return page.evaluate(
        """() => [...document.querySelectorAll('.explore :is(.side, .panels) > *')].filter((one) =>
          one.checkVisibility() && !one.innerText.trim()
            && !one.querySelector('canvas, svg, input')).map((one) =>
          one.className)"""
    )


def test_a_set_without_classes_and_with_one_domain_says_what_is_missing_and_trains_nothing(opened):
    page = opened(classes=("unlabelled",))
    page.wait_for_selector(".explore .score pre:has-text('omnivat report')")
    assert page.locator(".explore .gaps dt").all_inner_texts() == ["Modality gap"]
    assert page.locator(".explore .colouring option").all_inner_texts() == ["Modality"]
    open_tab(page, "train")
    page.wait_for_selector("#view-train .problem:has-text('No domain has pairs of two classes')")
    assert "omnivat report" in page.inner_text("#view-train .headless pre")
    assert not page.is_visible("#view-train .choices")
    assert not page.is_visible("#view-train .task")


def test_a_set_without_a_head_has_maps_gaps_neighbours_and_a_head_is_trained_used_and_saved(opened):
    page = opened()
    page.wait_for_function(HEADLESS)
    page.wait_for_selector(".explore .score pre:has-text('omnivat try embeddings.safetensors')")
    gaps = page.locator(".explore .gaps dt").all_inner_texts()
    assert gaps == ["Modality gap", "Cosine margin"]
    assert page.locator(".explore .kinds button").all_inner_texts() == ["PCA", "UMAP"]
    assert not page.is_visible(".explore .staircase")
    assert not page.is_visible(".explore .order")
    colours = page.locator(".explore .colouring option").all_inner_texts()
    assert colours == ["Class", "Modality"]
    page.focus(".explore .map canvas + canvas")
    page.keyboard.press("n")
    page.keyboard.press("Enter")
    page.wait_for_selector(".explore .card .found button")
    assert "Predicted" not in page.inner_text(".explore .card")
    for chapter in ("fooled", "analyse"):
        page.click(f'.explore [data-chapter="{chapter}"]')
        page.wait_for_function(
            "name => document.querySelector('.explore').dataset.chapter === name &&"
            " [...document.querySelectorAll('.explore pre')].some((one) => one.checkVisibility())",
            arg=chapter,
        )
        assert empty_panels(page) == []
    assert not page.is_visible(".explore .second")
    open_tab(page, "pair")
    page.wait_for_selector(".ov.pair .headless pre")
    open_tab(page, "train")
    page.wait_for_selector("#view-train .status:has-text('a head for another set')")
    assert "The set has no other" in page.inner_text("#view-train .task")
    plan(page, 7.5)
    page.click("#view-train .go")
    page.wait_for_selector("#view-train .problem:has-text('epochs is 7.5; give a whole number')")
    page.fill("#train-epochs input", "5")
    page.click("#view-train .go")
    page.wait_for_selector("#view-train .status:has-text('Done: 5 epochs')")
    page.wait_for_selector("#train-map .js-plotly-plot")
    page.wait_for_selector("#view-train .earlier td")
    assert faults(page, of="#view-train") == []
    page.set_viewport_size({"width": 400, "height": 800})
    table = page.locator("#view-train .earlier")
    assert table.bounding_box()["width"] < 400
    assert table.evaluate("box => box.scrollWidth - box.clientWidth") <= 0
    page.set_viewport_size({"width": 1440, "height": 900})
    titles = page.locator("#train-charts .annotation-text .line:first-child").all_text_contents()
    # no empty chart of accuracy away from home
    assert titles == ["Loss", "Gaps of F̂", "Cosine margin of F̂", "p"]
    page.click("#view-train label:has-text('class')")
    page.wait_for_selector("#train-map .legendtext >> nth=4")  # the colours on the map
    with page.expect_download() as saved:
        page.click("#view-train .save")
    assert saved.value.path().read_bytes()[:2] == b"PK"
    page.reload()  # the run is still there
    page.click("#view-train .use")
    page.wait_for_selector(
        ".explore.ready .score:has-text('the set has no domain besides the training domain')"
    )
    assert page.get_attribute(".explore .modes [data-key=moved]", "aria-checked") == "true"
    assert empty_panels(page) == []
