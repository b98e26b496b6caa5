"""From file names of a repository to pairs, objects and labels."""

from collections import Counter

import pytest

from omnivat.data.fetching import fetched_sets
from omnivat.data.fetching.layouts import EACH, LAYOUTS, ROWS
from omnivat.kit.errors import DataError

OF = "assets/img/objectfolder/samples"
PAGE = """
| Index | Name | Material | Index | Name | Material |
| :---: | :---: | :---: | :---: | :---: | :---: |
| 1 | Soup_Spoon | Ceramic | 70 | Drop_Funnel | Polycarbonate |
| 71 | Lid | Iron | 97 | Frisbee | Plastic |
| 98 | Kettlebell | Iron | 82 | Can | Glass |
| 2 | Towel | Cotton | 81 | Jar | Glass |
"""


def pairs(name, names, page=""):
    return list(LAYOUTS[name](names, lambda _: page))


def test_every_set_in_a_repository_has_a_layout():
    assert LAYOUTS.keys() | ROWS.keys() == fetched_sets().keys() - {"tacquad"}
    git = [one for one in fetched_sets().values() if "/datasets/" not in one.source]
    assert git and all(len(one.commit) == 40 for one in git)


def test_vt60_takes_thirty_photos_and_touches_of_each_object_in_order():
    names = [
        f"v/vision/07_mug/02/IMG_inst_2_img_{k}_validframeID_{7 * k}.jpg" for k in range(1, 41)
    ]
    names += [
        f"v/touch/07_mug/02/touch_602_img_{k}_name_mug_red_at_1_-2_3.jpg" for k in range(1, 121)
    ]
    names += [
        "v/vision/07_mug/07/IMG_inst_7_img_1_validframeID_8.jpg",
        "v/touch/baselineForCalibration.jpg",
    ]
    found = pairs("vt60", names)
    assert len(found) == EACH and {(one.material, one.object) for one in found} == {
        ("mug", "mug 02")
    }
    numbers = [int(one.tac.split("_img_")[1].split("_")[0]) for one in found]
    assert numbers == list(range(1, 121, 4)) and len({one.vis for one in found}) == EACH


def test_the_copies_among_the_samples_of_objectfolder_shift_the_numbers_after_them():
    numbers = (1, 2, 70, 71, 72, 82, 83, 84, 100, 101)
    names = [f"{OF}/{n}/{half}/0.png" for n in numbers for half in ("visual", "tactile")] + [
        "_pages/x.md"
    ]
    found = {
        one.object: (one.material, one.named) for one in pairs("objectfolder-real", names, PAGE)
    }
    assert found == {
        "1 Soup_Spoon": ("ceramic", "Ceramic"),
        "70 Drop_Funnel": ("plastic", "Polycarbonate"),
        "71 Lid": ("steel", "Iron"),
        "81 Jar": ("glass", "Glass"),
        "82 Can": ("glass", "Glass"),
        "97 Frisbee": ("plastic", "Plastic"),
        "98 Kettlebell": ("steel", "Iron"),
    }


def test_a_table_with_a_cell_of_spaces_is_read_at_once_and_a_missing_one_is_a_sentence():
    names = [f"{OF}/1/{half}/0.png" for half in ("visual", "tactile")]
    wide = PAGE.replace("| Cotton |", f"|{' ' * 200_000}| 3 | a | b |")
    assert [one.object for one in pairs("objectfolder-real", [*names, "a.md"], wide)] == [
        "1 Soup_Spoon"
    ]
    with pytest.raises(DataError, match=r"no page \(\.md\)"):
        pairs("objectfolder-real", names)


def test_a_billet_is_one_object_in_each_state_of_its_surface():
    names = [
        f"camera_images/{state}/billet{n}_camera_{k}.jpg"
        for state in ("grinded", "non grinded")
        for n in (1, 2)
        for k in (1, 2)
    ]
    names += [
        f"billet_captures{end}/billet{n}_camera_{k}.png"
        for end in ("", "_grinded")
        for n in (1, 2)
        for k in (1,)
    ]
    found = pairs("billets", names)
    assert Counter(one.material for one in found) == {"ground": 2, "unground": 2}
    assert len({one.object for one in found}) == 4 and {one.named for one in found} == {"metal"}


def test_recordings_of_one_kind_keep_their_own_names():
    names = [f"data/{clip}/{part}_{k:03d}.png" for clip in ("rock", "rock2") for k in range(2)
             for part in ("video_frame/rgb_image", "gelsight_frame/touch_image")]  # fmt: skip
    found = pairs("tag-samples", [*names, "data/rock/video_frame/rgb_image_000_hd.png"])
    assert [(one.material, one.object) for one in found] == [("rock", "rock")] * 2 + [
        ("rock", "rock2")
    ] * 2


@pytest.mark.parametrize(
    ("folder", "material"),
    [
        ("WoodBoard2", "wood"),
        ("StainlessSteel1", "steel"),
        ("Denim", "denim"),
        ("AbsorbentMat1", "absorbent mat"),
    ],
)
def test_a_swatch_has_a_material_where_its_name_contains_one(folder, material):
    names = [f"Texture/{folder}/3.jpg", f"Texture/{folder}/3.pkl", f"Texture/{folder}/4.pkl"]
    (found,) = pairs("hapticmatch", names)
    assert (found.material, found.object) == (material, folder)


def test_touches_without_photos_keep_their_parts_as_classes():
    (clip,) = pairs("octopi", ["dataset/tv_remote_back_3.mov"])
    (press,) = pairs("digit-parts", ["data/hammer_head/interaction_0007.jpg"])
    assert (clip.material, clip.object, clip.vis) == ("tv remote back", "tv remote back 3", "")
    assert (press.material, press.object, press.vis) == ("hammer head", "hammer head 0007", "")


def test_a_still_is_one_file_with_two_boxes():
    (still,) = pairs("touch-and-go", ["resources/images/brick_eg.png"])
    photo, touch = still.boxes
    for left, top, right, bottom in still.boxes:
        assert 0 <= left < right <= 1 and 0 <= top < bottom <= 1
    assert still.vis == still.tac and touch[2] < photo[0], "they do not overlap"
