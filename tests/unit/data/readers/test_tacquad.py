"""TacQuad: ranges, moments, typing slips, parts, and fields that become images."""

from collections import Counter

import numpy as np
import pytest

from omnivat.data.readers import read_pairs
from omnivat.data.readers.tacquad import material_of
from omnivat.kit.errors import DataError


@pytest.fixture
def item(tree):
    """Write the frames of one item: 70 of each sensor, 72 images of GelSight."""

    def write(part, name, frames=70):
        images = {"gelsight": frames + 2, "digit": frames, "duragel": frames}
        counts = {f"img_{sensor}": number for sensor, number in images.items()}
        counts |= dict.fromkeys(images, frames)
        return tree(*(f"data_{part}/{name}/{f}/{n}.png" for f in counts for n in range(counts[f])))

    return write


@pytest.fixture
def root(item, tmp_path, monkeypatch):
    """Two items in each part; the first indoor range is frames 3 to 62 of GelSight."""
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "cache"))
    for part, name in (
        ("in", "galss_cup"),
        ("in", "woodblock"),
        ("out", "steel_rail"),
        ("out", "bench"),
    ):
        root = item(f"{part}door", name)
    (root / "contact_indoor.csv").write_text(
        "galss_cup,3,62,0,69,5,5\nwoodblock,0,69,0,69,0,69,a block of oak\n"
    )
    (root / "contact_outdoor.csv").write_text(
        "steel_rail,0,69,0,69,0,69\nbench,0,59,0,69,0,69,A platic bench\n"
    )
    return root


def of(pairs, domain, part, name):
    return [p for p in pairs.pairs if (p.domain, p.part, p.object) == (domain, part, name)]


def test_ranges_include_their_first_and_last_frame(root):
    found = read_pairs(root, all_frames=True)
    numbers = [int(p.tac.stem) for p in of(found, "TQ-GelMini", "indoor", "galss_cup")]
    assert numbers == list(range(3, 63))
    assert len(of(found, "TQ-DuraGel", "indoor", "galss_cup")) == 1


def test_frame_t_goes_with_the_image_of_the_same_moment(root):
    """72 images for 70 touches: int(t / 70 * 72), for numbers that sort as numbers."""
    found = read_pairs(root, all_frames=True)
    moments = {
        int(p.tac.stem): int(p.vis.stem) for p in of(found, "TQ-GelMini", "outdoor", "steel_rail")
    }
    assert moments == {t: int(t / 70 * 72) for t in range(70)}
    assert moments[69] == 70


def test_indoor_items_test_and_outdoor_items_train_and_test(root):
    found = read_pairs(root)
    counts = Counter((p.part, p.object, p.split) for p in found.pairs if p.domain == "TQ-DIGIT")
    assert counts == {
        ("indoor", "galss_cup", "test"): 15,
        ("indoor", "woodblock", "test"): 15,
        ("outdoor", "steel_rail", "train"): 41,
        ("outdoor", "steel_rail", "test"): 15,
        ("outdoor", "bench", "train"): 41,
        ("outdoor", "bench", "test"): 15,
    }
    assert found == read_pairs(root)
    assert found.pairs != read_pairs(root, seed=1).pairs


def test_items_can_be_kept_whole(root):
    found = read_pairs(root, by_object=True)
    sides = {p.object: {q.split for q in found.pairs if q.object == p.object} for p in found.pairs}
    assert all(len(splits) == 1 for splits in sides.values())


@pytest.mark.parametrize(
    ("item", "caption", "material"),
    [
        ("grass", "", ""),
        ("school_class", "brass medal", ""),
        ("box", "an iron box", "steel"),
        ("Wooden-Spoon2", "made of plastic", "wood"),
        ("cup", "a glass cup with a wooden lid", ""),
        ("glass_and_steel", "glass", ""),
        ("metla_lid", "", "steel"),
        ("", "", ""),
    ],
)
def test_an_item_is_what_its_words_say_or_nothing(item, caption, material):
    found, why = material_of(item, caption, {})
    assert found == material
    assert bool(why) != bool(found)


