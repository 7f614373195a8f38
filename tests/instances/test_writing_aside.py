import errno
import os

import numpy as np
import pytest

from instances import InputError, Instance
from instances.disk import write_aside
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


def test_unknown_endings_write_nothing(tmp_path):
    with pytest.raises(InputError, match=r"'.jsonn' is no ending of instance files; did you mean '.json'"):
        write_instance(SMALL, tmp_path / "a.jsonn")
    with pytest.raises(InputError, match=r"'.json' is no ending of routes files"):
        write_routes([[0]], SMALL, tmp_path / "a.json")
    assert list(tmp_path.iterdir()) == []
