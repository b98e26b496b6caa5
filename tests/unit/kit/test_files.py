"""Files are written completely or not at all, and errors name an unwritable folder."""

import csv
import os
import subprocess
import sys
from functools import partial
from pathlib import Path
from tempfile import gettempdir

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnivat import (
    import_embeddings,
    load_embeddings,
    load_head,
    load_profile,
    read_features,
    read_frames,
    read_pairs,
    twins,
)
from omnivat.cli import main
from omnivat.data.store import COLUMNS, write_manifest
from omnivat.kit.errors import DataError, WriteError
from omnivat.kit.files import (
    cache_folder,
    nothing_left,
    replacing,
    replacing_folder,
    require_writable,
    safe_cell,
    write_csv,
    write_text,
)

ROW = {name: ["x"] for name in COLUMNS}


def test_a_full_disk_removes_the_files_that_were_added_and_no_others(tmp_path):
    write_text(tmp_path / "old" / "mine.txt", "mine")
    for folder in (tmp_path / "old", tmp_path / "new"):
        with pytest.raises(WriteError), nothing_left(folder):  # noqa: PT012
            write_text(folder / "a" / "1.txt", "1")
            with replacing(folder / "2.txt"):
                raise OSError(28, "No space left on device")
    left = [path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*")]
    assert left == ["old", "old/mine.txt"]


@pytest.mark.parametrize("odd", [None, 7, b"a", ["a"]])
def test_what_is_no_path_is_refused_by_every_reader(odd):
    readers = [read_frames, read_pairs, load_embeddings, load_head, load_profile, read_features]
    others = [partial(import_embeddings, encoder="x"), *([] if odd is None else [twins])]
    for read in (*readers, *others, partial(write_text, text="")):
        with pytest.raises(DataError, match="A path was given as"):
            read(odd)


@pytest.mark.skipif(not Path("/proc/self/mem").exists(), reason="of Linux alone")
def test_a_frames_file_that_the_system_does_not_read_ends_in_one_sentence():
    with pytest.raises(DataError, match="/proc/self/mem' cannot be read .*check the path"):
        read_frames("/proc/self/mem")


@pytest.mark.parametrize(
    ("error", "wanted", "sentence"),
    [
        (RuntimeError("stopped"), RuntimeError, "stopped"),
        (OSError(28, "No space left on device"), WriteError, "a.txt' was not written .No space"),
    ],
)
def test_a_failure_half_way_leaves_the_old_file_and_nothing_beside_it(
    tmp_path, error, wanted, sentence
):
    file = tmp_path / "a.txt"
    write_text(file, "old")
    with pytest.raises(wanted, match=sentence), replacing(file):
        raise error
    assert file.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("folder", "is a folder; name a file to write"),
        ("file/deep/er/a.bin", "file' is a file; choose a folder"),
        (os.devnull, "is a device and not a file"),
    ],
)
def test_what_is_in_the_way_is_named_before_and_while_writing(name, sentence, tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("text")
    before = sorted(tmp_path.rglob("*"))
    for attempt in (require_writable, lambda path: write_text(path, "new")):
        with pytest.raises(WriteError, match=sentence):
            attempt(tmp_path / name)
    assert sorted(tmp_path.rglob("*")) == before
    assert os.path.exists(os.devnull) and not os.path.isfile(os.devnull)


def test_a_folder_without_rights_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    with pytest.raises(WriteError, match="nothing may be written in"):
        require_writable(tmp_path / "new" / "a.bin")


def test_a_place_that_can_be_written_is_left_as_it_is(tmp_path):
    require_writable(tmp_path / "new" / "deep" / "a.bin", ".bin")
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(WriteError, match="name one that ends in .bin"):
        require_writable(tmp_path / "a.txt", ".bin")


def test_a_manifest_replaces_its_own_and_no_other_table(tmp_path):
    place = tmp_path / "mine.safetensors"
    for _ in range(2):
        write_manifest(place, ROW, "csv")
    (tmp_path / "mine.csv").write_text("vis,tac,domain,material\na,b,c,d\n")
    with pytest.raises(WriteError, match="mine.csv' is another table"):
        write_manifest(place, ROW, "csv")
    assert (tmp_path / "mine.csv").read_text().startswith("vis,tac")


def test_embedding_a_table_never_replaces_that_table(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    # looks like a manifest, and is the input
    text = ",".join(COLUMNS) + "\nA,wood,a.png,b.png,,,\n"
    (tmp_path / "mine.csv").write_text(text)
    assert main(["embed", "mine.csv", "--out", "mine.safetensors"]) == 1
    assert "would replace 'mine.csv'; choose another name" in capsys.readouterr().err
    assert (tmp_path / "mine.csv").read_text() == text
    assert [path.name for path in tmp_path.iterdir()] == ["mine.csv"]


@pytest.mark.parametrize(
    "arguments",
    [
        ["embed", "pairs", "--out", "folder"],
        ["embed", "pairs", "--out", ""],
        ["sweep", "--csv", "folder"],
        ["project", "--out", "folder/a.csv/b.csv"],
        ["prompts", "--out", "folder"],
    ],
)
def test_commands_refuse_an_unwritable_place_before_any_work(
    arguments, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "a.csv").write_text("")
    assert main(arguments) == 1
    said = capsys.readouterr()
    assert said.err.count("\n") == 1 and said.out == ""
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["a.csv", "folder"]


def test_an_error_of_the_system_is_one_sentence(monkeypatch, capsys):
    def full(options):
        raise OSError(28, "No space left on device", "x.bin")

    monkeypatch.setattr("omnivat.cli.evaluate.run", full)
    assert main(["evaluate"]) == 1
    assert (
        capsys.readouterr().err
        == "omnivat evaluate: 'x.bin': No space left on device. Check the path, its permissions and"
        " the free space.\n"
    )


def test_what_a_killed_writer_left_is_swept_by_the_next_of_its_file_and_by_no_other(tmp_path):
    file = tmp_path / "a[1].txt"
    ended = """if 1:
        import os, sys
        from pathlib import Path
        from omnivat.kit.files import replacing
        with replacing(sys.argv[1]) as half:
            half.with_name("a file of a library beside it").write_text("half")
            half.write_text("half")
            os._exit(9)
    """
    for name in (file, tmp_path / "a[1].txt.b"):
        assert subprocess.run([sys.executable, "-c", ended, name], check=False).returncode == 9
    of_a, of_b = sorted(tmp_path.iterdir(), key=lambda folder: ".b." in folder.name)
    with replacing(file) as alive:
        assert not of_a.exists()
        write_text(file, "second writer")
        assert alive.parent.is_dir()
        alive.write_text("first writer")
    assert file.read_text() == "first writer"
    assert sorted(p.name for p in tmp_path.iterdir()) == [of_b.name, "a[1].txt"]


def test_two_embeds_to_one_file_do_not_take_one_anothers_parts(tmp_path):
    from omnivat.encoders.embed.job import Parts

    first, second = Parts(tmp_path / "a.safetensors"), Parts(tmp_path / "a.safetensors")
    with (
        first.claimed(),
        pytest.raises(WriteError, match="another embed that is still running"),
        second.claimed(),
    ):
        pass
    with second.claimed():
        pass
    assert list(tmp_path.iterdir()) == []


CELLS = st.one_of(
    st.text(st.sampled_from("=+-@\t\r\n '\",1e."), max_size=6), st.floats(), st.integers()
)


@given(CELLS)
def test_no_cell_starts_a_formula_and_numbers_stay_numbers(value):
    cell = safe_cell(value)
    if not isinstance(value, str):
        assert cell is value
        return
    if cell.strip(" ").startswith(("=", "+", "-", "@", "\t", "\r")):
        assert float(cell) == float(value) or float(cell) != float(cell)
    assert cell in (value, f"'{value}")


def test_a_table_with_hostile_names_is_read_back_as_text(tmp_path):
    write_csv(tmp_path / "t.csv", ["=x", "y"], [["@a,b", -1.5], ["\rc", "-2e3"], ["d", None]])
    with (tmp_path / "t.csv").open(newline="", encoding="utf-8") as handle:
        rows = list(csv.reader(handle))
    assert rows == [["'=x", "y"], ["'@a,b", "-1.5"], ["'\rc", "-2e3"], ["d", ""]]


def test_no_module_writes_a_table_past_the_one_writer():
    root = Path(__file__).resolve().parents[3]
    found = {
        str(path.relative_to(root))
        for folder in ("omnivat", "app")
        for path in (root / folder).rglob("*.py")
        if "csv.writer(" in path.read_text(encoding="utf-8")
        or "csv.DictWriter(" in path.read_text(encoding="utf-8")
    }
    assert found == {"omnivat/kit/files.py"}


@pytest.mark.parametrize(
    ("output", "why"), [(">&-", "output is closed"), ("> /dev/full", "No space left")]
)
def test_a_result_that_cannot_be_written_is_a_sentence_and_an_exit_code(output, why):
    line = f"exec {sys.executable} -m omnivat fetch {output}"
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr.count("\n")) == (1, 1)
    assert why in done.stderr


@pytest.mark.slow
def test_a_file_name_that_cannot_be_encoded_is_escaped(tmp_path):
    name = os.fsencode(tmp_path) + b"/\xff.safetensors"
    table = "domain,material,vis_0,vis_1,tac_0,tac_1\na,b,1,2,3,4\n"
    (tmp_path / "set.csv").write_text(table, encoding="utf-8")
    command = [sys.executable, "-m", "omnivat", "import", str(tmp_path / "set.csv")]
    command += ["--encoder", "mine", "--out", name]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, "Traceback" in done.stderr) == (0, False), done.stderr
    assert "\\udcff.safetensors" in done.stdout


