"""How a panel is started, and with what it is not."""

from __future__ import annotations

import shutil
import ssl
import subprocess
import urllib.request
from pathlib import Path

import pytest

from labrig.cli.main import run
from labrig.panel.access.settings import PanelSettings, host_name
from tests.labrig.panel.page import Server


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["nowhere.toml"], "no such file"),
        (["--host", "0.0.0.0"], "--insecure"),
        (["--host", "192.0.2.1"], "--insecure"),
        (["--certificate", "a.pem"], "belong together"),
        (["--certificate", "rig.toml", "--key", "rig.toml"], "cannot be used"),
        (["--data", "nowhere"], "no such folder"),
        (["--host", "192.0.2.1", "--insecure"], "cannot listen"),
        (["sheet.toml"], "this is a sheet.toml; a rig.toml is needed"),
        (["replayed.toml"], "this rig is a recorded session"),
        (["none.h5"], "is not an HDF5 file"),
        (["rig.toml", "--model", "sheet.toml"], "this is a sheet.toml; a model file is needed"),
    ],
)
def test_a_wrong_start_is_told_in_a_sentence(rig_folder, monkeypatch, capsys, options, told):
    monkeypatch.chdir(rig_folder)
    Path("replayed.toml").write_text('replay = "session.h5"\n')
    Path("none.h5").write_text("no session")
    assert run(["panel", "--port", "0", *options]) == 2
    shown = capsys.readouterr()
    said = " ".join(shown.err.split())
    assert told in said
    assert shown.out == ""  # no address that nobody serves
    assert "Traceback" not in said


def test_a_refused_rig_leaves_no_token(tmp_path, capsys):
    (tmp_path / "sheet.toml").write_text("[arc]\nradius_mm = 40\n")
    assert run(["panel", str(tmp_path / "sheet.toml")]) == 2
    assert "this is a sheet.toml" in capsys.readouterr().err
    assert not (tmp_path / ".labrig").exists()


def test_a_session_outside_the_data_folder_is_refused(rig_folder, tmp_path, capsys):
    (tmp_path / "a.h5").write_bytes(b"x")
    assert run(["panel", str(tmp_path / "a.h5"), "--data", str(rig_folder)]) == 2
    assert "does not lie in" in capsys.readouterr().err


def test_addresses_are_ours_by_name(tmp_path):
    assert PanelSettings(data=tmp_path, port=8720).names == {
        "127.0.0.1:8720", "localhost:8720", "[::1]:8720",
    }  # fmt: skip
    assert PanelSettings(data=tmp_path, host="rig.lab", port=1).names == {"rig.lab:1"}
    assert PanelSettings(data=tmp_path, host="0.0.0.0").names is None
    assert PanelSettings(data=tmp_path, host="::1", port=5).url("/x") == "http://[::1]:5/x"
    for header, name in (("a:1", "a"), ("[::1]:80", "[::1]"), ("a", "a"), ("[::1]", "[::1]")):
        assert host_name(header) == name


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("openssl") is None, reason="openssl makes the certificate")
def test_with_a_certificate_panel_and_stop_speak_tls_only(rig_folder, tmp_path):
    key, certificate = tmp_path / "key.pem", tmp_path / "certificate.pem"
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj",
         "/CN=localhost", "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", str(key),
         "-out", str(certificate)],
        check=True,
        capture_output=True,
    )  # fmt: skip
    files = ["--certificate", str(certificate), "--key", str(key)]
    server = Server(rig_folder / "rig.toml", *files, lean=True)
    try:
        assert server.origin.startswith("https://")
        trusting = ssl.create_default_context(cafile=str(certificate))
        bearer = {"Authorization": f"Bearer {server.token}"}

        def get(url):
            asked = urllib.request.Request(url, headers=bearer)
            with urllib.request.urlopen(asked, timeout=30, context=trusting) as answer:
                return answer.read().decode()

        assert '"mode":"rig"' in get(f"{server.origin}/api/status")
        stop = get(f"{server.origin}/api/status").split('"stop_url":"')[1].split('"')[0]
        assert stop.startswith("https://")
        assert '"ready": true' in get(stop)
        with pytest.raises(OSError, match=r"."):
            urllib.request.urlopen(server.origin.replace("https", "http"), timeout=5)
    finally:
        server.end()
