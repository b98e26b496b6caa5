"""ObjectFolder Real: which frame, which camera, whole objects."""

import pytest

from omnivat.data.readers import read_pairs
from omnivat.kit.errors import DataError, SettingsError


@pytest.fixture
def tree(tmp_path, put):
    """Objects 1 to 6, two contacts each: five touch frames and nine of each camera."""
    names = ("Wood", "Wood", "Steel", "Iron", "Polycarbonate", "Rubber")
    for thing in range(1, 7):
        for contact in range(2):
            recording = tmp_path / str(thing) / "tactile_data" / str(contact) / "0"
            for n in range(5):
                put(recording / "gelsight" / f"{n}.png")
            for n in range(9):
                put(recording / "third_view" / f"{n}.png")
                put(recording / "in_hand" / f"{n}.png")
                put(recording / "another" / f"{n}.png")
    rows = "".join(f"{i},{name}\n" for i, name in enumerate(names, start=1))
    (tmp_path / "materials.csv").write_text("object,material\n" + rows)
    return tmp_path


def test_each_contact_gives_its_middle_frame_and_the_hand_cameras(tree):
    found = read_pairs(tree)
    first = found.pairs[0]
    assert first.tac == tree / "1/tactile_data/0/0/gelsight/2.png"
    assert first.vis == tree / "1/tactile_data/0/0/in_hand/4.png"
    assert {p.domain for p in found.pairs} == {"OF Real"}
    assert len(found.pairs) == 10


@pytest.mark.parametrize(
    ("frames", "tac", "vis"), [("last", "4.png", "8.png"), ("all", "0.png", "0.png")]
)
def test_other_frames_of_the_press_can_be_asked_for(tree, frames, tac, vis):
    first = read_pairs(tree, frames=frames).pairs[0]
    assert (first.tac.name, first.vis.name) == (tac, vis)


def test_another_camera_can_be_asked_for(tree):
    assert read_pairs(tree, camera="third_view").pairs[0].vis.parent.name == "third_view"


def test_iron_is_steel_and_polycarbonate_plastic_unless_strict(tree):
    assert read_pairs(tree).materials() == ("wood", "steel", "plastic")
    strict = read_pairs(tree, strict=True)
    assert {p.object for p in strict.pairs} == {"1", "2", "3"}
    assert "strict: iron is not steel itself" in {s.why for s in strict.skipped}


def test_objects_are_whole_in_train_or_test(tree):
    found = read_pairs(tree)
    splits = {p.object: {q.split for q in found.pairs if q.object == p.object} for p in found.pairs}
    assert all(len(names) == 1 for names in splits.values())
    assert splits["1"] != splits["2"]  # of two wooden objects one tests


def test_other_materials_and_lost_recordings_are_listed(tree):
    for file in (tree / "1/tactile_data/0/0/gelsight").iterdir():
        file.unlink()
    with (tree / "materials.csv").open("a") as handle:
        handle.write("7,Wood\n")
    (tree / "8" / "tactile_data").mkdir(parents=True)
    whys = {s.what: s.why for s in read_pairs(tree).skipped}
    assert whys["object 1"] == "no frames in gelsight"
    assert whys["object 6"] == "rubber: none of the five materials"
    assert whys["object 8"] == "the table of materials does not name it"


def test_a_missing_table_of_materials_is_asked_for(tree):
    (tree / "materials.csv").unlink()
    with pytest.raises(DataError, match="columns object,material"):
        read_pairs(tree)


def test_a_table_without_names_in_its_first_row_is_refused(tree):
    (tree / "materials.csv").write_text("object,materials\n1,Wood\n")
    with pytest.raises(DataError, match="no column 'material'.* Did you mean 'materials'"):
        read_pairs(tree)


def test_an_object_of_two_materials_is_refused(tree):
    (tree / "materials.csv").write_text("object,material\n1,Wood\n1,Glass\n")
    with pytest.raises(DataError, match="gives '1' two values for material"):
        read_pairs(tree)


def test_an_unknown_frame_gets_a_suggestion(tree):
    with pytest.raises(SettingsError, match="Did you mean 'middle'"):
        read_pairs(tree, frames="midle")


def test_no_camera_of_that_name_leaves_no_pair(tree):
    with pytest.raises(DataError, match=r"no frames of a camera nowhere"):
        read_pairs(tree, camera="nowhere")
