"""What was understood of a file, in lines for the user."""

import numpy as np

from ..geometry.cells import axis_along_strike, directions
from ..results.moment import magnitude


def span(values, scale=1.0, digits=6):
    """Least to largest, lengths and angles to so many decimals; digits None: fields, as slip rates, as they are."""
    low, high = (v / scale for v in (np.min(values), np.max(values)))
    if digits is None:
        return f"{low:.6g}" if np.isclose(low, high, atol=0) else f"{low:.6g} to {high:.6g}"
    low, high = (0.0 + np.round(v, digits) for v in (low, high))
    return f"{low:.{digits}g}" if np.isclose(low, high) else f"{low:.{digits}g} to {high:.{digits}g}"


def angle_span(degrees, least):
    """Of strikes, from 0, and rakes, from -180 on."""
    degrees = np.asarray(degrees) % 360
    turned = (degrees - degrees[0] + 180) % 360 - 180 + degrees[0]
    turned = np.round(turned + 360 * np.ceil((least - turned.min() - 1e-3) / 360), 3)
    return span(turned) if turned.max() < least + 360 else f"{turned.min():.6g} to {turned.max() - 360:.6g}"


def against(value, claimed):
    """A number of the header, and by how much ours is off."""
    return f"; the header has {claimed:.5g}" + (f", ours is {100 * (value / claimed - 1):+.2f} %" if claimed else "")


def size_of(model):
    """Length and width [km]: segments one after the other; else along the mean strike and down dip."""
    from .fsp import extent
    if model.segments and all(part.shape for part in model.segments):
        return tuple(v / 1e3 for v in extent(model, model.segments))
    corners = model.corners.reshape(-1, 3)
    weight = model.area
    dip = float(np.average(model.cells[:, 6], weights=weight))
    along, down = (v[0]
                   for v in directions(np.array([[0, 0, 0, 0, 0, axis_along_strike(model.cells[:, 5], weight), dip]])))
    return float(np.ptp(corners @ along)) / 1e3, float(np.ptp(corners[:, 2]) / max(np.sin(np.radians(dip)), 0.05)) / 1e3


def lines(model):
    """Name and text of each line."""
    claims, cells, corners = model.claims, model.cells, model.corners
    faults, shapes = np.unique(model.fault), [f"{part.shape[1]} x {part.shape[0]}" for part in model.segments
                                              if part.shape]
    kind = "triangles" if model.triangles is not None else "cells"
    lengths = "" if model.triangles is not None else f" of {span(cells[:, 3], 1e3)} x {span(cells[:, 4], 1e3)} km"
    grids = (f", {' and '.join(shapes[:4])}{' ...' if len(shapes) > 4 else ''} (along strike, down dip)" if shapes
             else "")
    yield "format", f"{model.kind}, lengths in {model.unit}"
    yield kind, f"{len(cells)}{lengths} in {len(faults)} fault{'s' * (len(faults) > 1)}{grids}"
    yield "frame", model.projection.words if model.projection else "x north, y east of the file's own origin"
    yield "extent", (", ".join(f"{name} {span(corners[..., k], 1e3)}"
                               for k, name in enumerate(("north", "east", "depth"))) + " km"
                     + (f"; the header has the upper edge at {claims['top'] / 1e3:g}" if "top" in claims else ""))
    length, width = size_of(model)
    yield "size", f"{length:.6g} x {width:.6g} km" + (f"; the header has {claims['length'] / 1e3:g} x "
                                                      f"{claims['width'] / 1e3:g}" if "length" in claims
                                                      and "width" in claims else "")
    area = model.area.sum() / 1e6
    claimed = claims.get("area") or (claims["length"] * claims["width"] if "length" in claims and "width" in claims
                                     else None)
    yield "area", f"{area:.6g} km2" + (against(area, claimed / 1e6) if claimed else "")
    yield "strike, dip", f"{angle_span(cells[:, 5], 0)}, {span(np.round(cells[:, 6], 3))} degrees" + (
        f"; the header has {claims['strike']:g}, {claims['dip']:g}" if "strike" in claims and "dip" in claims else "")
    if "hypocentre" in claims:
        lon, lat, deep = claims["hypocentre"]
        yield "hypocentre", f"{lon:.5g} E, {lat:.5g} N, depth {deep / 1e3:.4g} km"
    if model.slip is not None and not np.any(model.slip):
        yield "slip", f"none: it is 0 m in all of the {len(cells)} {kind}, so that there is no moment and no magnitude"
    elif model.slip is not None:
        mean = float(model.area @ np.abs(model.slip)) / model.area.sum()
        yield "slip", f"{span(model.slip, 1, 5)} m, mean {mean:.4g} m, rake {angle_span(model.rake, -180)} degrees"
        moment, words = model.moment()
        yield "moment", (f"{moment:.5g} N m, Mw {magnitude(moment):.2f}, by {words}"
                         + (against(moment, claims["moment"]) if claims.get("moment") else ""))
        if claims.get("moment") and model.potency > 0:
            yield ("by the header", f"a rigidity of {claims['moment'] / model.potency / 1e9:.4g} GPa would give this "
                   "slip its moment: --rigidity header")
        (shear, poisson), words = model.rock(), model.rigidity()[1]
        yield ("elastic", f"by {words if words.startswith('G =') else f'G = {shear / 1e9:.5g} GPa, that of {words}'}, "
               f"Poisson's ratio {poisson:g}")
    for name, (values, unit) in sorted(model.columns.items()):
        yield name.replace("_", " "), f"{span(values, 1, 5)} {unit}"
    for name, (values, unit) in model.fields.items():
        yield name, span(values, digits=None) + ("" if unit == "1" else f" {unit}")
    if model.options:
        yield "options", " ".join(f"-fault_{name} {value:g}" if isinstance(value, float) else f"-fault_{name} {value}"
                                  for name, value in model.options.items())
    if (above := corners[..., 2].min()) < -1e-6 * max(np.ptp(corners),
                                                      1) and model.options.get("kernel") != "full_space":
        yield ("note", f"cells reach {-above:.4g} m above the ground, where fault and elastic refuse them: --shift "
               "moves all down")
    for remark in model.remarks:
        yield "note", remark
    for what in model.dropped:
        yield "dropped", what
