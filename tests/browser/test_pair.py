"""Try a pair: one journey for each action."""

import json
import re
from dataclasses import replace
from io import BytesIO
from shutil import copyfile
from urllib.parse import parse_qs, urlsplit
from zipfile import ZipFile

import numpy as np
import pytest
from PIL import Image

from omnivat import lamps, load_head, save_profile
from omnivat.cli import main
from omnivat.data.readers import read_pairs
from omnivat.head.heads import EXAMPLES, default_head

from .fake_sensor import CAMERAS
from .gestures import ANSWERED, SLOT, holds, send, settle, texture

pytestmark = pytest.mark.browser


PAIR = "?view=pair&vis=row:0&tac=row:0"
FOLDER = ".pair .pairs label:has-text('Folder') input"


def said(page, reading):
    """Return what one reading predicts, in the words of the page."""
    return page.inner_text(f".pair .reading[data-reading={reading}]")


def test_pictures_unlike_anything_seen_are_called_a_guess(open_page):
    page = open_page("?view=pair", ANSWERED)
    for seed, modality in enumerate(("vis", "tac")):
        send(page, modality, seed)
    page.wait_for_selector(".pair .familiar .look")
    if "has no record" in page.inner_text(".pair .familiar"):
        pytest.skip("the head that is shipped holds no familiarity")
    page.wait_for_selector(".pair .reading[data-reading=fused] .guessed")
    for reading in ("fused", "vis", "tac"):
        assert "This is a guess" in said(page, reading)
        assert "%" not in said(page, reading)
    assert page.locator(".pair .nearest button").count() == 6


def test_no_letter_of_the_chart_over_p_is_cut_off(open_page):
    page = open_page(PAIR, ANSWERED, size=(1280, 720))
    page.click(".pair .what-if-p summary")
    page.wait_for_selector(".pair .what-if-p .lines text")
    cut = page.evaluate(
        """() => [...document.querySelectorAll('.pair .what-if-p .lines text')].filter((text) => {
          const [own, all] = [text, text.ownerSVGElement].map((e) => e.getBoundingClientRect());
          return own.left < all.left - 1 || own.right > all.right + 1;
        }).map((text) => text.textContent)"""
    )
    assert cut == []


def test_p_is_moved_in_a_section_of_its_own_and_leaves_the_prediction(open_page):
    page = open_page(PAIR, ANSWERED)
    settle(page)
    prediction = said(page, "fused")
    page.click(".pair .what-if-p summary")
    page.wait_for_selector(".pair .lines svg .band")
    before = page.inner_text(".pair .at-p")
    page.focus(".pair .order")
    for _ in range(10):
        page.keyboard.press("ArrowLeft")
    page.wait_for_function(
        "before => document.querySelector('.pair .at-p').innerText !== before", arg=before
    )
    assert said(page, "fused") == prediction
    assert "chance" in page.inner_text(".pair .about-p")


def test_a_csv_of_one_file_twice_pairs_nothing_and_in_its_folder_two_pictures_of_one_name(
    open_page, tmp_path
):
    for seed, folder in enumerate(("visual", "tactile")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "1.png").write_bytes(texture(seed)["buffer"])
    table = tmp_path / "pairs.csv"
    table.write_text("vis,tac\nvisual/1.png,tactile/1.png\n")
    page = open_page("?view=pair", ANSWERED)
    files = [tmp_path / "visual" / "1.png", table]
    page.set_input_files(".pair .pairs label:has-text('Files') input", files)
    page.wait_for_selector(".pair .many:has-text('would be one file')")
    assert not page.locator(".pair .many .link").count()
    page.set_input_files(FOLDER, tmp_path)
    page.wait_for_selector(".pair .many .link")
    settle(page)  # the first pair is open
    shown = [page.get_attribute(f"{SLOT.format(m)} .picture img", "src") for m in ("vis", "tac")]
    assert shown[0] != shown[1]


