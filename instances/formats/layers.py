"""Files of places as other software writes them: GeoJSON, KML, KMZ, GeoPackage, Shapefile (also zipped), in layers.

GeoJSON is read here; the others by GDAL, through pyogrio (extra ``geo``). A KML file's folders are its layers.
Positions keep their first two coordinates: heights in these files are not used.
"""

from __future__ import annotations

import io
import warnings
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import shapely
from shapely.geometry.base import BaseGeometry

from instances.disk import check_file, read_bytes, read_json
from instances.documents import most_opened
from instances.environment.raster import geo
from instances.errors import InputError, naming
from instances.formats.geojson import crs_of, single_parts, valued_parts_of

ENDINGS = (".geojson", ".json", ".kml", ".kmz", ".gpkg", ".shp", ".zip")
"""Of the files that can be read."""
LAYER = "|layername="
"""Between the name of a file and that of one of its layers, as QGIS writes it."""
BESIDE = (".shx", ".dbf", ".prj", ".cpg")
"""Files that belong to a Shapefile."""
NOWHERE = ("ENGCRS", "LOCAL_CS")
"""How WKT of a reference system begins that is not tied to the Earth."""
MOST_PARTS = 100_000
"""Places of a file: many times what a mission has."""


@dataclass(frozen=True, eq=False)
class Layer:
    """Points, lines and polygons in two dimensions, each one part; `crs` is "" where the file states none.

    values : the property ``value`` of each part's feature, None where it has none.
    """

    name: str
    parts: tuple[BaseGeometry, ...]
    crs: str
    values: tuple[Any, ...] = ()

    def of(self, kind: type[BaseGeometry]) -> Layer:
        """Return the layer with its parts of one kind of geometry alone."""
        kept = [i for i, part in enumerate(self.parts) if isinstance(part, kind)]
        return replace(self, parts=tuple(self.parts[i] for i in kept), values=tuple(self.values[i] for i in kept))


def read_layers(path: Path) -> list[Layer]:
    """Return the layers of a file by its ending, one of ENDINGS; InputError names the file and what is wrong."""
    ending = path.suffix.lower()
    readers = {".kml": _read_kml, ".kmz": _read_kmz, ".gpkg": _read_geopackage, ".shp": _read_shapefile}
    readers |= {".zip": _read_zipped, ".geojson": _read_geojson, ".json": _read_geojson}
    with naming(path):
        layers = readers[ending](path)
        if sum(len(layer.parts) for layer in layers) > MOST_PARTS:
            raise InputError(f"holds more than {MOST_PARTS:,} places")
        return layers


def _read_geojson(path: Path) -> list[Layer]:
    data = read_json(path)
    found = list(valued_parts_of(data))
    return [Layer(path.stem, tuple(part for part, _ in found), crs_of(data), tuple(value for _, value in found))]


def _read_kml(path: Path) -> list[Layer]:
    return _kml_layers(read_bytes(path), path)


def _read_kmz(path: Path) -> list[Layer]:
    with _opened_zip(path) as archive:
        names = [name for name in archive.namelist() if name.lower().endswith(".kml")]
        if not names:
            raise InputError("holds no .kml")
        return _kml_layers(archive.read(names[0]), path)  # by OGC 12-007, the first one counts


def _kml_layers(content: bytes, path: Path) -> list[Layer]:
    # GDAL looks for the format in the content, and reads some that lead to other files
    if b"<kml" not in content[:10_000] or b"<!DOCTYPE" in content or b"<OGRVRT" in content:
        raise InputError("is no KML")
    return _gdal_layers(content, path)


def _read_geopackage(path: Path) -> list[Layer]:
    return _of_signature(path, b"SQLite format 3\0")


def _read_shapefile(path: Path) -> list[Layer]:
    for ending in BESIDE:
        beside = path.with_suffix(ending)
        if beside.exists():
            check_file(beside)
    return _of_signature(path, b"\0\0\x27\x0a")


def _of_signature(path: Path, signature: bytes) -> list[Layer]:
    check_file(path)
    with path.open("rb") as file:
        if file.read(len(signature)) != signature:
            raise InputError(f"is not what its ending {path.suffix} says")
    return _gdal_layers(path, path)


def _read_zipped(path: Path) -> list[Layer]:
    with _opened_zip(path) as archive, TemporaryDirectory() as folder:
        names = [Path(name) for name in archive.namelist() if not name.startswith("__MACOSX")]
        found = [name for name in names if name.suffix.lower() == ".shp"]
        if len(found) != 1:
            raise InputError(f"must hold one Shapefile, it holds {len(found)} (.shp)")
        inside = found[0]
        for name in names:
            if name.parent == inside.parent and name.stem == inside.stem and name.suffix.lower() in (".shp", *BESIDE):
                (Path(folder) / f"zipped{name.suffix.lower()}").write_bytes(archive.read(name.as_posix()))
        layers = _read_shapefile(Path(folder) / "zipped.shp")
        return [replace(layer, name=inside.stem) for layer in layers]


@contextmanager
def _opened_zip(path: Path) -> Iterator[zipfile.ZipFile]:
    """Give the archive; InputError where it is none, or opens to more than `documents.most_opened`."""
    content = read_bytes(path)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            if sum(member.file_size for member in archive.infolist()) > most_opened(len(content)):
                raise InputError(f"opens to more than {most_opened(len(content)):,} bytes; unpack it first")
            yield archive
    except InputError:
        raise
    except Exception as error:  # damaged archives meet the library anywhere
        raise InputError(f"cannot be unpacked ({error})") from None


def _gdal_layers(source: Path | bytes, path: Path) -> list[Layer]:
    """Return the layers of a file, or of the content of one, that GDAL reads."""
    pyogrio, raw = (geo(module, path, f"reading {path.suffix.lower()}") for module in ("pyogrio", "pyogrio.raw"))
    layers = []
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for number, (name, kind) in enumerate(pyogrio.list_layers(source)):
                if kind is None:  # a table
                    continue
                # by number: GDAL names a KML without a name anew each time it is opened
                about, _, geometries, columns = raw.read(source, layer=number, columns=["value"], force_2d=True)
                values = columns[0].tolist() if columns else [None] * len(geometries)
                found = [
                    (part, value)
                    for each, value in zip(shapely.from_wkb(geometries), values, strict=True)
                    for part in single_parts(each)
                ]
                crs = about["crs"] or ""
                kept = (tuple(part for part, _ in found), "" if crs.startswith(NOWHERE) else crs)
                layers.append(Layer(str(name), *kept, tuple(value for _, value in found)))
    except Exception as error:  # damaged files meet the library anywhere, and it raises anything
        raise InputError(f"cannot be read ({str(error).splitlines()[0] if str(error) else error!r})") from None
    return layers
