"""The common entry point of all readers."""

import pytest

from omnivat.data.readers import read_pairs, recognised
from omnivat.kit.errors import DataError, MissingNameError, SettingsError


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
def test_a_layout_is_recognised_by_what_lies_in_it(tree, file, name):
    assert recognised(tree(file)) == name


def test_an_unknown_reader_gets_a_suggestion(tmp_path):
    with pytest.raises(MissingNameError, match="Did you mean 'tacquad'"):
        read_pairs(tmp_path, reader="taquad")


@pytest.mark.parametrize(
    ("reader", "option", "message"),
    [
        ("touch_and_go", "by_folders", "no option 'by_folders'.*Did you mean 'by_folder'"),
        ("folder", "camera", "'folder' has no option 'camera'; it has vis, tac"),
    ],
)
def test_an_unknown_option_is_refused_with_those_there_are(tmp_path, reader, option, message):
    with pytest.raises(SettingsError, match=message):
        read_pairs(tmp_path, reader=reader, **{option: True})


def test_a_truth_value_may_be_text(tree):
    root = tree("wood/video_frame/0.png", "wood/gelsight_frame/0.png")
    assert len(read_pairs(root, keep_labels="true").pairs) == 1
    with pytest.raises(DataError, match="No labels for the clips"):
        read_pairs(root, keep_labels="False")
    with pytest.raises(SettingsError, match="keep_labels is 'perhaps'; choose true, false"):
        read_pairs(root, keep_labels="perhaps")