def test_own_pairs_are_counted_taught_and_saved(open_page):
    page = open_page("?view=pair", ANSWERED)
    for seed, label in ((20, "wood"), (21, "wood"), (22, "cork"), (23, "cork")):
        send(page, "vis", seed)
        send(page, "tac", seed + 10)
        own = page.locator(f".pair .labels button[data-label='{label}']")
        if own.count():
            own.click()
        else:
            page.fill(".pair .labels input", label)
            page.keyboard.press("Enter")
        page.wait_for_selector(f".pair .chips li:has-text('{seed}.png')")
    assert "of 4" in page.inner_text(".pair .tally")
    page.click(".pair .own [data-send=teach]")
    page.wait_for_selector(".pair .taught table")
    report = page.inner_text(".pair .taught p")
    assert re.search(r"Correct before teaching: \d of 4\. After teaching: \d of 4\.", report)
    page.wait_for_selector(".pair .taught-now")
    page.wait_for_selector(ANSWERED)
    assert page.locator(".pair .bars th:has-text('cork')").count() == 1
    for button in ("[data-path='save/set']", "[data-path='save/head']", "[data-send=savePictures]"):
        with page.expect_download() as saved:
            page.click(f".pair {button}")
        assert saved.value.path().read_bytes()[:2] == b"PK"


def test_a_second_click_while_the_camera_opens_leaves_it_off(open_page):
    page = open_page(PAIR, ANSWERED, permissions=["camera"])
    page.evaluate("""() => {
          const open = navigator.mediaDevices.getUserMedia.bind(navigator.mediaDevices);
          window.streams = [];
          navigator.mediaDevices.getUserMedia = async (what) => {
            await new Promise((later) => setTimeout(later, 300));
            const stream = await open(what);
            window.streams.push(stream);
            return stream;
          };
          const start = document.querySelector('.pair .cameras [data-send=camerasSwitched]');
          start.click();
          start.click();
        }""")
    page.wait_for_function("window.streams.length === 1")
    page.wait_for_function(
        "window.streams.every((one) => one.getTracks().every((t) => t.readyState === 'ended'))"
    )
    assert (
        page.get_attribute(".pair .cameras [data-send=camerasSwitched]", "aria-pressed") == "false"
    )
    page.wait_for_selector(ANSWERED)


def test_live_without_a_camera_says_why_and_gives_the_pair_back(open_page):
    page = open_page(PAIR, ANSWERED)
    page.evaluate("""() => {
          navigator.mediaDevices.getUserMedia = async () => { throw new Error("denied"); };
        }""")
    page.click(".pair .cameras > summary")
    page.click(".pair .cameras [data-send=camerasSwitched]")
    page.wait_for_selector(".pair .problem:has-text('camera')")
    page.wait_for_selector(".pair .cameras [data-send=camerasSwitched][aria-pressed=false]")
    page.wait_for_selector(ANSWERED)


@pytest.fixture
def live(open_page, sensor, presses):
    """Return an opener of Live: two cameras see a real sensor at rest, and Live is started. It is
    stopped afterwards.
    """
    pages = []

    def opened(name="gelsight", **kept):
        sensor.see(presses(name)[0])
        page = open_page(PAIR, permissions=["camera"])
        page.add_init_script(f"{{{CAMERAS}}}")
        for modality, wanted in kept.items():
            page.add_init_script(
                f"localStorage['omnivat-live-{modality}'] ??= '{json.dumps(wanted)}'"
            )
        page.goto(page.url)
        page.wait_for_selector(ANSWERED)
        page.held = True  # Live always has a frame on its way
        page.click(".pair .cameras > summary")
        page.click(".pair .cameras [data-send=camerasSwitched]")
        page.wait_for_selector(".pair .verdict .tag:has-text('live')")
        page.wait_for_selector(".pair .verdict .reading[data-reading=tac]")  # no rest picture yet
        pages.append(page)
        return page

    yield opened
    for page in pages:
        page.evaluate("document.querySelector('.cameras [aria-pressed=true].main')?.click()")


def take_rest(page):
    """Take the rest picture."""
    page.click(".pair .cameras [data-what=rest]")
    page.wait_for_selector(".pair .feed[data-modality=tac] .state:has-text('mean of 10 frames')")


