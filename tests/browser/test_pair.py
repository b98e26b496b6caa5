"""Try a pair: one journey for each action."""

import re
from io import BytesIO
from shutil import copyfile
from urllib.parse import parse_qs, urlsplit
from zipfile import ZipFile

import numpy as np
import pytest
from PIL import Image

from omnivat.cli import main
from omnivat.data.readers import read_pairs
from omnivat.head.heads import EXAMPLES

from .conftest import watched
from .fake_sensor import CAMERAS
from .gestures import ANSWERED, SLOT, holds, send, settle, texture

pytestmark = pytest.mark.browser


PAIR = "?view=pair&vis=row:0&tac=row:0"
FOLDER = ".pair .pairs label:has-text('Folder') input"


def said(page, reading):
    """Return what one reading predicts, in the words of the page."""
    return page.inner_text(f".pair .reading[data-reading={reading}]")


def unfold(page, part):
    """Open a part that is folded away, unless it is open."""
    if not page.locator(f".pair .{part}[open]").count():
        page.click(f".pair .{part} > summary")


@pytest.fixture
def pair(visit):
    """Return the tab with a pair of the set, and without what the test before left there."""
    page = visit(PAIR, ANSWERED)
    for left in (".chips .drop", ".many [data-send=closed]", ".profile-now button"):
        while page.locator(f".pair {left} >> visible=true").count():
            page.click(f".pair {left} >> nth=0")
    settle(page)
    return page


def test_the_relief_of_a_touch_turns_is_saved_and_asks_for_more_of_own_touches(pair):
    pair.locator(".pair .gallery button").first.click()
    pair.wait_for_selector(f"{SLOT.format('tac')} .picture img[src*=example]")
    assert not pair.locator(".pair .relief .js-plotly-plot").count()  # nothing is loaded before
    unfold(pair, "relief")
    pair.wait_for_selector(".pair .relief [data-as=ply]")
    eye = "() => document.querySelector('.relief .js-plotly-plot')._fullLayout.scene.camera.eye.x"
    before = pair.evaluate(eye)
    pair.focus(".pair .relief .surface")
    pair.keyboard.press("ArrowRight")
    pair.wait_for_function(f"before => ({eye})() !== before", arg=before)
    for kind, first in (("png", b"\x89PNG"), ("ply", b"ply\n")):
        with pair.expect_download() as saved:
            pair.click(f".pair .relief [data-as={kind}]")
        assert saved.value.path().read_bytes().startswith(first)
    send(pair, "tac", 1)
    pair.wait_for_selector(".pair .relief .hint:has-text('4 more pictures of your sensor')")
    assert not pair.locator(".pair .relief .js-plotly-plot").count()  # of the touch before
    pair.click(".pair .relief summary")


def test_p_is_moved_in_a_section_of_its_own_whose_letters_are_whole_and_leaves_the_prediction(pair):
    prediction = said(pair, "fused")
    unfold(pair, "what-if-p")
    pair.wait_for_selector(".pair .lines svg .band")
    cut = pair.evaluate(
        """() => [...document.querySelectorAll('.pair .what-if-p .lines text')].filter((text) => {
          const [own, all] = [text, text.ownerSVGElement].map((e) => e.getBoundingClientRect());
          return own.left < all.left - 1 || own.right > all.right + 1;
        }).map((text) => text.textContent)"""
    )
    assert cut == []
    before = pair.inner_text(".pair .at-p")
    pair.focus(".pair .order")
    pair.keyboard.press("ArrowLeft")
    pair.wait_for_function(
        "before => document.querySelector('.pair .at-p').innerText !== before", arg=before
    )
    assert said(pair, "fused") == prediction
    assert "chance" in pair.inner_text(".pair .about-p")