def test_a_folder_takes_its_place_whole_or_leaves_what_stood_there(tmp_path):
    place = tmp_path / "site"
    for text in ("first", "second"):
        with replacing_folder(place) as made:
            (made / text).write_text(text)
            assert not place.exists() or not (place / text).exists()
        assert [file.name for file in place.iterdir()] == [text]

    def stopped():
        with replacing_folder(place) as made:
            (made / "third").write_text("third")
            raise DataError("No.")

    with pytest.raises(DataError):
        stopped()
    assert [file.name for file in place.iterdir()] == ["second"]
    assert [file.name for file in tmp_path.iterdir()] == ["site"]


KILLED = """
import os, sys
from pathlib import Path
from omnivat.kit.files import replacing_folder
with replacing_folder(Path(sys.argv[1])) as made:
    (made / "half").write_text("half")
    os._exit(9)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no such locks")
def test_the_hidden_folder_of_a_killed_writer_goes_with_the_next_one(tmp_path):
    place = tmp_path / "site"
    with replacing_folder(place) as made:
        (made / "first").write_text("first")
    subprocess.run([sys.executable, "-c", KILLED, str(place)], check=False)
    assert len(list(tmp_path.iterdir())) == 2
    with replacing_folder(place) as made, replacing_folder(place) as beside:
        assert made.exists() and beside.exists()  # a writer that runs keeps its own
    assert [file.name for file in tmp_path.iterdir()] == ["site"]


def test_without_a_home_the_cache_is_in_the_temporary_folder(monkeypatch):
    def none():
        raise RuntimeError("Could not determine home directory.")

    for name in ("OMNIVAT_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", none)
    assert cache_folder() == Path(gettempdir()) / "omnivat-cache"


@pytest.mark.parametrize(
    ("platform", "place"),
    [
        ("darwin", "Library/Caches/omnivat"),
        ("win32", "AppData/Local/omnivat"),
        ("linux", ".cache/omnivat"),
    ],
)
def test_the_cache_lies_where_the_platform_keeps_them(monkeypatch, tmp_path, platform, place):
    for name in ("OMNIVAT_CACHE", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    monkeypatch.setattr(sys, "platform", platform)
    assert cache_folder() == tmp_path / place
    if platform == "linux":
        monkeypatch.setenv("XDG_CACHE_HOME", "/xdg")
        assert cache_folder() == Path("/xdg/omnivat")
    monkeypatch.setenv("OMNIVAT_CACHE", "/some/where")
    assert cache_folder() == Path("/some/where")


def test_a_message_that_lists_thousands_of_names_is_shortened():
    text = str(
        DataError(f"No domain is called 'x'; there are {', '.join(map(str, range(10_000)))}.")
    )
    assert len(text) < 2000 and text.startswith("No domain") and text.endswith("9999.")
    assert str(DataError("a\nb\x1b")) == r"a\nb\x1b"  # on one line, whatever a file holds