STATE = ".pair .feed[data-modality=tac] .state:has-text('{}')"
TOUCHED = ".pair .verdict .reading[data-reading=tac]"
SIDE_BY_SIDE = """() => ['.feed', '.verdict']
  .map((name) => document.querySelector(`.pair ${name}`).getBoundingClientRect())
  .every(({ top, bottom }) => top < innerHeight - 100 && bottom > 100)"""
IDLE = ".pair .verdict:has-text('No contact')"


@pytest.mark.parametrize("name", ["gelsight", "gelsight_mini"])
def test_live_gives_a_class_to_a_real_press_and_none_to_a_sensor_at_rest(
    live, sensor, presses, name
):
    calm, pressed = presses(name)
    page = live(name)
    assert page.evaluate(SIDE_BY_SIDE)
    names = page.locator(".pair .feed .device option:checked").all_inner_texts()
    assert names == ["Webcam", "Sensor"]
    page.wait_for_selector(".pair .cameras .rate:has-text('ms from camera')")
    take_rest(page)
    page.wait_for_selector(IDLE)
    assert page.locator(TOUCHED).count() == 0
    for k in (0, len(pressed) // 2, len(pressed) - 1):
        sensor.see(pressed[k], page=page)
        page.wait_for_selector(TOUCHED)
        assert page.locator(".pair .verdict .reading").count() == 3
        sensor.see(calm, page=page)
        page.wait_for_selector(IDLE)


def test_no_rest_picture_is_made_of_a_sensor_that_is_touched_meanwhile(live, sensor, presses):
    calm, pressed = presses("gelsight")
    page = live(vis={"device": "none"})
    sensor.see(calm, calm, pressed[0], page=page)
    page.click(".pair .cameras [data-what=rest]")
    page.wait_for_selector(STATE.format("without touching"))
    page.wait_for_selector(TOUCHED)
    sensor.see(calm, page=page)
    take_rest(page)
    page.wait_for_selector(IDLE)


def shown(body, pictures):
    """Return which picture a request shows."""
    with Image.open(BytesIO(body)) as image:
        sent = np.asarray(image.convert("RGB").resize((64, 48)), float)
    apart = [
        np.abs(np.asarray(Image.fromarray(p).resize((64, 48)), float) - sent).mean()
        for p in pictures
    ]
    return int(np.argmin(apart))


def pictured(request):
    """Return the question of a request, and the picture after it."""
    size = int(parse_qs(urlsplit(request.url).query)["sizes"][0].split(",")[0])
    body = request.post_data_buffer
    return json.loads(body[:size]), body[size:]


def test_a_slow_server_gets_the_newest_frame_and_none_in_between(live, sensor, presses):
    pressed = presses("gelsight")[1]
    scenes = [presses("gelsight")[0], pressed[0], pressed[24], presses("gelsight_mini")[0]]
    page = live(vis={"device": "none"})
    held = []
    sent = []
    waits = True

    def take(route):
        sent.append(shown(pictured(route.request)[1], scenes))
        held.append(route) if waits else route.continue_()

    page.route("**/omnivat/live?*", take)
    while len(held) < 2:  # as many as Live has on their way
        page.wait_for_timeout(20)
    for scene in scenes[1:]:
        sensor.see(scene, page=page)
    assert sent == [0, 0]
    waits = False
    for route in held:
        route.continue_()
    while len(sent) < 4:
        page.wait_for_timeout(20)
    page.unroute("**/omnivat/live?*")
    assert sent[2:4] == [3, 3]


AFTER_FRAMES = """() => new Promise((done) => {
  const [box, told, rate] = ['.label', '.guided', '.rate']
    .map((name) => document.querySelector(`.pair .cameras ${name}`));
  let frames = 0;
  new MutationObserver(() => ++frames === 3
    && done([box.value, box === document.activeElement, told.textContent])
  ).observe(rate, { childList: true, characterData: true, subtree: true });
})"""


def test_live_pictures_join_the_labelled_pairs_and_teach(live, sensor, presses):
    pressed = presses("gelsight_mini")[1]
    page = live("gelsight_mini")
    page.click(".pair .cameras [data-what=label]")
    page.wait_for_selector(".pair .cameras .guided:has-text('Type the true class')")
    page.focus(".pair .cameras .label")
    page.keyboard.type("co")
    assert page.evaluate(AFTER_FRAMES) == ["co", True, "Type the true class as the label first."]
    # two moments of one press each, so that the taught map is sure
    for k, (label, moment) in enumerate((("cork", 0), ("cork", 1), ("felt", 18), ("felt", 19))):
        sensor.see(pressed[moment], page=page)
        page.fill(".pair .cameras .label", label)
        page.click(".pair .cameras [data-what=label]")
        page.wait_for_selector(f".pair .own .chips li:nth-child({k + 1})")
    page.click(".pair .own [data-send=teach]")
    page.wait_for_selector(".pair .verdict:has-text('felt')")


def test_live_calibrates_and_records_a_data_set_that_import_reads(live, sensor, presses, tmp_path):
    calm, pressed = presses("gelsight_mini")
    page = live("gelsight_mini")
    take_rest(page)
    page.wait_for_selector(IDLE)
    page.click(".pair .cameras [data-what=calibrate]")  # waits for a contact
    sensor.see(pressed[0], page=page)
    page.wait_for_selector(".pair .profile-now:has-text('profile of 10')")
    page.fill(".pair .cameras .label", "wood")
    page.click(".pair .cameras [data-send=recordSwitched]")
    page.wait_for_selector(".pair .cameras .rate:has-text('2 pairs recorded')")
    sensor.see(calm, page=page)
    page.wait_for_selector(IDLE)
    page.fill(".pair .cameras .label", "steel/rusty")
    sensor.see(pressed[5], page=page)
    # at least two of this contact: more of the first one may have come before it ended
    page.wait_for_selector(".pair .cameras .rate:has-text('6 pairs recorded')")
    with page.expect_download() as saved:
        page.click(".pair .cameras [data-send=camerasSwitched]")
    with ZipFile(saved.value.path()) as archive:
        archive.extractall(tmp_path)
    line = [
        "import",
        str(tmp_path / "My sensor"),
        "--out",
        str(tmp_path / "pairs"),
        "--frames",
        "2",
    ]
    assert main(line) == 0
    found = read_pairs(tmp_path / "pairs")
    assert len(found.pairs) == 4 and found.domains() == ("My sensor",)
    assert len(found.materials()) == 2
    page.wait_for_selector(ANSWERED)


def test_another_crop_drops_the_rest_picture_and_says_so_until_it_is_taken_again(live):
    page = live(vis={"device": "none"})
    take_rest(page)
    page.wait_for_selector(IDLE)
    page.select_option(".pair .feed[data-modality=tac] .crop", "border")
    page.wait_for_selector(STATE.format("was dropped"))
    page.wait_for_selector(TOUCHED)
    assert "Take it again" in page.locator(STATE.format("was dropped")).inner_text()
    take_rest(page)
    page.wait_for_selector(IDLE)


def test_an_unplugged_camera_ends_live_in_a_sentence(live):
    page = live(vis={"device": "none"})
    page.evaluate(
        """() => { for (const { srcObject } of window.videos)
          srcObject?.getTracks().forEach((track) => {
          track.stop();
          track.dispatchEvent(new Event('ended'));
        }); }"""
    )
    page.wait_for_selector(STATE.format("was disconnected"))
    page.wait_for_selector(".pair .cameras .rate:has-text('no source is left')")
    page.wait_for_selector(ANSWERED)


def named(name, seed):
    """Return a picture of noise as a file of this name."""
    return texture(seed) | {"name": name}


def test_many_pairs_become_a_table_and_a_csv(open_page):
    page = open_page("?view=pair", ANSWERED)
    files = [
        named(f"{k}_{m}.png", 60 + k + 10 * i)
        for k in range(3)
        for i, m in enumerate(("vis", "tac"))
    ]
    broken = {"name": "3_vis.png", "mimeType": "image/png", "buffer": b"no picture"}
    page.set_input_files(".pair .pairs input >> nth=0", [*files, broken, named("alone.png", 1)])
    page.wait_for_selector(".pair .many table")
    assert page.locator(".pair .many tbody tr").count() == 4
    assert "3 guesses" in page.inner_text(".pair .many h3")
    assert "1 picture left out" in page.inner_text(".pair .many .hint")
    assert "3_vis.png" in page.inner_text(".pair .many td.wrong")
    with page.expect_download() as saved:
        page.click(".pair .many [data-send=csv]")
    lines = saved.value.path().read_text(encoding="utf-8").splitlines()
    assert len(lines) == 5
    page.click(".pair .many .link >> nth=1")
    holds(page, "tac", "1_tac.png")
    page.wait_for_selector(f"{SLOT.format('tac')} .picture img")


def test_a_profile_of_my_sensor_is_followed_and_survives_a_reload(open_page):
    page = open_page("?view=pair", ANSWERED, size=(1440, 900))
    send(page, "tac", 70)
    files = [named(f"{k}_tac.png", 71 + k) for k in range(6)]
    broken = {"name": "9_tac.png", "mimeType": "image/png", "buffer": b"no picture"}
    page.click(".pair .sensor summary")
    page.set_input_files(".pair .sensor [data-side=now] input >> nth=0", [*files, broken])
    page.wait_for_selector(".pair .sensor:has-text('touch 7')")  # which has no card
    page.click(".pair .sensor [data-send=sampled]")
    page.wait_for_selector(".pair .sensor:has-text('profile of 6 touches')")
    assert "1 picture was left out" in page.inner_text(".pair .sensor")
    page.wait_for_selector(".pair .sensor table")
    with page.expect_download() as saved:
        page.click(".pair .sensor [data-send=saveProfile]")
    assert saved.value.path().stat().st_size > 5000
    page.reload()
    page.wait_for_selector(".pair .profile-now:has-text('profile of 6 touches')")
    page.click(".pair .sensor summary")
    page.click(".pair .sensor [data-send=profileDropped]")
    page.wait_for_selector(".pair .sensor:has-text('unlabelled pictures')")


def test_a_mirrored_sensor_is_named_and_one_click_reads_its_touches_as_the_old_ones(
    open_page, tmp_path
):
    page = open_page("?view=pair", ANSWERED, size=(1280, 720), permissions=["camera"])
    scripts = "performance.getEntriesByType('resource').map(({ name }) => name).join()"
    assert "pair/sensor.js" not in page.evaluate(scripts)  # it comes when the panel opens
    for name, mirror in (("new", True), ("old", False)):
        (tmp_path / name).mkdir()
        for k, file in enumerate(sorted((EXAMPLES / "pairs" / "TAG-sim").glob("*/*_tac.jpg"))):
            with Image.open(file) as image:
                picture = np.asarray(image)[:, ::-1] if mirror else np.asarray(image)
            Image.fromarray(np.ascontiguousarray(picture)).save(tmp_path / name / f"{k}.png")
    page.focus(".pair .sensor summary")
    page.keyboard.press("Enter")
    folder = ".pair .sensor [data-side={}] [webkitdirectory]"
    page.set_input_files(folder.format("now"), tmp_path / "new")
    page.wait_for_selector(".pair .sensor .rose")
    assert "red from" in page.get_attribute(".pair .sensor .rose", "aria-label")
    page.wait_for_selector(f"{SLOT.format('tac')} .what:has-text('.png')")  # the first one opens
    settle(page)
    page.set_input_files(folder.format("before"), tmp_path / "old")
    page.wait_for_selector(".pair .sensor .changes b:has-text('Mirrored')")
    assert page.locator(".pair .sensor .changes li").count() == 1
    assert page.locator(".pair .sensor .drawn").count() == 2
    page.focus(".pair .sensor .changes button")
    page.keyboard.press("Enter")
    page.wait_for_selector(".pair .sensor table:has-text('mended') tbody tr")
    assert page.get_attribute(".pair .sensor .changes button", "aria-pressed") == "true"
    assert "mirrored from left to right" in page.inner_text(".pair .profile-now")
    page.evaluate("localStorage['omnivat-live-vis'] = JSON.stringify({ device: 'none' })")
    page.reload()  # after which touches are read so, too, and those of Live
    page.wait_for_selector(".pair .profile-now:has-text('mirrored from left to right')")
    page.wait_for_selector(ANSWERED)
    page.held = True
    page.click(".pair .cameras > summary")
    mends = []

    def noted(route):
        mends.append(pictured(route.request)[0].get("mend"))
        route.continue_()

    page.route("**/omnivat/live?*", noted)
    page.click(".pair .cameras [data-send=camerasSwitched]")
    page.wait_for_selector(".pair .verdict .tag:has-text('live')")
    assert set(mends) == {"left-right"}
    page.click(".pair .profile-now button")
    page.wait_for_selector(".pair .profile-now", state="hidden")
    while mends[-1] is not None:
        page.wait_for_timeout(20)
    page.unroute("**/omnivat/live?*")
    page.click(".pair .cameras [data-send=camerasSwitched]")


def own_folder(to, domains):
    """Write example pairs of two classes as a folder without classes; return their labels by
    number.
    """
    labels = []
    for domain in domains:
        for label in ("wood", "glass"):
            for photo in sorted((EXAMPLES / "pairs" / f"{domain}-sim" / label).glob("*_vis.*"))[:2]:
                for kind in ("vis", "tac"):
                    file = to / f"{len(labels)}_{kind}.jpg"
                    file.parent.mkdir(parents=True, exist_ok=True)
                    copyfile(photo.with_name(photo.name.replace("_vis", f"_{kind}")), file)
                labels.append(label)
    return labels


def test_a_folder_goes_from_a_drop_to_predictions_of_the_next_pictures_by_the_taught_head(
    open_page, tmp_path
):
    labels = own_folder(tmp_path / "first", ("TQ-DIGIT", "OF Real"))
    own_folder(tmp_path / "next", ("TQ-GelMini",))
    page = open_page("?view=pair", ANSWERED)
    line = page.locator(".pair .line")
    assert "Drop photos" in line.inner_text()
    page.set_input_files(FOLDER, tmp_path / "first")
    page.wait_for_selector(".pair .many table")
    settle(page)
    assert "a profile of 20 unlabelled pictures raises accuracy" in line.inner_text()
    assert (
        page.locator(".pair .own:has-text('What is the true class?')").count() == 1
    )  # the first opens
    before = page.inner_text(".pair .many tbody")
    names = page.locator(".pair .many .link").all_inner_texts()
    for row, name in enumerate(names):
        page.fill(f".pair .many [data-label='{row}']", labels[int(name.split("/")[-1])])
        page.keyboard.press("Tab")
    assert f"Teach the head your {len(labels)} pairs" in line.inner_text()
    page.click(".pair .many [data-send=rowsTaught]")
    page.wait_for_selector(".pair .taught table")
    settle(page)
    assert "each pair predicted without its own label" in line.inner_text()
    assert page.inner_text(".pair .many tbody") != before
    assert "objects a class" in page.inner_text(".pair .labels-bring p")
    assert page.locator(".pair .labels-bring .mean").count() == 1
    assert page.locator(".pair .many small:has-text('used for teaching')").count() == len(labels)
    page.set_input_files(FOLDER, tmp_path / "next")
    page.wait_for_selector(".pair .many:has-text('4 pairs:'):has-text('those that you labelled')")
    page.click(".pair .many .link >> nth=0")
    page.wait_for_selector(".pair .familiar:has-text('your labelled photos')")


def test_photos_given_as_touches_are_asked_about_and_their_profile_can_be_taken_away_where_it_acts(
    open_page, tmp_path
):
    own_folder(tmp_path / "own", ("TQ-DIGIT", "OF Real"))
    photos = tmp_path / "photos"
    photos.mkdir()
    for file in (tmp_path / "own").glob("*_vis.jpg"):
        copyfile(file, photos / file.name.replace("_vis", ""))
    page = open_page("?view=pair", ANSWERED, size=(1440, 900))
    page.click(".pair .sensor summary")
    page.set_input_files(".pair .sensor [data-side=now] [webkitdirectory]", photos)
    page.click(".pair .sensor [data-send=sampled]")
    page.wait_for_selector(".pair .sensor [role=status]:has-text('look more like photos')")
    page.click(".pair .sensor [data-kind=vis]")
    page.wait_for_selector(".pair .profile-now:has-text('the profile of 8 photos')")
    page.click(".pair .profile-now button")
    page.wait_for_selector(".pair .profile-now", state="hidden")


def test_pictures_whose_names_tell_nothing_are_asked_about(open_page):
    page = open_page("?view=pair", ANSWERED)
    page.set_input_files(".pair .pairs input >> nth=0", [named("7.png", 7), named("8.png", 8)])
    page.click(".pair .many [data-kind=tac]")
    page.wait_for_selector(".pair .many table")
    assert page.locator(".pair .many tbody tr").count() == 2


def test_reading_many_pairs_can_be_cancelled(open_page):
    page = open_page("?view=pair", ANSWERED)
    page.route("**/omnivat/many?*", lambda route: None)  # the server never replies
    page.set_input_files(
        ".pair .pairs input >> nth=0", [named("a_vis.png", 1), named("b_vis.png", 2)]
    )
    page.wait_for_selector(".pair .many [data-send=stopped]")
    page.wait_for_selector(".pair .many:has-text('2 of 2')")
    page.click(".pair .many [data-send=stopped]")
    page.wait_for_selector(".pair .many:has-text('Cancelled after 0 of 2 pairs')")
    page.unroute("**/omnivat/many?*")


def test_a_photo_is_shown_whole(open_page):
    page = open_page("?view=pair", ANSWERED)
    fits = page.evaluate(
        "[...document.querySelectorAll('.pair .picture img')].map((e) =>"
        " getComputedStyle(e).objectFit)"
    )
    assert fits == ["contain", "contain"]


def test_the_relief_of_a_touch_turns_and_is_saved_and_own_touches_or_a_profile_give_its_lamps(
    open_page, tmp_path
):
    page = open_page("?view=pair", ANSWERED)
    page.locator(".pair .gallery button").first.click()
    page.wait_for_selector(f"{SLOT.format('tac')} .picture img[src*=example]")
    assert not page.locator(".pair .relief .js-plotly-plot").count()  # nothing is loaded before
    page.click(".pair .relief summary")
    page.wait_for_selector(".pair .relief [data-as=ply]")
    eye = "() => document.querySelector('.relief .js-plotly-plot')._fullLayout.scene.camera.eye.x"
    before = page.evaluate(eye)
    page.focus(".pair .relief .surface")
    page.keyboard.press("ArrowRight")
    page.wait_for_function(f"before => ({eye})() !== before", arg=before)
    for kind, first in (("png", b"\x89PNG"), ("npy", b"\x93NUMPY"), ("ply", b"ply\n")):
        with page.expect_download() as saved:
            page.click(f".pair .relief [data-as={kind}]")
        with open(saved.value.path(), "rb") as file:
            assert file.read(len(first)) == first
    send(page, "tac", 1)
    page.wait_for_selector(".pair .relief .hint:has-text('4 more pictures of your sensor')")
    files = sorted((EXAMPLES / "pairs" / "TAG-sim").glob("*/*_tac.jpg"))[:5]
    lit = lamps(np.asarray(Image.open(file).convert("RGB")) for file in files)
    mine = replace(load_head(default_head()).source_profile, lamps=lit)
    save_profile(tmp_path / "mine.safetensors", mine)
    page.click(".pair .sensor summary")
    page.set_input_files(
        ".pair .sensor label:has-text('Load profile') input", tmp_path / "mine.safetensors"
    )
    known = "lamps in the profile of your sensor, which 5 touches gave"
    page.wait_for_selector(f".pair .relief .hint:has-text('{known}')")
    page.wait_for_selector(".pair .relief .js-plotly-plot")
