"""Where and when the events of a catalogue are on the Earth: longitude, latitude and date of local coordinates and
times."""

import argparse
import datetime

import numpy as np

from ..errors import OutputError
from ..times import YEAR
from .cells import cells_of

EARTH_RADIUS = 6371e3  # [m], of a sphere
# [m] from its middle, and farther than it is long: the origin of a mesh is not one of its own, nor is the projection of
# lonlat() good there
FALSE_ORIGIN = 100e3
FALSE_POINT = 1000e3  # [m] likewise, of a point that is given


def add_arguments(parser):
    parser.add_argument("--origin", nargs=2, type=float, metavar=("LON", "LAT"),
                        help="longitude and latitude [degrees] of the point x = y = 0; x is north, y is east")
    parser.add_argument("--origin-at", nargs=2, type=float, metavar=("NORTH", "EAST"), help="point [m] of the mesh "
                        "that is at --origin (default 0 0), as of coordinates of a map projection")
    parser.add_argument("--start", type=date, default=date("2000-01-01"), metavar="DATE",
                        help="date of the time 0, UTC, as 2000-01-01 (default) or 2000-01-01T12:00:00")


def date(text):
    try:
        return datetime.datetime.fromisoformat(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text} is not a date, expected YYYY-MM-DD or YYYY-MM-DDTHH:MM:SS") from None


def check_origin(parser, origin):
    if origin is None:
        parser.error("--origin is missing: expected the longitude and latitude of the point x = y = 0")
    if not (-180 <= origin[0] <= 180 and -89 <= origin[1] <= 89):
        parser.error(f"--origin is {origin[0]:g} {origin[1]:g}, expected a longitude from -180 to 180 and a latitude "
                     "from -89 to 89 degrees")


def first_cells(catalogue):
    """[events, 7] of the cells where events began: place, length, width [m], strike and dip [degrees]."""
    cells, _ = cells_of(catalogue.path, catalogue.mesh, catalogue.attributes)
    return cells[catalogue.event["cell"].astype(int)]


def local(catalogue, at):
    """North and east [m] of the events, from the point at of the mesh or from x = y = 0, which must be near the mesh:
    it is not in coordinates of a map projection, as UTM's, whose origin is elsewhere. A point that is given may be
    farther away, but not as far as one of another mesh or zone, or east before north."""
    cells, _ = cells_of(catalogue.path, catalogue.mesh, catalogue.attributes)
    middle = (cells[:, :2].max(axis=0) + cells[:, :2].min(axis=0)) / 2
    reach = np.ptp(cells[:, :2], axis=0) + cells[:, 3].max()
    away = np.hypot(*(middle - (at or (0.0, 0.0))))
    if away > max(FALSE_ORIGIN if at is None else FALSE_POINT, np.hypot(*reach)):
        of = ("x = y = 0, the point of --origin, as where x and y are northing and easting of a map projection (UTM)"
              if at is None
              else f"the point of --origin, --origin-at {at[0]:.0f} {at[1]:.0f}")
        raise OutputError(f"{catalogue.path}: the mesh is {away / 1e3:.0f} km from {of}: expected the point [m] of the "
                          f"mesh that is at --origin, near {middle[0]:.0f} {middle[1]:.0f}, as --origin-at NORTH EAST")
    at = at or (0.0, 0.0)
    return catalogue.event["x"] - at[0], catalogue.event["y"] - at[1]


def unwrapped(lon, about):
    """Longitudes [degrees] within 180 degrees of another one: above it by -180 to 180, the upper end included."""
    return lon - 360 * np.ceil((np.asarray(lon, float) - about - 180) / 360)


def mean_place(lon, lat):
    """Mean longitude and latitude [degrees] of points [n], on whichever sides of the 180th meridian they are."""
    return float(unwrapped(np.mean(unwrapped(lon, np.ravel(lon)[0])), 0)), float(np.mean(lat))


def lonlat(north, east, origin):
    """Longitudes and latitudes [degrees], equirectangular: off by less than 1 % within 100 km up to 60 degrees."""
    latitude = origin[1] + np.degrees(np.asarray(north) / EARTH_RADIUS)
    longitude = origin[0] + np.degrees(np.asarray(east) / (EARTH_RADIUS * np.cos(np.radians(origin[1]))))
    return unwrapped(longitude, 0), latitude


def dates(catalogue, start):
    """Dates of the onsets. Calendars of other programs end with the year 9999."""
    found = []
    for number, onset in enumerate(catalogue.event["onset"].tolist()):
        try:
            found.append(start + datetime.timedelta(seconds=onset))
        except OverflowError:
            raise OutputError(f"{catalogue.path}: event {number + 1} begins {onset / YEAR:.0f} years after --start "
                              f"{start.isoformat()}, expected no date after the year 9999") from None
    return found
