"""The common entry point of all readers."""

import pytest

from omnivat.data.readers import READERS, read_pairs, recognised
from omnivat.kit.errors import DataError, MissingNameError, SettingsError
from omnivat.kit.tables import load


@pytest.mark.parametrize("name", READERS)
def test_every_reader_loads_and_can_be_strict_and_seeded(name):
    parameters = load(READERS, name, kind="reader").__annotations__
    assert {"source", "strict", "seed", "return"} <= parameters.keys()


@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("pairs.csv", "csv"),
        ("contact_outdoor.csv", "tacquad"),
        ("1/tactile_data/0/0/gelsight/0.png", "objectfolder_real"),
        ("dataset/20220101_000000/gelsight_frame/0.jpg", "touch_and_go"),
        ("grass/gelsight_frame/0.jpg", "touch_and_go"),
        ("TAG/wood/a_vis.png", "folder"),
    ],
)
def test_a_layout_is_recognised_by_what_lies_in_it(tmp_path, put, file, name):
    put(tmp_path / file)
    assert recognised(tmp_path) == name


def test_the_benchmark_release_is_recognised(tmp_path, put):
    put(tmp_path / "touch/1/0.png")
    (tmp_path / "label.json").write_text("{}")
    assert recognised(tmp_path) == "objectfolder_2"


def test_an_unknown_reader_gets_a_suggestion(tmp_path):
    with pytest.raises(MissingNameError, match="Did you mean 'tacquad'"):
        read_pairs(tmp_path, reader="taquad")


def test_an_unknown_option_gets_a_suggestion(tmp_path):
    with pytest.raises(SettingsError, match="no option 'by_folders'.*Did you mean 'by_folder'"):
        read_pairs(tmp_path, reader="touch_and_go", by_folders=True)


def test_a_reader_without_options_says_so(tmp_path):
    with pytest.raises(SettingsError, match="'folder' has no option 'camera'; it has none"):
        read_pairs(tmp_path, reader="folder", camera="x")


def test_a_truth_value_may_be_text(tmp_path, put):
    put(tmp_path / "wood" / "video_frame" / "0.png")
    put(tmp_path / "wood" / "gelsight_frame" / "0.png")
    assert len(read_pairs(tmp_path, keep_labels="true").pairs) == 1
    with pytest.raises(DataError, match="No labels for the clips"):
        read_pairs(tmp_path, keep_labels="False")
    with pytest.raises(SettingsError, match="keep_labels is 'perhaps'; choose true or false"):
        read_pairs(tmp_path, keep_labels="perhaps")
