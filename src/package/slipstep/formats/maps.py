"""Faults of databases: traces with dip and depths, .geojson, as those of active faults have them, become rectangles;
depths in a grid of longitudes and latitudes, .xyz or .grd, as models of slabs have them, triangles."""

import json
import re

import h5py
import numpy as np

from ..geometry.geographic import mean_place, unwrapped
from .model import Model
from .ours import cells_of_triangles
from .text import NUMBER, FormatError, Text, beyond, unused

KM = 1e3
DEEPEST = 800.0  # [km], of faults and slabs
# Names of properties in small letters without signs -> what they are
PROPERTIES = {
    "dip": ("dip", "dipdeg", "averagedip", "dipangle", "dippref", "prefdip"),
    "top": ("updepth", "upperdepth", "upperseisdepth", "upperseismogenicdepth", "upperd", "mindepth", "topdepth",
            "depthtop", "ztop", "top"),
    "bottom": ("lowdepth", "lowerdepth", "lowerseisdepth", "lowerseismogenicdepth", "lowerd", "maxdepth", "bottomdepth",
               "depthbottom", "zbot", "bottom"),
    "rake": ("rake", "rakedeg", "averagerake", "rakepref", "prefrake"),
    "side": ("dipdir", "dipdirection", "dipdirdeg"),
    "name": ("faultname", "name", "sectionname", "faultsectionname"),
}
MEANING = {word: what for what, words in PROPERTIES.items() for word in words}
COMPASS = {name: 22.5 * k for k, name in enumerate("N NNE NE ENE E ESE SE SSE S SSW SW WSW W WNW NW NNW".split())}


