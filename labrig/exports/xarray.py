"""One netCDF file with named dimensions, which xarray opens as a tree."""

from __future__ import annotations

from pathlib import Path

from labrig.exports._files import new_file
from labrig.session import load_measurements, open_session
from labrig.session.recording.disk import written_beside


class _Xarray:
    summary = "One netCDF file with named dimensions, for xarray.open_datatree."
    extra = "xarray"

    def write(self, session: Path, folder: Path) -> list[Path]:
        import h5netcdf  # what xarray writes with

        del h5netcdf
        target = new_file(folder, f"{session.stem}.nc")
        import xarray  # noqa: F401 - missing packages are reported before anything is read

        with open_session(session) as opened:
            measured = load_measurements(session) if opened.has_measurements else None
            tree = opened.to_xarray(measured)
        with written_beside(target) as beside:
            tree.to_netcdf(beside, engine="h5netcdf")
        return [target]


FORMAT = _Xarray()
