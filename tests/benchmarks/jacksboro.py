"""A survey over real ground in degrees, from files as people have them to a plan that may be flown. Run by hand:

    python tests/benchmarks/jacksboro.py [--out DIR]

Ground: matplotlib's `jacksboro_fault_dem.npz` (3″ elevations of the Jacksboro fault, Tennessee), written here as a
GeoTIFF in WGS 84; region: a KML rectangle of 20 km; three depots as longitude and latitude; 120 m above the ground at
30 m/s. Prints figures beside bars: time, least height above the ground, metres outside, and what others read.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pandas as pd

MOST_SECONDS = 300.0
SCHEMA = Path(__file__).parents[1] / "instances" / "formats" / "qgc_plan.schema.json"
"""Of QGroundControl's plan files."""
WEST, SOUTH, EAST, NORTH = -84.358, 36.500, -84.134, 36.680
"""The region [degrees]: 20.0 by 20.0 km."""

KML = """<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2"><Document><name>Jacksboro</name>
<Placemark><name>survey area</name><Polygon><outerBoundaryIs><LinearRing><coordinates>
{west},{south},0 {east},{south},0 {east},{north},0 {west},{north},0 {west},{south},0
</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark></Document></kml>
"""

MISSION = """# A survey of the ground around the Jacksboro fault. Positions are longitude, latitude.
name = "jacksboro"
ground_speed = 30.0
region = "area.kml"
terrain = "dem.tif"
depots = [[-84.340, 36.520], [-84.150, 36.530], [-84.250, 36.660]]
tasks = 30

[wind]                          # 6 m/s from the south-west, over the same ground
kind = "terrain"
dem = "dem.tif"
velocity = [4.2, 4.2]
profile = "log"
altitude = 1200.0
cells = 100

[radio]
position = [-84.246, 36.590]
height = 30.0

[field]
decorrelation = 4000.0

[flight]
altitude = 120.0
frame = "above-ground"
clearance = 100.0
turning_radius = 100.0
border_clearance = 20.0
"""


def write_mission(folder: Path) -> Path:
    """Write elevations, region and mission file into `folder`; return the mission file."""
    import rasterio
    from matplotlib.cbook import get_sample_data

    with get_sample_data("jacksboro_fault_dem.npz") as dem:
        elevation, west, east = dem["elevation"], float(dem["xmin"]), float(dem["xmax"])
        north, south = sorted((float(dem["ymin"]), float(dem["ymax"])), reverse=True)  # the first row is the northern
    rows, columns = elevation.shape
    corner = rasterio.transform.from_bounds(west, south, east, north, columns, rows)
    about = {"driver": "GTiff", "width": columns, "height": rows, "count": 1, "dtype": "int16", "crs": "EPSG:4326"}
    with rasterio.open(folder / "dem.tif", "w", transform=corner, **about) as out:
        out.write(elevation, 1)
        out.units = ("m",)
    (folder / "area.kml").write_text(KML.format(west=WEST, south=SOUTH, east=EAST, north=NORTH))
    path = folder / "mission.toml"
    path.write_text(MISSION)
    return path


def run(mission: Path, out: Path) -> tuple[float, float]:
    """Run the mission by the command line; return its wall clock and its processor time [s]."""
    command = [sys.executable, "-P", "-c", "from workbench.cli import main; main()", "mission", str(mission)]
    began = time.perf_counter()
    subprocess.run([*command, "--out", str(out)], check=True)
    elapsed, used = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    return elapsed, used.ru_utime + used.ru_stime


def figures(folder: Path, out: Path) -> dict[str, tuple[float, bool]]:
    """Return what was asked for: name → figure and whether it is met, by the source's own grid in degrees."""
    import rasterio
    import shapely
    from scipy.ndimage import map_coordinates

    flight = out / "5-flight"
    checks = pd.read_csv(flight / "flight-check.csv")
    least, outside = float(checks["clearance"].min()), float(checks["outside"].max())
    flown = shapely.from_geojson((flight / "flown.geojson").read_text())
    positions = shapely.get_coordinates(flown)
    heights = pd.read_csv(flight / "flown.csv")["z"].to_numpy()
    with rasterio.open(folder / "dem.tif") as dem:  # bilinear between the centres of its cells, in degrees
        columns, rows = ~dem.transform * positions.T
        ground = map_coordinates(dem.read(1).astype(float), [rows - 0.5, columns - 0.5], order=1)
    region = shapely.box(WEST, SOUTH, EAST, NORTH)
    beyond = shapely.length(shapely.difference(flown, region)) * 111_000
    return {
        "least height above the ground [m], by flight-check.csv": (least, least >= 120.0 - 1e-6),
        "least height above the elevations in degrees [m], clearance 100 m": (
            float((heights - ground).min()),
            bool((heights - ground).min() >= 100.0),
        ),
        "outside the region [m], by flight-check.csv": (outside, outside == 0.0),
        "track outside the rectangle in degrees [m]": (float(beyond), bool(beyond == 0.0)),
    }


def opened(out: Path) -> list[str]:
    """Return what software of others reads of the products; it raises where it cannot."""
    import fastkml
    import jsonschema
    import pyogrio
    import rasterio
    import xarray

    said = []
    for path in sorted(out.rglob("*.tif")):
        with rasterio.open(path) as raster:
            said.append(f"{path.name}: {raster.width} × {raster.height} {raster.units[0]} in {raster.crs.to_proj4()}")
    for path in sorted(out.rglob("*.nc")):
        with xarray.open_dataset(path) as data:
            said.append(f"{path.name}: {', '.join(map(str, data.data_vars))}")
            assert "crs" in data.data_vars, path
    for path in sorted(out.rglob("*.geojson")):
        about = pyogrio.read_info(path)
        said.append(f"{path.name}: {about['features']} features in {about['crs']}, {about['total_bounds']}")
    for path in sorted(out.rglob("*.kml")):
        document = fastkml.KML.parse(path)
        said.append(f"{path.name}: {sum(1 for _ in document.features)} document")
    for path in sorted(out.rglob("*.plan")):
        plan = json.loads(path.read_text())
        jsonschema.validate(plan, json.loads(SCHEMA.read_text()))
        mission = plan["mission"]
        said.append(f"{path.name}: {len(mission['items'])} items, home {mission['plannedHomePosition']}")
    return said


def main() -> None:
    """Write the inputs, run the mission, print figures beside bars."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, help="where inputs and products are kept")
    asked = parser.parse_args().out
    with tempfile.TemporaryDirectory() as folder:
        place = asked or Path(folder)
        place.mkdir(parents=True, exist_ok=True)
        out = place / "out"
        elapsed, used = run(write_mission(place), out)
        print(f"     processor time [s], kernels compiled where they are not yet: {used:.0f}")
        asked_of = {f"whole mission [s], bar {MOST_SECONDS:.0f}": (elapsed, elapsed < MOST_SECONDS)}
        for name, (figure, met) in (asked_of | figures(place, out)).items():
            print(f"{'ok  ' if met else 'MISS'} {name}: {figure:.2f}")
        for line in opened(out):
            print(f"read {line}")


if __name__ == "__main__":
    main()
