"""The token of a data folder's panel."""

from __future__ import annotations

import os

import pytest

from labrig.panel.server.kept_token import kept_token, new_token

posix = pytest.mark.skipif(os.name != "posix", reason="permissions as POSIX has them")


def test_the_next_panel_of_a_folder_has_the_same_token(tmp_path):
    assert kept_token(tmp_path) == kept_token(tmp_path)


def test_another_folder_has_another_token(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    assert kept_token(tmp_path / "a") != kept_token(tmp_path / "b")


def test_a_new_token_replaces_the_one_that_is_kept(tmp_path):
    before = kept_token(tmp_path)
    after = new_token(tmp_path)
    assert after != before
    assert kept_token(tmp_path) == after


@posix
def test_only_its_owner_can_read_it(tmp_path):
    kept_token(tmp_path)
    assert (tmp_path / ".labrig" / "token").stat().st_mode & 0o777 == 0o600


@posix
def test_a_token_that_others_could_read_is_not_used_again(tmp_path):
    before = kept_token(tmp_path)
    (tmp_path / ".labrig" / "token").chmod(0o644)
    assert kept_token(tmp_path) != before


@pytest.mark.parametrize("text", ["", "short", "a" * 100, "long enough, but with spaces in it"])
def test_what_is_no_token_is_replaced(tmp_path, text):
    (tmp_path / ".labrig").mkdir()
    path = tmp_path / ".labrig" / "token"
    path.write_text(text)
    path.chmod(0o600)
    assert kept_token(tmp_path) != text