def first_number(value):
    """A property as a number; the first of several, the best, as of "(60,45,75)"; None: there is none."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value) if np.isfinite(value) else None
    found = re.search(NUMBER, str(value))
    return float(found[1]) if found else None


def lines_of(path, number, geometry):
    """Longitudes and latitudes [n, 2] of each line of a feature."""
    kind, lines = (geometry or {}).get("type"), (geometry or {}).get("coordinates")
    if kind not in ("LineString", "MultiLineString"):
        raise FormatError(f"{path}, feature {number}: the geometry {kind}, expected the LineString or MultiLineString "
                          "of a fault's trace")
    found = []
    try:
        for line in lines if kind == "MultiLineString" else [lines]:
            places = np.array([[float(v) for v in place[:2]] for place in line]).reshape(-1, 2)
            found.append(places[np.concatenate([[True], (np.diff(places, axis=0) != 0).any(axis=1)])])
    except (TypeError, ValueError):
        raise FormatError(f"{path}, feature {number}: coordinates that are no numbers, expected longitudes "
                          "and latitudes") from None
    if not all(len(line) > 1 and (np.abs(line) <= (360, 89)).all() for line in found):
        raise FormatError(f"{path}, feature {number}: expected two or more different points in each line, longitudes "
                          "from -360 to 360 and latitudes from -89 to 89 degrees (GeoJSON has no other coordinates)")
    return found


def traces(path):
    """What features are of a file: their properties by what they mean, with "lines"; and names of other properties."""
    text = Text(path)
    try:
        content = json.loads("\n".join(text.lines))
        features = content["features"] if content.get("type") == "FeatureCollection" else [content]
        features = [(feature.get("geometry"), dict(feature.get("properties") or {})) for feature in features]
    except json.JSONDecodeError as error:
        text.fail(error.lineno, error.msg, "GeoJSON")
    except (AttributeError, KeyError, TypeError, ValueError):
        raise FormatError(f"{path}: expected GeoJSON, a FeatureCollection of traces of faults") from None
    found, others = [], []
    for number, (geometry, properties) in enumerate(features, 1):
        said = {}
        for name, value in properties.items():
            what = MEANING.get(re.sub("[^a-z]", "", name.lower()))
            if what and what not in said and value is not None:
                said[what] = str(value) if what in ("name", "side") else first_number(value)
            else:
                others.append(name)
        found.append((said, geometry, number))
    return found, others


def turned(side, strike):
    """Whether a plane that dips to a side (compass or degrees) has the strike opposite to that of its trace."""
    letters = re.sub("[^A-Z]", "", re.sub("(N|S|E|W)(ORTH|OUTH|AST|EST)", r"\1", (side or "").upper()))
    degrees = COMPASS.get(letters, first_number(side))
    return degrees is not None and np.cos(np.radians(degrees - strike) - np.pi / 2) < 0


def read_traces(path, at, rake=None):
    """The model of traces: a rectangle below each part, dipping to its right, or where the file says to."""
    features, others = traces(path)
    whole = [(said, lines_of(path, number, geometry), number) for said, geometry, number in features
             if all(said.get(name) is not None for name in ("dip", "top", "bottom"))]
    if not whole:
        have = ", ".join(dict.fromkeys(others)) or "none"
        raise FormatError(f"{path} has {len(features)} features of GeoJSON, and none has a dip, an upper and a lower "
                          f"depth; expected properties as dip, upper_depth and lower_depth (its others are {have})")
    projection = at(*mean_place(*np.concatenate([line for _, lines, _ in whole for line in lines]).T))
    rows, label, rakes, names, guessed = [], [], [], {}, 0
    for said, lines, number in whole:
        dip, top, bottom = said["dip"], said["top"], said["bottom"]
        if not 0 < dip <= 90 or not 0 <= top < bottom <= DEEPEST:
            raise FormatError(f"{path}, feature {number}: a dip of {dip:g} and depths of {top:g} and {bottom:g}, "
                              f"expected 0 < dip <= 90 degrees and 0 <= upper < lower <= {DEEPEST:g} km")
        for line in lines:
            north, east = projection.forward(*line.T)
            if turned(said.get("side"), np.degrees(np.arctan2(east[-1] - east[0], north[-1] - north[0]))
                      + projection.convergence(north.mean(), east.mean())):
                north, east = north[::-1], east[::-1]
            for k in range(len(north) - 1):
                strike = np.arctan2(east[k + 1] - east[k], north[k + 1] - north[k])
                out = KM * (top + bottom) / 2 / np.tan(np.radians(dip))
                rows.append([(north[k] + north[k + 1]) / 2 - out * np.sin(strike),
                             (east[k] + east[k + 1]) / 2 + out * np.cos(strike), KM * (top + bottom) / 2,
                             np.hypot(north[k + 1] - north[k], east[k + 1] - east[k]),
                             KM * (bottom - top) / np.sin(np.radians(dip)), np.degrees(strike) % 360, dip])
                label.append(number)
                rakes.append(said.get("rake") if said.get("rake") is not None else 0.0 if rake is None else rake)
                guessed += said.get("rake") is None and rake is None
        names[number] = said.get("name", "")
    model = Model(path, "traces of faults, GeoJSON", np.array(rows), np.array(rakes), fault=np.array(label),
                  names={k: name for k, name in names.items() if name}, projection=projection, unit="km")
    model.remarks.append("traces are taken to be at the ground, from where planes go down, to the right of a trace "
                         "unless the file says where to")
    if guessed:
        model.remarks.append(f"{guessed} cells have no rake; it is 0, or --rake")
    if len(rows) > sum(len(lines) for _, lines, _ in whole) and (model.cells[:, 6] < 90).any():
        model.remarks.append("where a trace bends, the dipping planes on both sides of the bend overlap or leave a "
                             "gap at depth")
    if left := [said.get("name") or f"feature {number}" for said, _, number in features if number not in names]:
        model.dropped.append(f"{len(left)} traces without a dip or depths "
                             f"({', '.join(left[:4])}{', ...' if len(left) > 4 else ''})")
    model.dropped += unused(others, (), "property")
    return model


# ---- depths in a grid ----

def is_grid(file):
    """Whether an HDF5 file is a grid of netCDF-4."""
    return getattr(file.get("z"), "ndim", 0) == 2 and any(x in file and y in file
                                                          for x, y in (("x", "y"), ("lon", "lat")))


def rows_of(path):
    """Longitude, latitude and depth [n, 3] of a file of text, NaN where none, and a line of what else it has."""
    text, rows, split = Text(path), [], []
    for line, words in text:
        words = words.replace(",", " ").split()
        if not words or words[0].startswith(("#", ">")):
            continue
        if not rows and not re.fullmatch(NUMBER, words[0]):
            continue  # names
        if len(words) < 3:
            text.fail(line, f"{len(words)} words", "longitude, latitude and depth")
        rows.append([text.number(line, word) for word in words[:2]]
                    + [np.nan if words[2].lower().lstrip("-+") == "nan" else text.number(line, words[2])])
        split.append(words)
    if not rows:
        text.fail(len(text) + 1, "", "rows of longitude, latitude and depth")
    return np.array(rows), beyond(split, 3)


def grid_of_rows(path, rows):
    """Longitudes, latitudes and depths [n, m] of rows in any order."""
    lon, column = np.unique(np.round(unwrapped(rows[:, 0], rows[0, 0]), 7), return_inverse=True)
    lat, row = np.unique(np.round(rows[:, 1], 7), return_inverse=True)
    if len(np.unique(row * len(lon) + column)) < len(rows) or len(rows) < 0.1 * len(lon) * len(lat):
        raise FormatError(f"{path}: {len(rows)} points of {len(lon)} longitudes and {len(lat)} latitudes, expected a "
                          "grid of both, as of a model of a slab")
    depth = np.full((len(lat), len(lon)), np.nan)
    depth[row, column] = rows[:, 2]
    return lon, lat, depth


def read_depths(path, at, rake=None, unit=None):
    """The model of triangles between points of a grid with depths [km] (--unit m: [m]), all of one sign."""
    if h5py.is_hdf5(path):
        with h5py.File(path) as file:
            x, y = ("x", "y") if "x" in file else ("lon", "lat")
            (lon, lat, depth), left = (np.array(file[name], float) for name in (x, y, "z")), unused(file, (x, y, "z"))
        if depth.shape != (len(lat), len(lon)):
            raise FormatError(f"{path}: /z has the shape {depth.shape}, expected {(len(lat), len(lon))}, that of "
                              f"/{y} and /{x}")
    else:
        rows, left = rows_of(path)
        lon, lat, depth = grid_of_rows(path, rows)
    known = np.isfinite(depth)
    if not (np.abs(lon) <= 360).all() or not (np.abs(lat) <= 89).all():
        raise FormatError(f"{path}: longitudes from {lon.min():g} to {lon.max():g} and latitudes from {lat.min():g} to "
                          f"{lat.max():g}, expected degrees")
    # of each square of four points, one after the other
    corner = [np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, 1:], np.s_[1:, :-1]]
    number = np.arange(depth.size).reshape(depth.shape)
    square = np.stack([number[at_corner].ravel() for at_corner in corner], axis=1)
    there = known.ravel()[square]
    three = there.sum(axis=1) == 3
    parts = [square[there.all(axis=1)][:, [0, 1, 2]], square[there.all(axis=1)][:, [0, 2, 3]],
             square[three][there[three]].reshape(-1, 3)]
    triangles = np.concatenate(parts)
    if not len(triangles):
        raise FormatError(f"{path}: a grid of depths of {len(lon)} longitudes and {len(lat)} latitudes, of which "
                          f"{known.sum()} points have one, expected three beside each other or more")
    depth = np.where(known, depth, 0.0)
    if depth.min() < 0 < depth.max():
        raise FormatError(f"{path}: depths from {depth[known].min():g} to {depth[known].max():g}, expected all "
                          "positive or all negative ones")
    depth = np.abs(depth) * {"m": 1.0, "km": KM, None: KM}[unit]
    if depth.max() > KM * DEEPEST:
        raise FormatError(f"{path}: depths down to {depth.max() / KM:g} km, expected {DEEPEST:g} km at most"
                          + (", or --unit m" if unit is None else ""))
    lon, lat = (values.ravel() for values in np.meshgrid(lon, lat))
    used = np.unique(triangles)
    projection = at(*mean_place(lon[used], lat[used]))
    north, east = projection.forward(lon, lat)
    cells, corners = cells_of_triangles(np.stack([north, east, depth.ravel()], axis=1)[triangles])
    model = Model(path, "grid of depths", cells, np.full(len(cells), 0.0 if rake is None else rake), triangles=corners,
                  fault=np.ones(len(cells), int), projection=projection, unit=unit or "km")
    model.remarks.append(f"{known.sum()} of {known.size} points of the grid have a depth"
                         + ("; the rake is 0, or --rake" if rake is None else ""))
    model.dropped += left
    return model
