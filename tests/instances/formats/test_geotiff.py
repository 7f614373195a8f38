"""GeoTIFFs, read by rasterio: on their place on Earth, north up, no data where there is none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import rasterio
from rasterio.warp import transform

from instances.formats.geotiff import write_geotiff
from instances.geodesy import TangentPlane

PLANE = TangentPlane(36.0, 128.0)
X, Y = np.arange(50.0, 20_000.0, 100.0), np.arange(50.0, 12_000.0, 100.0)


def test_a_raster_lies_where_the_plane_says(tmp_path: Path) -> None:
    values = np.add.outer(Y, X)
    values[0, 0] = np.nan
    write_geotiff(tmp_path / "a.tif", values, X, Y, PLANE, name="posterior mean", unit="dBm")
    with rasterio.open(tmp_path / "a.tif") as data:
        assert (data.shape, data.units, data.descriptions) == ((120, 200), ("dBm",), ("posterior mean",))
        written = data.read(1)
        np.testing.assert_array_equal(np.isnan(written[::-1]), np.isnan(values))
        np.testing.assert_allclose(written[::-1], values, rtol=1e-6)
        for row, column in ((0, 0), (0, 199), (119, 199)):
            (lon,), (lat,) = transform(data.crs, "EPSG:4326", *[[c] for c in data.xy(row, column)])
            expected = PLANE.geographic([[X[column], Y[::-1][row]]])[0]
            off = (np.array([lat, lon]) - expected) * 111_000.0
            assert np.hypot(*off) < 0.2  # [m], at up to 23 km


def test_the_projection_differs_from_the_plane_by_what_it_says() -> None:
    for distance, most in ((1_000.0, 1e-5), (20_000.0, 0.1), (30_000.0, 0.3)):
        angles = np.linspace(0, 2 * np.pi, 12)
        ring = distance * np.column_stack([np.cos(angles), np.sin(angles)])
        lat, lon = PLANE.geographic(ring).T
        back = np.column_stack(transform("EPSG:4326", PLANE.projection, lon, lat))
        off = np.hypot(*(back - ring).T)
        assert off.max() <= most
        assert off.max() > most / 10