def test_own_pairs_are_guesses_at_first_then_counted_taught_explained_saved_and_forgotten(pair):
    for seed, label in ((20, "wood"), (21, "wood"), (22, "cork"), (23, "cork")):
        for modality, of in (("vis", seed), ("tac", seed + 10)):
            send(pair, modality, of)
        for reading in ("fused", "vis", "tac"):
            assert "This is a guess" in said(pair, reading)
            assert "%" not in said(pair, reading)
        own = pair.locator(f".pair .labels button[data-label='{label}']")
        if own.count():
            own.click()
        else:
            pair.fill(".pair .labels input", label)
            pair.keyboard.press("Enter")
        pair.wait_for_selector(f".pair .chips li:has-text('{seed}.png')")
    assert pair.locator(".pair .nearest button").count() == 6
    assert "of 4" in pair.inner_text(".pair .tally")
    pair.click(".pair .own [data-send=teach]")
    pair.wait_for_selector(".pair .taught table")
    report = pair.inner_text(".pair .taught p")
    assert re.search(r"Correct before teaching: \d of 4\. After teaching: \d of 4\.", report)
    pair.wait_for_selector(".pair .taught-now")
    assert pair.locator(".pair .bars th:has-text('cork')").count() == 1
    slot = SLOT.format("vis")
    pair.click(f"{slot} .where")
    pair.wait_for_selector(f"{slot} .what .tag:has-text('taught')")
    what = pair.inner_text(f"{slot} .what")
    headline = pair.inner_text(".pair .reading[data-reading=fused] .said")
    assert headline.split()[0].rstrip("?") in what
    tinted = pair.locator(f"{slot} .picture canvas").count()
    assert tinted == ("no single part matters" not in what)
    for button in ("[data-path='save/set']", "[data-path='save/head']", "[data-send=savePictures]"):
        with pair.expect_download() as saved:
            pair.click(f".pair {button}")
        assert saved.value.path().read_bytes()[:2] == b"PK"
    pair.click(".pair [data-send=used]")  # the explanation of the taught head goes with it
    pair.wait_for_selector(".pair .taught-now", state="detached")
    assert "taught" not in pair.inner_text(f"{slot} .what")
    for _ in range(4):
        pair.click(".pair .chips .drop >> nth=0")
    assert not pair.locator(".pair .tally").count()