def test_the_table_of_materials_overrides_the_words(root, reasons):
    (root / "materials.csv").write_text("item,material\ngalss_cup,Plastic\nbench,\n")
    found = read_pairs(root)
    assert {p.material for p in found.pairs if p.object == "galss_cup"} == {"plastic"}
    assert reasons(found)["outdoor/bench"] == ("left out by the table of materials")


def test_an_override_beyond_the_five_is_refused(root):
    (root / "materials.csv").write_text("item,material\nbench,plastik\n")
    with pytest.raises(DataError, match="calls 'bench' plastik.*Did you mean 'plastic'"):
        read_pairs(root)


def test_strict_leaves_out_other_metals(root, reasons):
    (root / "contact_outdoor.csv").write_text("bench,0,59,0,69,0,69,an iron bench\n")
    found = read_pairs(root, strict=True)
    assert reasons(found)["outdoor/bench"] == "strict: iron is not steel itself"


def test_items_stored_under_another_name_are_found(root, item):
    item("indoor", "shuttlecock", frames=16)
    with (root / "contact_indoor.csv").open("a") as handle:
        handle.write("yumaoqiu,0,15,0,15,0,15,a plastic shuttlecock\n")
    assert "shuttlecock" in {p.object for p in read_pairs(root).pairs}


def test_what_is_listed_but_not_there_is_counted(root):
    with (root / "contact_indoor.csv").open("a") as handle:
        handle.write("ghost_glass,0,5,0,5,0,5\n../../glass,0,5,0,5,0,5\n")
    for number in (3, 62):
        (root / f"data_indoor/galss_cup/gelsight/{number}.png").unlink()
    (root / "contact_outdoor.csv").write_text("steel_rail,0,69,9,4,x,69\n")
    whys = {s.what: (s.why, s.count) for s in read_pairs(root).skipped}
    assert whys["indoor/ghost_glass"] == ("listed, but the folder is missing", 1)
    assert whys["indoor/../../glass"] == ("listed, but the folder is missing", 1)
    assert whys["indoor/galss_cup, TQ-GelMini"] == ("frames of the range that are not there", 2)
    assert whys["outdoor/steel_rail, TQ-DIGIT"][0] == "no range of frames in contact_outdoor.csv"
    assert whys["outdoor/steel_rail, TQ-DuraGel"][0] == "no range of frames in contact_outdoor.csv"


def fields(root, tree):
    """Write fields and their images for one item; field n is n everywhere, the last is broken."""
    folder = root / "data_indoor/woodblock"
    tree(*(f"data_indoor/woodblock/img_tac3d/{number}.png" for number in range(12)))
    (folder / "tac3d").mkdir()
    for number in range(12):
        np.save(folder / f"tac3d/{number}.npy", np.full((20, 20, 3), float(number)))
    (folder / "tac3d/99.npy").write_bytes(b"\x93NUMPY cut short")


def test_tac3d_fields_become_images_beside_their_photos(root, tree, reasons):
    fields(root, tree)
    found = read_pairs(root)
    pairs = [p for p in found.pairs if p.domain == "TQ-T3D"]
    assert len(pairs) == 12
    assert {p.tac.suffix for p in pairs} == {".png"}
    assert {p.part for p in pairs} == {"indoor"}
    assert Counter(p.split for p in pairs)["test"] == 4  # 682 of 1,878
    assert all(p.tac.is_file() for p in pairs)
    assert reasons(found)["indoor/woodblock/tac3d/99.npy"] == ("no 20 x 20 x 3 field")


def test_a_tree_without_a_known_material_says_so(root):
    for part in ("indoor", "outdoor"):
        (root / f"contact_{part}.csv").write_text("stone,0,5,0,5,0,5\n")
    with pytest.raises(DataError, match=r"No pairs of TacQuad .* the folder is missing \(2\)"):
        read_pairs(root)


def test_fields_are_drawn_once(root, tree, tmp_path):
    fields(root, tree)
    cache = tmp_path / "cache" / "tac3d"
    first = read_pairs(root)
    times = {file: file.stat().st_mtime_ns for file in cache.iterdir()}
    assert read_pairs(root) == first
    assert {file: file.stat().st_mtime_ns for file in cache.iterdir()} == times
