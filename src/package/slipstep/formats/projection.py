"""Longitudes and latitudes in the frame of faults, x north, y east [m], and back.

By default the frame is that of the transverse Mercator projection about the origin on the ellipsoid WGS 84: angles are
true, lengths are too large by 0.03 % at 150 km and 0.3 % at 500 km east or west of it. PROJ computes it (Debian's
python3-pyproj). "sphere" is the equirectangular projection of geographic.py, which needs nothing else; anything else is
a coordinate system that PROJ knows, as EPSG:32611, less the coordinates of the origin. Longitudes may be beyond 180
degrees: those nearest to the origin's are taken.
"""

import numpy as np

from ..errors import Error
from ..geometry.geographic import EARTH_RADIUS, lonlat, unwrapped

TMERC, SPHERE = "tmerc", "sphere"
# times its distance on a sphere: farther from the origin no map projection has a point that it does not tear off
TORN = 10


class Projection:
    """North and east [m] of longitudes and latitudes [degrees], about an origin (longitude, latitude)."""

    def __init__(self, origin, kind=TMERC):
        self.origin, self.kind = (float(origin[0]), float(origin[1])), kind
        if not (-360 <= self.origin[0] <= 360 and -89 <= self.origin[1] <= 89):
            raise Error(f"the origin is {self.origin[0]:g} {self.origin[1]:g}, expected a longitude from -360 to 360 "
                        "and a latitude from -89 to 89 degrees")
        self.origin = (float(unwrapped(self.origin[0], 0)), self.origin[1])
        if kind == SPHERE:
            return
        try:
            import pyproj
        except ImportError:
            raise Error("longitudes and latitudes need PROJ: expected Debian's python3-pyproj, or "
                        "--projection sphere") from None
        text = (f"+proj=tmerc +lat_0={self.origin[1]!r} +lon_0={self.origin[0]!r} +k=1 +ellps=WGS84 +units=m"
                if kind == TMERC else kind)
        try:
            self.proj = pyproj.Proj(text)
        except pyproj.exceptions.CRSError as error:
            raise Error(f"--projection {kind}: {str(error).splitlines()[0]}, expected tmerc, sphere or a coordinate "
                        "system of PROJ, as EPSG:32611") from None
        if self.proj.crs.is_geographic:
            raise Error(f"--projection {kind} has degrees, expected a coordinate system in m")
        self.shift = np.array(self.proj(*self.origin)) if kind != TMERC else np.zeros(2)

    @property
    def words(self):
        lon, lat = self.origin
        place = f"{abs(lon):.4f} {'W' if lon < 0 else 'E'}, {abs(lat):.4f} {'S' if lat < 0 else 'N'}"
        name = {TMERC: "transverse Mercator of WGS 84", SPHERE: "equirectangular on a sphere"}.get(self.kind, self.kind)
        return f"x north, y east of {place} ({name})"

    def forward(self, lon, lat):
        """North and east [m]."""
        lon, lat = unwrapped(lon, self.origin[0]), np.asarray(lat, float)
        sphere = np.radians(lat - self.origin[1]) * EARTH_RADIUS, np.radians(
            lon - self.origin[0]) * EARTH_RADIUS * np.cos(np.radians(self.origin[1]))
        if self.kind == SPHERE:
            return sphere
        east, north = (np.asarray(values) - shift for values, shift in zip(self.proj(lon, lat), self.shift))
        away = np.hypot(*sphere)
        if not np.all(np.hypot(north, east) <= TORN * away + 1.0):
            k = int(np.argmax(np.hypot(north, east) - TORN * away))
            raise Error(f"--projection {self.kind} has {np.ravel(lon)[k]:g} E, {np.ravel(lat)[k]:g} N, "
                        f"{np.ravel(away)[k] / 1e3:.0f} km from the origin, "
                        f"{np.hypot(np.ravel(north)[k], np.ravel(east)[k]) / 1e3:.0f} km away: "
                        "expected one that does not tear the faults apart")
        return north, east

    def inverse(self, north, east):
        """Longitudes and latitudes [degrees]."""
        if self.kind == SPHERE:
            return lonlat(north, east, self.origin)
        lon, lat = self.proj(np.asarray(east, float) + self.shift[0], np.asarray(north, float) + self.shift[1],
                             inverse=True)
        return np.asarray(lon), np.asarray(lat)

    def convergence(self, north, east):
        """The strike of x [degrees] at a point: what strikes of maps, from true north, have more than those here."""
        step = 100.0
        lon, lat = self.inverse(np.array([north - step, north + step]), np.array([east, east]))
        return float(np.degrees(np.arctan2((unwrapped(lon[1], lon[0]) - lon[0]) * np.cos(np.radians(lat.mean())),
                                           lat[1] - lat[0]))) if self.kind != SPHERE else 0.0
