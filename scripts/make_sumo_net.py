"""Make scenarios/urban.net.xml, the SUMO net of urban.xodr, with netconvert (extra `sumo`: the package eclipse-sumo).

    python -m scripts.make_sumo_net [XODR NET]

netconvert writes the time and its command line into the file; both go, so that the same road gives the same bytes.
Only driving lanes are taken over (netconvert's defaults make sidewalks drivable), and who may use them is set here.
Coordinates stay those of the OpenDRIVE file. Its traffic lights are left out: the storyboard switches them, and SUMO
would run programs of its own.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from xml.etree import ElementTree as ET

SCENARIOS = Path(__file__).resolve().parents[1] / "scenarios"
OPTIONS = {
    "--offset.disable-normalization": "true",  # keep the coordinates of the OpenDRIVE file
    "--opendrive.curve-resolution": "0.5",  # m
    "--opendrive.import-all-lanes": "false",  # driving lanes only, no sidewalks
    "--no-turnarounds": "true",
    "--junctions.join": "false",
    "--precision": "3",
}
CLASSES = "passenger delivery bus"
SCHEMA = "http://www.w3.org/2001/XMLSchema-instance"


def convert(xodr: Path, net: Path) -> None:
    """Run netconvert. Raises subprocess.CalledProcessError with its message when it fails."""
    import sumo  # type: ignore[import-untyped]

    home = Path(sumo.SUMO_HOME)
    unlit = net.with_suffix(".xodr")
    road = ET.parse(xodr)
    for item in road.getroot().iter("road"):
        for signals in item.findall("signals"):
            item.remove(signals)
    road.write(unlit)
    command = [str(home / "bin" / "netconvert"), "--opendrive-files", str(unlit), "-o", str(net)]
    for name, value in OPTIONS.items():
        command += [name, value]
    subprocess.run(command, check=True, env={**os.environ, "SUMO_HOME": str(home)}, stdout=subprocess.DEVNULL)


def clean(net: Path) -> str:
    """The net without comments, schema address and default permissions; indented, in document order."""
    root = ET.parse(net).getroot()  # the parser drops comments
    root.attrib.pop(f"{{{SCHEMA}}}noNamespaceSchemaLocation", None)
    for lane in root.iter("lane"):
        lane.attrib.pop("disallow", None)
        lane.set("allow", CLASSES)
    for kind in root.findall("type"):
        root.remove(kind)
    for element in [*root.iter("edge"), *root.iter("lane")]:
        element.attrib.pop("type", None)
    ET.indent(root)
    text = '<?xml version="1.0" encoding="UTF-8"?>\n<!-- Made by scripts/make_sumo_net.py; do not edit. -->\n'
    return text + ET.tostring(root, encoding="unicode") + "\n"


def main(argv: list[str]) -> None:
    xodr, target = (Path(argv[0]), Path(argv[1])) if argv else (SCENARIOS / "urban.xodr", SCENARIOS / "urban.net.xml")
    with tempfile.TemporaryDirectory() as folder:
        raw = Path(folder) / "raw.net.xml"
        convert(xodr, raw)
        target.write_text(clean(raw), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
