"""Drive the surrogate and write a measured log.

python -m vehicle.surrogate --drive rich --hidden F.toml --out log.csv
python -m vehicle.surrogate --dds 42 --hidden F.toml           as a car on the wire, for pytest -m rw
python -m vehicle.surrogate --dds 42 --can socketcan:vcan0     with its drive-by-wire on CAN
python -m vehicle.surrogate --dds 42 --clock real              by the wall clock
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from vehicle.surrogate.driver import Driver
from vehicle.surrogate.hidden import Hidden, HiddenError, read_hidden


def main(argv: list[str] | None = None) -> int:
    """Returns the exit code: 0 written or served, 2 a wrong option or file."""
    parser = argparse.ArgumentParser(prog="python -m vehicle.surrogate", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--drive", choices=("rich", "urban"), default="rich", help="programme: 120 s or 45 s")
    parser.add_argument("--hidden", type=Path, metavar="F.toml", help="what is hidden in the car; default: nothing")
    parser.add_argument("--seed", type=int, default=0, help="of drive and sensor noise")
    parser.add_argument("--out", type=Path, metavar="LOG.csv")
    parser.add_argument("--dds", type=int, metavar="DOMAIN", help="be a car on this DDS domain (0 to 232) instead")
    parser.add_argument("--can", metavar="BUS", help="with --dds: commands come over CAN, as udp_multicast:GROUP:PORT")
    parser.add_argument("--dbc", type=Path, metavar="F.dbc", help="messages there, signal map beside it; default: ours")
    parser.add_argument("--clock", choices=("stepped", "real"), default="stepped", help="with --dds: whose time counts")
    args = parser.parse_args(argv)
    if (args.out is None) == (args.dds is None):
        parser.error("one of --out LOG.csv and --dds DOMAIN is needed")
    if (args.can is not None and args.dds is None) or (args.dbc is not None and args.can is None):
        parser.error("--can BUS needs --dds DOMAIN, --dbc F.dbc needs --can BUS")
    try:
        hidden = read_hidden(args.hidden) if args.hidden else Hidden()
    except HiddenError as error:
        print(error, file=sys.stderr)
        return 2
    if args.dds is not None:
        return _serve(args.dds, hidden, args.seed, args.can, args.dbc, args.clock)
    from vehicle.surrogate.recorder import record, write_csv  # compiles; not before the file is known to be good

    columns = record(hidden, args.drive, args.seed)
    try:
        write_csv(args.out, columns)
    except OSError as error:
        print(f"{args.out}: cannot be written: {error.strerror}", file=sys.stderr)
        return 2
    print(f"{args.out}: {Driver(args.drive, 1.0, args.seed).length:g} s, 50 Hz", file=sys.stderr)
    return 0


def _serve(domain: int, hidden: Hidden, seed: int, bus: str | None, dbc: Path | None, clock: str) -> int:
    from vehicle.surrogate.ecu import DriveByWire
    from vehicle.surrogate.node import Node, end_with_parent
    from vehicle.wire.can_link import BusError
    from vehicle.wire.can_map import CanMapError, find_map
    from vehicle.wire.dds import on_domain

    end_with_parent()
    try:
        unit = None if bus is None else DriveByWire(bus, find_map(dbc))
    except (BusError, CanMapError) as error:
        print(error, file=sys.stderr)
        return 2
    if clock == "real":
        from vehicle.surrogate.live import LiveNode

        LiveNode(on_domain(domain), hidden, seed, unit).serve()
    Node(on_domain(domain), hidden, seed, unit).serve()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
