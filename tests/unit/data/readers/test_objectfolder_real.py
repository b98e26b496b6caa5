"""ObjectFolder Real: which frame, which camera, whole objects."""

import pytest

from omnivat.data.readers import read_pairs
from omnivat.kit.errors import DataError, SettingsError


@pytest.fixture
def press(tree):
    """Objects 1 to 6, two contacts each: five touch frames and nine of each camera."""
    names = ("Wood", "Wood", "Steel", "Iron", "Polycarbonate", "Rubber")
    frames = {"gelsight": 5, "third_view": 9, "in_hand": 9, "another": 9}
    contacts = [f"{thing}/tactile_data/{k}/0" for thing in range(1, 7) for k in range(2)]
    root = tree(*(f"{c}/{f}/{n}.png" for c in contacts for f in frames for n in range(frames[f])))
    rows = "".join(f"{i},{name}\n" for i, name in enumerate(names, start=1))
    (root / "materials.csv").write_text("object,material\n" + rows)
    return root


def test_each_contact_gives_its_middle_frame_and_the_hand_cameras(press):
    found = read_pairs(press)
    first = found.pairs[0]
    assert first.tac == press / "1/tactile_data/0/0/gelsight/2.png"
    assert first.vis == press / "1/tactile_data/0/0/in_hand/4.png"
    assert {p.domain for p in found.pairs} == {"OF Real"}
    assert len(found.pairs) == 10


@pytest.mark.parametrize(
    ("frames", "moments"), [("last", [(4, 8)]), ("all", [(0, 0), (1, 2), (2, 4), (3, 6), (4, 8)])]
)
def test_other_frames_of_the_press_and_another_camera_can_be_asked_for(press, frames, moments):
    found = read_pairs(press, frames=frames, camera="third_view").pairs[: len(moments)]
    assert [(int(p.tac.stem), int(p.vis.stem)) for p in found] == moments
    assert {p.vis.parent.name for p in found} == {"third_view"}


def test_objects_are_whole_in_train_or_test(press):
    found = read_pairs(press)
    splits = {p.object: {q.split for q in found.pairs if q.object == p.object} for p in found.pairs}
    assert all(len(names) == 1 for names in splits.values())
    assert splits["1"] != splits["2"]  # of two wooden objects one tests


def test_other_materials_and_lost_recordings_are_listed(press, reasons):
    for file in (press / "1/tactile_data/0/0/gelsight").iterdir():
        file.unlink()
    with (press / "materials.csv").open("a") as handle:
        handle.write("7,Wood\n")
    (press / "8" / "tactile_data").mkdir(parents=True)
    assert reasons(read_pairs(press)) == {
        "object 1": "no frames in gelsight",
        "object 6": "rubber: none of the five materials",
        "object 8": "the table of materials does not name it",
    }


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (None, "columns object,material"),
        ("object,materials\n1,Wood\n", "no column 'material'.* Did you mean 'materials'"),
        ("object,material\n1,Wood\n1,Glass\n", "gives '1' two values for material"),
    ],
)
def test_a_table_that_does_not_name_one_material_an_object_is_refused(press, table, message):
    (press / "materials.csv").unlink()
    if table:
        (press / "materials.csv").write_text(table)
    with pytest.raises(DataError, match=message):
        read_pairs(press)


def test_another_frame_or_camera_than_there_is_is_refused(press):
    with pytest.raises(SettingsError, match="Did you mean 'middle'"):
        read_pairs(press, frames="midle")
    with pytest.raises(DataError, match=r"no frames of a camera nowhere"):
        read_pairs(press, camera="nowhere")
