import errno
import os
import resource
import stat
import sys

import numpy as np
import pytest

from instances import InputError, Instance
from instances.disk import check_target, write_aside
from instances.files import write_instance, write_routes

SMALL = Instance("x", np.zeros((2, 2)), 1, 1)


def test_a_full_disk_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    file = tmp_path / "a.json"
    file.write_text("old")

    def no_space(descriptor):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", no_space)
    with pytest.raises(InputError, match=r"a.json: cannot be written \(No space left on device\)"):
        write_instance(SMALL, file)
    assert file.read_text() == "old"
    assert list(tmp_path.iterdir()) == [file]


def test_folders_that_cannot_be_written(tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        write_instance(SMALL, tmp_path / "missing" / "a.json")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        write_routes([[0]], SMALL, tmp_path / "file" / "a.sol")
    (tmp_path / "a.json").mkdir()
    with pytest.raises(InputError, match="cannot be written"):
        write_instance(SMALL, tmp_path / "a.json")
    with pytest.raises(InputError, match="cannot be written"):
        write_aside(tmp_path / ("n" * 300), "x")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.json", "file"]


def test_a_link_keeps_its_place(tmp_path):
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to("real")
    write_aside(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() == "new"


def test_a_device_is_written_to_and_stays_one(tmp_path):
    device = tmp_path / "null"
    device.symlink_to("/dev/null")
    write_aside(device, "gone")
    assert device.is_symlink()
    assert stat.S_ISCHR(device.stat().st_mode)
    with pytest.raises(InputError, match=r"/dev/full: cannot be written \(No space left on device\)"):
        write_aside("/dev/full", "x" * 100_000)


def test_a_pipe_is_written_to_where_somebody_reads_it(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="pipe: cannot be written"):
        write_aside(tmp_path / "pipe", "nobody reads")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    write_aside(tmp_path / "pipe", "through")
    assert os.read(reader, 100) == b"through"
    os.close(reader)
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)
    assert [p.name for p in tmp_path.iterdir()] == ["pipe"]


def test_the_own_output_is_written_after_what_was_printed(tmp_path, monkeypatch):
    with (tmp_path / "out").open("w") as out:
        monkeypatch.setattr(sys, "stdout", out)
        print("first")
        write_aside(f"/proc/self/fd/{out.fileno()}", "second\n")
        print("third")
    assert (tmp_path / "out").read_text() == "first\nsecond\nthird\n"


def test_a_file_size_limit_leaves_the_old_file(tmp_path):
    (tmp_path / "a").write_text("old")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, hard))
        with pytest.raises(InputError, match=r"a: cannot be written \(File too large\)"):
            write_aside(tmp_path / "a", "x" * 2000)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert (tmp_path / "a").read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a"]


def test_text_that_cannot_be_encoded_is_a_sentence(tmp_path):
    with pytest.raises(InputError, match="a: cannot be written"):
        write_aside(tmp_path / "a", "\ud800")
    assert list(tmp_path.iterdir()) == []


def test_unknown_endings_write_nothing(tmp_path):
    with pytest.raises(InputError, match=r"'.jsonn' is no ending of instance files; did you mean '.json'"):
        write_instance(SMALL, tmp_path / "a.jsonn")
    with pytest.raises(InputError, match=r"'.json' is no ending of routes files"):
        write_routes([[0]], SMALL, tmp_path / "a.json")
    assert list(tmp_path.iterdir()) == []


def test_what_cannot_be_written_is_known_before_the_work(tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "there.csv").write_text("old")
    for fine in (tmp_path / "new.csv", tmp_path / "there.csv", "/dev/null"):
        check_target(fine)
    for bad in (
        tmp_path / "folder",
        tmp_path / "none" / "new.csv",
        tmp_path / ("x" * 250),
        tmp_path / "there.csv" / "x",
    ):
        with pytest.raises(InputError, match="cannot be written"):
            check_target(bad)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder", "there.csv"]
