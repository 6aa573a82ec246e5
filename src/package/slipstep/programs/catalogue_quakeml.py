"""The catalogue of a run as QuakeML 1.2: an event each with its origin, moment magnitude, scalar moment, and the plane
and rake of its slip.

    slipstep catalogue-quakeml EVENTS.h5 OUT.xml --origin 13.3 42.5 [--start 2000-01-01]

ObsPy and other programs of seismology read it. Angles are those of the cell where the event began. A catalogue that is
still written, EVENTS.h5.part, is read up to its last whole row.
"""

import argparse
import os
import xml.etree.ElementTree as ElementTree

import numpy as np

from ..geometry.geographic import add_arguments, check_origin, dates, first_cells, local, lonlat
from ..results.catalogue import Catalogue
from ..results.files import replacing

BED, QUAKEML = "http://quakeml.org/xmlns/bed/1.2", "http://quakeml.org/xmlns/quakeml/1.2"


def add(parent, tag, value=None, **attributes):
    """An element; with a value, a quantity <tag><value>...</value></tag>, or a word."""
    element = ElementTree.SubElement(parent, tag, attributes)
    if isinstance(value, float):
        ElementTree.SubElement(element, "value").text = repr(value)
    elif value is not None:
        element.text = value
    return element


def tree(catalogue, origin, at, start):
    """The document, an event for each row of the catalogue (QuakeML-BED-1.2, Euchner and Schorlemmer 2013)."""
    ElementTree.register_namespace("q", QUAKEML)
    root = ElementTree.Element(f"{{{QUAKEML}}}quakeml", {"xmlns": BED})
    name = "".join(c if c.isalnum() or c in "-_." else "_"
                   for c in os.path.splitext(os.path.basename(catalogue.path))[0])
    prefix = f"smi:local/{name}"
    parameters = add(root, "eventParameters", publicID=prefix)
    cells, when = first_cells(catalogue), dates(catalogue, start)
    of = catalogue.event
    longitude, latitude = lonlat(*local(catalogue, at), origin)
    rake = of["rake"] if "rake" in of else np.zeros(catalogue.count)
    for k in range(catalogue.count):
        event = add(parameters, "event", publicID=f"{prefix}/event/{k + 1}")
        ids = {kind: f"{prefix}/{kind}/{k + 1}" for kind in ("origin", "magnitude", "mechanism", "tensor")}
        for kind, tag in (("origin", "preferredOriginID"), ("magnitude", "preferredMagnitudeID"),
                          ("mechanism", "preferredFocalMechanismID")):
            add(event, tag, ids[kind])
        add(event, "type", "earthquake")
        add(add(event, "description"), "text", f"event {k + 1} of the simulation {os.path.basename(catalogue.path)}")
        place = add(event, "origin", publicID=ids["origin"])
        add(add(place, "time"), "value", when[k].isoformat(timespec="microseconds") + "Z")
        add(place, "longitude", float(longitude[k]))
        add(place, "latitude", float(latitude[k]))
        add(place, "depth", float(of["z"][k]))
        add(place, "evaluationMode", "automatic")
        if np.isfinite(of["magnitude"][k]):
            size = add(event, "magnitude", publicID=ids["magnitude"])
            add(size, "mag", float(of["magnitude"][k]))
            add(size, "type", "Mw")
            add(size, "originID", ids["origin"])
        else:
            event.remove(event.find("preferredMagnitudeID"))
        mechanism = add(event, "focalMechanism", publicID=ids["mechanism"])
        plane = add(add(mechanism, "nodalPlanes", preferredPlane="1"), "nodalPlane1")
        add(plane, "strike", float(cells[k, 5] % 360))
        add(plane, "dip", float(cells[k, 6]))
        add(plane, "rake", float(rake[k]))
        tensor = add(mechanism, "momentTensor", publicID=ids["tensor"])
        add(tensor, "derivedOriginID", ids["origin"])
        add(tensor, "scalarMoment", float(of["moment"][k]))
    return ElementTree.ElementTree(root)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("catalogue", metavar="EVENTS", help="file of -fault_catalogue")
    parser.add_argument("output", metavar="OUT", help="file to write")
    add_arguments(parser)
    options = parser.parse_args()
    check_origin(parser, options.origin)
    catalogue = Catalogue(options.catalogue)
    catalogue.warn()
    document = tree(catalogue, options.origin, options.origin_at, options.start)
    ElementTree.indent(document)
    with replacing(options.output, options.catalogue) as part:
        document.write(part, encoding="utf-8", xml_declaration=True)
    print(f"QuakeML: {options.output}, {catalogue.count} events")