def test_a_second_click_while_the_camera_opens_leaves_it_off_and_without_one_live_says_why(pair):
    unfold(pair, "cameras")
    pair.evaluate("""() => {
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
    pair.wait_for_function("window.streams.length === 1")
    pair.wait_for_function(
        "window.streams.every((one) => one.getTracks().every((t) => t.readyState === 'ended'))"
    )
    off = ".pair .cameras [data-send=camerasSwitched][aria-pressed=false]"
    pair.wait_for_selector(off)
    pair.evaluate("""() => {
          navigator.mediaDevices.getUserMedia = async () => { throw new Error("denied"); };
        }""")
    pair.click(off)
    pair.wait_for_selector(".pair .problem:has-text('camera')")
    pair.wait_for_selector(off)
    pair.wait_for_selector(ANSWERED)
    pair.evaluate("delete navigator.mediaDevices.getUserMedia")


# requests of Live wait, so that its frames leave the processor to what is looked at
CALM = """const fetched = window.fetch;
window.fetch = async (to, ...more) => {
  if (`${to}`.includes("omnivat/live")) await new Promise((done) => setTimeout(done, 300));
  return fetched(to, ...more);
};"""


FEED = ".pair .feed[data-modality={}] "


@pytest.fixture(scope="module")
def filmed(desktop, address):
    """Return a page that has two cameras."""
    page = watched(desktop.new_page(), address, problems := [])
    page.add_init_script(f"{{{CAMERAS}{CALM}}}")
    page.goto(address + PAIR)
    page.wait_for_selector(ANSWERED)
    page.held = True  # Live always has a frame on its way
    page.click(".pair .cameras > summary")
    yield page
    page.close()
    assert problems == []


@pytest.fixture
def live(filmed, sensor, presses):
    """Return an opener of Live: two cameras, or that of the touch alone, see a real sensor at rest,
    and Live is started. It is stopped afterwards.
    """

    def opened(name="gelsight", photo="Webcam"):
        sensor.see(presses(name)[0])
        filmed.click(".pair .cameras [data-send=camerasSwitched]")
        filmed.wait_for_selector(".pair .verdict .tag:has-text('live')")
        filmed.select_option(FEED.format("vis") + ".device", label=photo)
        crop = FEED.format("tac") + ".crop"  # another name of the whole picture drops an old rest
        filmed.select_option(crop, "" if filmed.input_value(crop) else "4:3")
        filmed.wait_for_selector(TOUCHED)
        return filmed

    yield opened
    filmed.evaluate("document.querySelector('.cameras [aria-pressed=true].main')?.click()")


def take_rest(page):
    """Take the rest picture."""
    page.click(".pair .cameras [data-what=rest]")
    page.wait_for_selector(STATE.format("mean of 10 frames"))


STATE = FEED.format("tac") + ".state:has-text('{}')"
TOUCHED = ".pair .verdict .reading[data-reading=tac]"
SIDE_BY_SIDE = """() => ['.feed', '.verdict']
  .map((name) => document.querySelector(`.pair ${name}`).getBoundingClientRect())
  .every(({ top, bottom }) => top < innerHeight - 100 && bottom > 100)"""
IDLE = ".pair .verdict:has-text('No contact')"


def test_live_gives_a_class_to_a_real_press_and_none_to_a_sensor_at_rest(live, sensor, presses):
    calm, pressed = presses("gelsight_mini")
    page = live("gelsight_mini")
    assert page.evaluate(SIDE_BY_SIDE)
    names = page.locator(".pair .feed .device option:checked").all_inner_texts()
    assert names == ["Webcam", "Sensor"]
    page.wait_for_selector(".pair .cameras .rate:has-text('ms from camera')")
    take_rest(page)
    page.wait_for_selector(IDLE)
    assert page.locator(TOUCHED).count() == 0
    for k in (0, len(pressed) - 1):
        sensor.see(pressed[k], page=page)
        page.wait_for_selector(TOUCHED)
        assert page.locator(".pair .verdict .reading").count() == 3
        sensor.see(calm, page=page)
        page.wait_for_selector(IDLE)


def test_no_rest_picture_is_made_of_a_touched_sensor_and_another_crop_drops_it(
    live, sensor, presses
):
    calm, pressed = presses("gelsight")
    page = live(photo="none")
    sensor.see(calm, calm, pressed[0], page=page)
    page.click(".pair .cameras [data-what=rest]")
    page.wait_for_selector(STATE.format("without touching"))
    page.wait_for_selector(TOUCHED)
    sensor.see(calm, page=page)
    take_rest(page)
    page.wait_for_selector(IDLE)
    page.select_option(FEED.format("tac") + ".crop", "border")
    page.wait_for_selector(STATE.format("was dropped"))
    page.wait_for_selector(TOUCHED)
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


def test_a_slow_server_gets_the_newest_frame_and_an_unplugged_camera_ends_live_in_a_sentence(
    live, sensor, presses
):
    pressed = presses("gelsight")[1]
    scenes = [presses("gelsight")[0], pressed[0], pressed[24], presses("gelsight_mini")[0]]
    page = live(photo="none")
    held = []
    sent = []
    waits = True

    def take(route):
        size = int(parse_qs(urlsplit(route.request.url).query)["sizes"][0].split(",")[0])
        sent.append(shown(route.request.post_data_buffer[size:], scenes))
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


RECORDED = "document.querySelector('.pair .cameras .rate').textContent.match(/(\\d+) pairs rec/)"


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
    # at least two of this contact, however many of the first one had come before it ended
    number = page.wait_for_function(f"{RECORDED}?.[1]").json_value()
    page.wait_for_function(f"+{RECORDED}?.[1] >= {int(number) + 2}")
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


def named(name, seed):
    """Return a picture of noise as a file of this name."""
    return texture(seed) | {"name": name}


def test_many_pairs_become_a_table_that_names_what_it_cannot_take_and_teaches_nothing_yet(pair):
    choose = ".pair .pairs input >> nth=0"
    files = [
        named(f"{k}_{m}.png", 60 + k + 10 * i)
        for k in range(3)
        for i, m in enumerate(("vis", "tac"))
    ]
    broken = {"name": "3_vis.png", "mimeType": "image/png", "buffer": b"no picture"}
    lines = [f"{k}_vis.png,{k}_tac.png,{label}" for k, label in enumerate(("a", "b", 41 * "x", ""))]
    table = "\n".join(["vis,tac,label", *lines]).encode()
    table = {"name": "t.csv", "mimeType": "text/csv", "buffer": table}
    pair.set_input_files(choose, [*files, broken, named("alone.png", 1), table])
    pair.wait_for_selector(".pair .many table")
    settle(pair)
    assert pair.locator(".pair .many tbody tr").count() == 4
    assert "2 guesses" in pair.inner_text(".pair .many h3")
    assert "1 picture left out" in pair.inner_text(".pair .many .hint")
    wrong = pair.locator(".pair .many td[colspan]").all_inner_texts()
    assert "41 letters; at most 40" in wrong[0] and "3_vis.png" in wrong[1]
    assert pair.is_disabled(".pair .many [data-send=rowsTaught]")
    pair.fill(".pair .many input[name=value] >> nth=0", "b")
    pair.keyboard.press("Tab")
    pair.wait_for_selector(".pair .line:has-text('So far: b 2.')")
    with pair.expect_download() as saved:
        pair.click(".pair .many [data-send=csv]")
    lines = saved.value.path().read_text(encoding="utf-8").splitlines()
    assert len(lines) == 5
    pair.click(".pair .many .link >> nth=1")
    holds(pair, "tac", "1_tac.png")
    pair.wait_for_selector(f"{SLOT.format('tac')} .picture img")


def test_pictures_whose_names_tell_nothing_are_asked_about_and_reading_them_can_be_cancelled(pair):
    choose = ".pair .pairs input >> nth=0"
    pair.set_input_files(choose, [named("7.png", 7), named("8.png", 8)])
    pair.click(".pair .many [data-kind=tac]")
    pair.wait_for_selector(".pair .many table")
    assert pair.locator(".pair .many tbody tr").count() == 2
    pair.route("**/omnivat/many?*", lambda route: None)  # the server never replies
    pair.set_input_files(choose, [named("a_vis.png", 99)])
    pair.wait_for_selector(".pair .many:has-text('1 of 1')")
    pair.click(".pair .many [data-send=stopped]")
    pair.wait_for_selector(".pair .many:has-text('Cancelled after 0 of 1 pairs')")
    pair.unroute("**/omnivat/many?*")


def test_a_mirrored_sensor_is_named_and_mended_and_its_profile_gives_lamps_and_survives_a_reload(
    pair, tmp_path
):
    scripts = "performance.getEntriesByType('resource').map(({ name }) => name).join()"
    assert "pair/sensor.js" not in pair.evaluate(scripts)  # it comes when the panel opens
    touches = sorted((EXAMPLES / "pairs" / "TAG-sim").glob("*/*_tac.jpg"))[:6]
    for name, mirror in (("new", True), ("old", False)):
        (tmp_path / name).mkdir()
        for k, file in enumerate(touches):
            with Image.open(file) as image:
                picture = np.asarray(image)[:, ::-1] if mirror else np.asarray(image)
            Image.fromarray(np.ascontiguousarray(picture)).save(tmp_path / name / f"{k}.png")
    pair.focus(".pair .sensor summary")
    pair.keyboard.press("Enter")
    folder = ".pair .sensor [data-side={}] [webkitdirectory]"
    pair.set_input_files(folder.format("now"), tmp_path / "new")
    pair.wait_for_selector(".pair .sensor .rose")
    assert "red from" in pair.get_attribute(".pair .sensor .rose", "aria-label")
    pair.wait_for_selector(f"{SLOT.format('tac')} .what:has-text('.png')")  # the first one opens
    settle(pair)
    pair.set_input_files(folder.format("before"), tmp_path / "old")
    pair.wait_for_selector(".pair .sensor .changes b:has-text('Mirrored')")
    assert pair.locator(".pair .sensor .changes li").count() == 1
    assert pair.locator(".pair .sensor .drawn").count() == 2
    pair.focus(".pair .sensor .changes button")
    pair.keyboard.press("Enter")
    pair.wait_for_selector(".pair .sensor table:has-text('mended') tbody tr")
    assert pair.get_attribute(".pair .sensor .changes button", "aria-pressed") == "true"
    assert "mirrored from left to right" in pair.inner_text(".pair .profile-now")
    files = [*(tmp_path / "new").iterdir()]
    broken = tmp_path / "broken.png"
    broken.write_bytes(b"no picture")
    pair.set_input_files(".pair .sensor [data-side=now] input >> nth=0", [*files, broken])
    pair.wait_for_selector(".pair .sensor:has-text('touch 7')")  # which has no card
    pair.click(".pair .sensor [data-send=sampled]")
    pair.wait_for_selector(".pair .sensor:has-text('profile of 6 touches')")
    assert "1 picture was left out" in pair.inner_text(".pair .sensor")
    with pair.expect_download() as saved:
        pair.click(".pair .sensor [data-send=saveProfile]")
    assert saved.value.path().stat().st_size > 5000
    pair.reload()  # after which touches are read so, too
    pair.wait_for_selector(".pair .profile-now:has-text('mirrored from left to right')")
    pair.wait_for_selector(".pair .profile-now:has-text('profile of 6 touches')")
    send(pair, "tac", 1)
    unfold(pair, "relief")
    known = "lamps in the profile of your sensor, which 6 touches gave"
    pair.wait_for_selector(f".pair .relief .hint:has-text('{known}')")
    pair.click(".pair .profile-now [data-send=profileDropped]")
    pair.click(".pair .profile-now [data-send=mended]")
    pair.wait_for_selector(".pair .profile-now", state="hidden")


def test_a_folder_goes_from_a_drop_to_predictions_of_the_next_pictures_by_the_taught_head(pair):
    folders = EXAMPLES / "pairs"
    pair.set_input_files(FOLDER, folders / "TQ-DIGIT-sim")
    pair.wait_for_selector(".pair .many table")
    settle(pair)
    line = pair.locator(".pair .line")
    assert "a profile of 20 unlabelled pictures raises accuracy" in line.inner_text()
    assert pair.locator(".pair .own:has-text('What is the true class?')").count()  # the first opens
    before = pair.inner_text(".pair .many tbody")
    pair.click(".pair .many [data-send=rowsTaught]")
    pair.wait_for_selector(".pair .taught table")
    settle(pair)
    assert "each pair predicted without its own label" in line.inner_text()
    assert pair.inner_text(".pair .many tbody") != before
    assert "Label a third object" in pair.inner_text(".pair .labels-bring p")
    assert pair.locator(".pair .many small:has-text('used for teaching')").count() == 8
    pair.set_input_files(FOLDER, folders / "TQ-GelMini-sim" / "wood")
    pair.wait_for_selector(".pair .many:has-text('2 pairs:'):has-text('those that you labelled')")
    pair.click(".pair .many .link >> nth=0")
    pair.wait_for_selector(".pair .familiar:has-text('your labelled photos')")


def test_photos_given_as_touches_are_asked_about_and_their_profile_can_be_taken_away_where_it_acts(
    pair, tmp_path
):
    for k, photo in enumerate((EXAMPLES / "pairs" / "TQ-DIGIT-sim").glob("[gw]*/*_vis.jpg")):
        copyfile(photo, tmp_path / f"{k}.jpg")
    unfold(pair, "sensor")
    pair.set_input_files(".pair .sensor [data-side=now] [webkitdirectory]", tmp_path)
    pair.click(".pair .sensor [data-send=sampled]")
    pair.wait_for_selector(".pair .sensor [role=status]:has-text('look more like photos')")
    pair.click(".pair .sensor [data-kind=vis]")
    pair.wait_for_selector(".pair .profile-now:has-text('the profile of 4 photos')")
    pair.click(".pair .profile-now button")
    pair.wait_for_selector(".pair .profile-now", state="hidden")
