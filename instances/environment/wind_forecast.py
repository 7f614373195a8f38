"""A forecast: wind on a grid in frames, bilinear between nodes, linear in time between frames.

    w(x, t) = (1 − s) w_f(x) + s w_{f+1}(x),   s = (t − t_f)/(t_{f+1} − t_f)

Steps from frame to frame may differ. Whoever flies beyond the last frame meets that one, and is told so. The wind of
one moment is a `Grid`, which a file of a single time is from the start.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from instances.arrays import Floats
from instances.environment.raster import node_axes, node_bounds, write_netcdf
from instances.environment.region import Region
from instances.environment.site import Site
from instances.environment.wind import points_of
from instances.environment.wind_changing import ChangingWind
from instances.environment.wind_files import read_frames
from instances.environment.wind_grid import Grid, velocity_at
from instances.errors import InputError
from instances.kernels import njit


@njit(cache=True)
def _velocities(p: Floats, frame: Floats, x0: float, y0: float, dx: float, dy: float, u: Floats, v: Floats) -> Floats:
    """Velocities at points `p` (k, 2), each at its `frame` (k,), a number of frames with the share to the next."""
    out = np.empty((len(p), 2))
    for k in range(len(p)):
        fx, fy = (p[k, 0] - x0) / dx, (p[k, 1] - y0) / dy
        f = int(frame[k])
        s = frame[k] - f
        au, av = velocity_at(fx, fy, u[f], v[f])
        if s > 0.0:
            bu, bv = velocity_at(fx, fy, u[f + 1], v[f + 1])
            au, av = (1 - s) * au + s * bu, (1 - s) * av + s * bv
        out[k, 0], out[k, 1] = au, av
    return out


@dataclass(frozen=True, eq=False)
class Forecast:
    """Wind in frames: `u`, `v` [m/s], shape (frames, rows, columns), at `times` (frames,) [s], rising from 0.

    origin, spacing, source, crs : as of `Grid`. take_off : when the UAVs do, after the first frame [s].
    members : of an ensemble, other forecasts of the same hours, in which plans made in this one are judged as well.
    """

    times: Floats
    origin: tuple[float, float]
    spacing: tuple[float, float]
    u: Floats
    v: Floats
    source: str = ""
    crs: str = ""
    take_off: float = 0.0
    members: tuple[Forecast, ...] = ()

    def __post_init__(self) -> None:
        where = f"forecast {self.source}".strip()
        for name in ("times", "u", "v"):
            array = np.ascontiguousarray(getattr(self, name), dtype=np.float64)
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        count = len(self.times)
        if count < 2 or self.u.shape != self.v.shape or self.u.ndim != 3 or len(self.u) != count:
            raise InputError(
                f"{where}: {count} times need u and v of as many frames, at least 2, got {self.u.shape} and "
                f"{self.v.shape}"
            )
        if self.times[0] != 0 or not (np.diff(self.times) > 0).all() or not np.isfinite(self.times).all():
            raise InputError(f"{where}: times must increase from 0 s, got {self.times.tolist()}")
        if not 0 <= self.take_off < self.times[-1]:
            raise InputError(
                f"{where}: take_off must be before its last frame, {self.times[-1]:g} s after its first, got "
                f"{self.take_off:g} s"
            )
        for number in range(count):
            self._frame(number)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """x_min, y_min, x_max, y_max [m] of the nodes."""
        return node_bounds(self.origin, self.spacing, self.u.shape[1:])

    @property
    def lasts(self) -> float:
        """How long after take-off [s] the last frame is; it is held from then on."""
        return float(self.times[-1]) - self.take_off

    def velocities(self, points: Floats, times: Floats) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m], each at its time (k,) [s] after take-off, shape (k, 2)."""
        frame = np.interp(times + self.take_off, self.times, np.arange(len(self.times), dtype=np.float64))
        return _velocities(points_of(points), frame, *self.origin, *self.spacing, self.u, self.v)

    def at(self, time: float) -> Grid:
        """Return the wind of `time` [s] after take-off, as if it stayed."""
        frame = float(np.interp(time + self.take_off, self.times, np.arange(len(self.times))))
        f = min(int(frame), len(self.times) - 2)
        s = frame - f
        u, v = ((1 - s) * w[f] + s * w[f + 1] for w in (self.u, self.v))
        return Grid(self.origin, self.spacing, u, v, self.source, self.crs)

    def __call__(self, points: ArrayLike) -> Floats:
        """Return the velocity [m/s] at `points` (k, 2) [m] at take-off."""
        return self._now(points)

    def line_integral(self, a: ArrayLike, b: ArrayLike) -> Floats:
        """Return ∫ w·dσ [m²/s] along the segments `a` → `b` at take-off, exact for the bilinear field."""
        return self._now.line_integral(a, b)

    def to_toml(self, folder: Path | None = None) -> dict[str, Any]:
        """Return the ``[wind]`` table and write the frames as NetCDF ``wind.nc`` into `folder`."""
        if folder is None:
            raise InputError("wind: a forecast is data and needs a folder to write its file into")
        names = [f"wind-{number}.nc" for number in range(1, len(self.members) + 1)]
        for name, each in zip(["wind.nc", *names], (self, *self.members), strict=True):
            each.write(Path(folder) / name)
        more = {"members": names, "take_off": self.take_off}
        return {"kind": "grid", "file": "wind.nc"} | {key: value for key, value in more.items() if value}

    def write(self, path: Path) -> None:
        """Write the frames as CF NetCDF."""
        fields = {
            component: (values, {"standard_name": f"{axis}_wind", "units": "m s-1"})
            for component, values, axis in (("u", self.u, "x"), ("v", self.v, "y"))
        }
        axes = node_axes(self.origin, self.spacing, self.u.shape[1:])
        write_netcdf(path, *axes, fields, {"source": self.source, "crs": self.crs}, self.times)

    @classmethod
    def from_toml(cls, table: Mapping[str, Any], folder: Path, site: Site | None = None) -> Forecast | Grid:
        """Read the file of a ``[wind]`` table: a forecast where it holds several times, else a wind that stays.

        NetCDF, or WindNinja's ``*_vel.asc`` beside its ``*_ang.asc``; `units` says what a WindNinja file holds ("m/s",
        "mph", "kph" or "knots"; "m/s" where it is not given).
        """
        path = folder / table["file"]
        times, frames = read_frames(path, units=table.get("units"), site=site)
        first = frames[0]
        if len(frames) > 1:
            u, v = (np.stack([getattr(frame, name) for frame in frames]) for name in ("u", "v"))
            about = first.source, first.crs, table.get("take_off", 0.0)
            one = {key: value for key, value in table.items() if key != "members"}
            others = [cls.from_toml(one | {"file": name}, folder, site) for name in table.get("members", [])]
            still = [other.source for other in others if isinstance(other, Grid)]
            if still:
                raise InputError(f"{still[0]}: a member of an ensemble must be a forecast, and this holds one time")
            members = tuple(other for other in others if isinstance(other, Forecast))
            return cls(times, first.origin, first.spacing, u, v, *about, members)
        for key in ("take_off", "members"):
            if key in table:
                raise InputError(f"{path}: holds the wind of one time: leave {key} out")
        return Grid(*first)

    @cached_property
    def _now(self) -> Grid:
        return self.at(0.0)

    def _frame(self, number: int) -> Grid:
        """Return a frame; InputError where it cannot be used, naming it."""
        source = f"{self.source}, frame {number}" if self.source else f"frame {number}"
        return Grid(self.origin, self.spacing, self.u[number], self.v[number], source, self.crs)


def sampled(wind: ChangingWind, region: Region, times: Floats, cells: int) -> Forecast:
    """Return `wind` as a forecast: frames at `times` [s], rising from 0, on a grid over the bounds of `region`.

    cells : of the grid, along its longer side.
    """
    x0, y0, x1, y1 = region.bounds
    size = max(x1 - x0, y1 - y0) / cells
    columns, rows = (max(1, round(side / size)) for side in (x1 - x0, y1 - y0))
    spacing = (x1 - x0) / columns, (y1 - y0) / rows
    x, y = node_axes((x0, y0), spacing, (rows + 1, columns + 1))
    nodes = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    frames = [wind.velocities(nodes, np.full(len(nodes), t)).reshape(rows + 1, columns + 1, 2) for t in times]
    w = np.stack(frames)
    return Forecast(times, (x0, y0), spacing, w[..., 0], w[..., 1])
