"""Drive the surrogate and write a measured log.

python -m vehicle.surrogate --drive rich --hidden F.toml --out log.csv
python -m vehicle.surrogate --hidden F.toml --out log.csv --truth true.mcap    and what was true, for grading
python -m vehicle.surrogate --dds 42 --hidden F.toml           as a car on the wire, for pytest -m rw
python -m vehicle.surrogate --dds 42 --can socketcan:vcan0     with its drive-by-wire on CAN
python -m vehicle.surrogate --dds 42 --clock real              by the wall clock
python -m vehicle.surrogate --ros1 /car --ros1-file ros1.toml  over ROS 1, its topics under /car
python -m vehicle.surrogate --check --hidden F.toml            says what is wrong with the file, and drives nothing
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from vehicle.surrogate.driver import Driver
from vehicle.surrogate.hidden import PERCEPTION, Hidden, HiddenError, read_hidden

if TYPE_CHECKING:
    from vehicle.surrogate.truth import Truth
    from vehicle.wire.end import Opener


def main(argv: list[str] | None = None) -> int:
    """Returns the exit code: 0 written, served or right, 2 a wrong option or file."""
    parser = argparse.ArgumentParser(prog="python -m vehicle.surrogate", description=(__doc__ or "").split("\n")[0])
    parser.add_argument(
        "--drive", choices=("rich", "urban"), default="rich", help="drive: rich (120 s) or urban (45 s)"
    )
    parser.add_argument(
        "--hidden", type=Path, metavar="F.toml", help="file with the hidden effects of the car; default: none"
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of drive and sensor noise")
    parser.add_argument("--out", type=Path, metavar="LOG.csv")
    parser.add_argument(
        "--truth", type=Path, metavar="F.mcap", help="also write the true motion, and where road users truly were"
    )
    parser.add_argument("--dds", type=int, metavar="DOMAIN", help="act as a car on this DDS domain (0 to 232) instead")
    parser.add_argument("--ros1", metavar="NAMESPACE", help="act as a car on ROS 1, with topics under this name, or ''")
    parser.add_argument(
        "--ros1-file", type=Path, metavar="F.toml", help="file that says how ROS 1 is reached (vehicle/wire/ros1.py)"
    )
    parser.add_argument("--can", metavar="BUS", help="with --dds: commands come over CAN, as udp_multicast:GROUP:PORT")
    parser.add_argument(
        "--dbc",
        type=Path,
        metavar="F.dbc",
        help="messages on that bus, with the signal map next to them; default: those that ship",
    )
    parser.add_argument("--clock", choices=("stepped", "real"), default="stepped", help="clock on a wire")
    parser.add_argument("--at", type=float, nargs=3, metavar=("X", "Y", "YAW"), help="initial pose on a wire")
    parser.add_argument("--driver", action="store_true", help="act as a real car: also report the driver's hands")
    parser.add_argument("--check", action="store_true", help="read the file of --hidden and do nothing else")
    args = parser.parse_args(argv)
    if not args.check and [args.out, args.dds, args.ros1].count(None) != 2:
        parser.error("one of --out LOG.csv, --dds DOMAIN and --ros1 NAMESPACE is needed")
    if args.ros1_file is not None and args.ros1 is None:
        parser.error("--ros1-file F.toml needs --ros1 NAMESPACE")
    if (args.can is not None and args.dds is None) or (args.dbc is not None and args.can is None):
        parser.error("--can BUS needs --dds DOMAIN, --dbc F.dbc needs --can BUS")
    try:
        hidden = read_hidden(args.hidden) if args.hidden else Hidden()
    except HiddenError as error:
        print(error, file=sys.stderr)
        return 2
    if args.check:
        return 0
    if args.out is None:
        return _serve(args, hidden)
    seeing = [name for name in hidden.effects if name in PERCEPTION]
    if seeing:
        print(
            f"{args.hidden}: {seeing[0]} is of what a car on a wire sees; a drive has nothing to see", file=sys.stderr
        )
        return 2
    from vehicle.surrogate.recorder import record, write_csv  # compiles; not before the file is known to be good

    truth = _truth(args)
    columns = record(hidden, args.drive, args.seed, truth)
    try:
        write_csv(args.out, columns)
        if truth is not None:
            truth.write(args.truth)
    except OSError as error:
        print(f"{error.filename}: cannot be written: {error.strerror}", file=sys.stderr)
        return 2
    print(f"{args.out}: {Driver(args.drive, 1.0, args.seed).length:g} s, 50 Hz", file=sys.stderr)
    return 0


def _truth(args: argparse.Namespace) -> Truth | None:
    from vehicle.surrogate.truth import Truth

    return None if args.truth is None else Truth(args.seed)


def _serve(args: argparse.Namespace, hidden: Hidden) -> int:
    from vehicle.surrogate.ecu import DriveByWire
    from vehicle.surrogate.node import Node, end_with_parent
    from vehicle.wire.can_link import BusError
    from vehicle.wire.can_map import CanMapError, find_map

    serving: list[Node] = []
    truth = _truth(args)

    def leave() -> None:
        """A roscore keeps whoever does not leave it; DDS finds out by itself. Then what was true is written."""
        for node in serving if args.ros1 is not None else ():
            node.close()
        if truth is not None:
            truth.write(args.truth)

    end_with_parent(leave)
    try:
        unit = None if args.can is None else DriveByWire(args.can, find_map(args.dbc))
        opener = _wire(args)
        if args.clock == "real":
            from vehicle.surrogate.live import LiveNode

            at = args.at or (0.0, 0.0, 0.0)
            serving.append(LiveNode(opener, hidden, args.seed, unit, at=at, driver=args.driver, truth=truth))
        else:
            serving.append(Node(opener, hidden, args.seed, unit, truth=truth))
        serving[0].serve()
    except (BusError, CanMapError, _WireError) as error:
        print(error, file=sys.stderr)
        return 2
    return 0


class _WireError(Exception):
    """A wire that cannot be opened."""


def _wire(args: argparse.Namespace) -> Opener:
    """Raises _WireError; what it gives does too."""
    if args.dds is not None:
        from vehicle.wire.dds import on_domain

        return on_domain(args.dds, network=args.driver)
    from vehicle.wire.ros1 import Ros1Error, on_ros1, read_settings

    try:
        settings = read_settings(args.ros1_file, {"hidden": str})
    except Ros1Error as error:
        raise _WireError(error) from None
    return on_ros1(settings, "car", within=args.ros1, error=_WireError)


if __name__ == "__main__":
    raise SystemExit(main())
