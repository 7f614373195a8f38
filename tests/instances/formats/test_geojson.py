"""GeoJSON by RFC 7946, read by geojson-pydantic and shapely."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from geojson_pydantic import FeatureCollection
from shapely.geometry import Polygon, box, shape

from instances.formats.geojson import write_features
from instances.geodesy import TangentPlane

PLANE = TangentPlane(-33.0, 151.0)


def test_outer_rings_go_left_holes_right_and_positions_are_degrees(tmp_path: Path) -> None:
    clockwise = Polygon(box(0, 0, 900, 600).exterior.coords[::-1], [box(10, 10, 20, 20).exterior])
    write_features([(clockwise, {"name": "a"})], PLANE, tmp_path / "a.geojson")
    text = (tmp_path / "a.geojson").read_text()
    assert set(json.loads(text)) == {"type", "features"}
    (feature,) = FeatureCollection.model_validate_json(text).features
    assert feature.properties == {"name": "a"}
    polygon = shape(feature.geometry.model_dump())
    assert polygon.exterior.is_ccw
    assert not polygon.interiors[0].is_ccw
    corner = PLANE.geographic([[900.0, 600.0]])[0, ::-1]
    np.testing.assert_allclose(np.max(polygon.exterior.coords, axis=0), corner, atol=1e-7)
    assert not polygon.has_z
