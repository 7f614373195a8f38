import json

import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon

from instances import InputError
from instances.environment.region import Region, single_polygon
from instances.formats.geojson import parts_of
from instances.places import read_region

SQUARE = [[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]]
HOLE = [[4, 4], [6, 4], [6, 6], [4, 6], [4, 4]]


def geojson(*rings, kind="Polygon"):
    return {"type": kind, "coordinates": list(rings)}


def test_a_hole_is_outside():
    region = Region(single_polygon(geojson(SQUARE, HOLE)))
    assert region.area == 96
    assert region.contains([[1, 1], [5, 5], [4, 5], [10, 10], [11, 0]]).tolist() == [True, False, True, True, False]
    assert region.signed_distance([[1, 5], [5, 5], [12, 5]]).tolist() == [1.0, -1.0, -2.0]
    assert [len(ring) for ring in region.rings] == [5, 5]
    assert region.snap([[5.2, 5.0], [1, 1], [20, 5]]).tolist() == [[6.0, 5.0], [1.0, 1.0], [10.0, 5.0]]
    assert len(region.cell_centres(10, 10)) == 96


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (geojson([[0, 0], [1, 1], [1, 0], [0, 1], [0, 0]]), "not valid: Self-intersection"),
        (geojson([[0, 0], [1, 1], [2, 2], [0, 0]]), "region: the polygon is not valid|empty interior"),
        (geojson(SQUARE, HOLE, [[5, 5], [7, 5], [7, 7], [5, 7], [5, 5]]), "not valid: Self-intersection"),
        (geojson(SQUARE, [[20, 20], [21, 20], [21, 21], [20, 20]]), "not valid: Hole lies outside shell"),
        (geojson(), "must hold a polygon, it holds nothing"),
        (geojson([[0, 0], [1, 1]]), "of type 'Polygon' cannot be read"),
        (geojson([["a", "b"], [1, 1], [2, 0]]), "of type 'Polygon' cannot be read"),
        (geojson([[0, 0], [1, 10**400], [2, 0]]), "of type 'Polygon' cannot be read"),
        ({"type": "Polygon"}, "of type 'Polygon' cannot be read"),
        ({"type": "Polygon", "coordinates": 5}, "of type 'Polygon' cannot be read"),
        ({"type": "FeatureCollection", "features": 3}, "must hold a list of features"),
        ({"type": "FeatureCollection", "features": []}, "must hold a polygon, it holds nothing"),
        (geojson([SQUARE], [HOLE], kind="MultiPolygon"), "must hold one polygon, got 2"),
        (geojson([0, 0], kind="Point"), "region: must hold a polygon, it holds Point"),
        ([1], "of type None cannot be read"),
    ],
)
def test_what_is_no_region(tmp_path, data, sentence):
    (tmp_path / "area.geojson").write_text(json.dumps(data))
    with pytest.raises(InputError, match=sentence) as caught:
        read_region(tmp_path / "area.geojson")
    assert "area.geojson: " in str(caught.value)
    assert "\n" not in str(caught.value)


def test_files_that_are_no_geojson(tmp_path):
    for content in (b"", b"{", b"\xff", b"[" * 100_000, b"\x00"):
        (tmp_path / "a.geojson").write_bytes(content)
        with pytest.raises(InputError, match="geojson: "):
            read_region(tmp_path / "a.geojson")
    with pytest.raises(InputError, match="No such file"):
        read_region(tmp_path / "b.geojson")


@pytest.mark.parametrize("size", [(0, 1), (1, -1), (np.nan, 1), (np.inf, 1)])
def test_rectangles_without_an_interior(size):
    with pytest.raises(InputError, match="region: "):
        Region.rectangle(*size)


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(0, 10**6), st.integers(3, 9))
def test_write_and_read_keep_every_digit(tmp_path, seed, corners):
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi, corners))
    ring = np.column_stack([np.cos(angle), np.sin(angle)]) * rng.uniform(1, 1e6)
    if Polygon(ring).area < 1e-6:
        return
    region = Region(Polygon(ring))
    region.write(tmp_path / "a.geojson")
    back, _ = read_region(tmp_path / "a.geojson", "local")
    assert [r.tolist() for r in back.rings] == [r.tolist() for r in region.rings]


@settings(deadline=None)
@given(st.integers(0, 10**6), st.integers(3, 8))
def test_points_inside_outside_snapped_and_sampled_agree(seed, corners):
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi, corners))
    star = np.column_stack([np.cos(angle), np.sin(angle)]) * rng.uniform(0.3, 1, corners)[:, None]
    polygon = Polygon(star)
    if not polygon.is_valid or polygon.area < 1e-2:
        return
    region = Region(polygon)
    p = rng.uniform(-1.2, 1.2, (50, 2))
    distance = region.signed_distance(p)
    assert ((distance >= 0) == region.contains(p)).all()
    snapped = region.snap(p)
    assert (region.signed_distance(snapped) > -1e-12).all()
    moved = np.linalg.norm(snapped - p, axis=1)
    assert moved == pytest.approx(np.maximum(-distance, 0), abs=1e-9)
    sample = region.sample(30, rng)
    assert sample.shape == (30, 2)
    assert region.contains(sample).all()


def test_a_thin_region_is_sampled_too():
    thin = Region(Polygon([(0, 0), (1000, 1000), (1000, 1000.2), (0, 0.2)]))
    p = thin.sample(20, np.random.default_rng(0))
    assert thin.contains(p).all()
    assert p[:, 0].mean() == pytest.approx(500, abs=5 * 289 / np.sqrt(20))


def test_samples_are_uniform():
    """A quarter of an L-shaped region lies in each of four equal parts; 5 standard deviations of slack."""
    region = Region.rectangle(2, 2).minus([shapely.box(1, 1, 2, 2)])
    p = region.sample(4000, np.random.default_rng(0))
    counts = [(p[:, 0] > 1).sum(), (p[:, 1] > 1).sum(), ((p[:, 0] < 1) & (p[:, 1] < 1)).sum()]
    assert counts == pytest.approx([4000 / 3] * 3, abs=5 * np.sqrt(4000 * 2 / 9))


def test_no_fly_zones():
    region = Region.rectangle(10, 10)
    assert region.minus([]).area == 100
    assert region.minus([Polygon(HOLE)]).area == 96
    assert region.minus([shapely.box(20, 20, 30, 30)]).area == 100
    with pytest.raises(InputError, match="cut it into parts"):
        region.minus([shapely.box(4, -1, 6, 11)])
    with pytest.raises(InputError, match=r"leave nothing of it|empty interior"):
        region.minus([shapely.box(-1, -1, 11, 11)])
    with pytest.raises(InputError, match="a no-fly zone is not valid: Self-intersection"):
        region.minus([Polygon([(0, 0), (1, 1), (1, 0), (0, 1)])])


def test_every_polygon_of_a_collection():
    features = [{"type": "Feature", "geometry": geojson(SQUARE)}, geojson([SQUARE], [HOLE], kind="MultiPolygon")]
    assert len(list(parts_of({"type": "FeatureCollection", "features": features}))) == 3
    with pytest.raises(InputError, match="must be one polygon, got MultiPolygon"):
        Region(shapely.MultiPolygon([Polygon(SQUARE)]))
