"""The far end of a bridge: modules that need an interpreter of their own (rospy, carla), used from another process.

    python interpreter_server.py FD [FOLDER...]

FD is a socket to `vehicle.interpreter_bridge.Bridge`; modules are looked for in the FOLDERs.

A frame is two lengths (u32, little-endian), a JSON object and bytes. Asked with {"n": 7, "do": ...} it answers with
{"n": 7, "value": ...} or {"n": 7, "error": kind, "text": ...}. Objects stay here; the asker has a number: {"$": 3}.
A ROS 1 node's messages go as bytes, in and out, with {"topic": i}. A thread beats every 20 ms.

Standard library only, Python 3.6 and later: it runs under whatever interpreter has the module. Ends when the socket
closes.
"""

import importlib
import json
import os
import select
import socket
import struct
import sys
import threading
import warnings
from typing import Any, Dict, List, Optional, Tuple

BEAT = 0.02  # s
LENGTHS = struct.Struct("<II")
PLAIN = (bool, int, float, str, type(None))


class Wire:
    """Frames on a socket; several threads may write."""

    def __init__(self, fd: int) -> None:
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM, fileno=fd)
        self._lock = threading.Lock()

    def write(self, head: Dict[str, Any], body: bytes = b"") -> None:
        """Send a frame. Ends the process if nobody is there."""
        text = json.dumps(head).encode()
        try:
            with self._lock:
                self._socket.sendall(LENGTHS.pack(len(text), len(body)) + text + body)
        except OSError:
            os._exit(0)

    def waits(self, seconds: Optional[float]) -> bool:
        """Whether something is to be read within this time; None: until it is."""
        return bool(select.select([self._socket], [], [], seconds)[0])

    def read(self) -> Tuple[Dict[str, Any], bytes]:
        """The next frame. Ends the process if nobody is there."""
        text, body = LENGTHS.unpack(self._exactly(LENGTHS.size))
        return json.loads(self._exactly(text).decode()), self._exactly(body)

    def _exactly(self, count: int) -> bytes:
        parts = []
        while count:
            try:
                part = self._socket.recv(min(count, 1 << 20))
            except OSError:
                part = b""
            if not part:
                leave()
            parts.append(part)
            count -= len(part)
        return b"".join(parts)

    def beat(self) -> None:
        """Say that this process lives, for ever."""
        k, pause = 0, threading.Event()
        while True:
            self.write({"beat": k})
            k += 1
            pause.wait(BEAT)


class Objects:
    """Objects of this interpreter, used by number."""

    def __init__(self) -> None:
        self._held: Dict[int, Any] = {}
        self._next = 0

    def packed(self, value: Any) -> Any:
        """A value for JSON: plain ones as they are, lists of them too, others by number."""
        if isinstance(value, PLAIN):
            return value
        if isinstance(value, (list, tuple)):
            return [self.packed(item) for item in value]
        self._next += 1
        self._held[self._next] = value
        return {"$": self._next}

    def unpacked(self, value: Any) -> Any:
        """What such a value stands for."""
        if isinstance(value, list):
            return [self.unpacked(item) for item in value]
        return self._held[value["$"]] if isinstance(value, dict) else value

    def do(self, ask: Dict[str, Any]) -> Any:
        """What is asked for: import, get, set, call, list, drop. Raises ValueError for anything else."""
        what = ask["do"]
        if what == "import":
            return self.packed(importlib.import_module(ask["module"]))
        if what == "drop":
            for number in ask["of"]:
                self._held.pop(number, None)
            return None
        of = self._held[ask["of"]]
        if what == "get":
            return self.packed(getattr(of, ask["name"]))
        if what == "set":
            setattr(of, ask["name"], self.unpacked(ask["to"]))
            return None
        if what == "list":
            return [self.packed(item) for item in of]
        if what == "call":
            given = {name: self.unpacked(value) for name, value in ask["named"].items()}
            return self.packed(of(*self.unpacked(ask["given"]), **given))
        raise ValueError("nothing is known of " + what)


class Node:
    """A ROS 1 node: it passes on the bytes of messages, and needs no package of theirs."""

    def __init__(self, wire: Wire) -> None:
        self._wire = wire
        self._out: List[Any] = []
        self._in: List[Any] = []

    def open(self, ask: Dict[str, Any]) -> None:
        """Join the graph. Raises OSError if no master answers."""
        import rosgraph
        import rospy

        warnings.filterwarnings("ignore", "The publisher should be created")  # without a queue it is at once: meant
        master = rosgraph.Master("/" + ask["name"])
        try:
            master.getPid()
        except Exception as error:
            raise OSError("no roscore answers at %s (%s)" % (master.master_uri, error)) from None
        rospy.init_node(ask["name"], disable_signals=True, disable_rosout=True, log_level=rospy.ERROR)
        self._out = [
            rospy.Publisher(each["name"], raw(rospy, each), queue_size=None, tcp_nodelay=True) for each in ask["writes"]
        ]
        self._in = [
            rospy.Subscriber(each["name"], raw(rospy, each), self._pass, callback_args=k, tcp_nodelay=True)
            for k, each in enumerate(ask["reads"])
        ]

    def matched(self, wanted: List[int]) -> bool:
        """Whether each of these topics, those written first, has found its other end."""
        every = self._out + self._in
        return all(every[k].get_num_connections() > 0 for k in wanted)

    def publish(self, topic: int, body: bytes) -> None:
        """Put the bytes of a message on topic number `topic`."""
        publisher = self._out[topic]
        publisher.publish(publisher.data_class(body))

    def _pass(self, message: Any, topic: int) -> None:
        self._wire.write({"topic": topic}, message.body)


def raw(rospy: Any, topic: Dict[str, str]) -> Any:
    """A class of messages that are bytes, under the type, checksum and definition of the topic."""

    def __init__(self: Any, body: bytes = b"") -> None:
        self.body = body

    def serialize(self: Any, buff: Any) -> None:
        buff.write(self.body)

    def deserialize(self: Any, body: bytes) -> Any:
        self.body = body
        return self

    names = {"_type": topic["type"], "_md5sum": topic["md5"], "_full_text": topic["text"], "_has_header": False}
    slots = {"__slots__": ["body"], "_slot_types": ["uint8[]"]}
    methods = {"__init__": __init__, "serialize": serialize, "deserialize": deserialize}
    return type("Raw", (rospy.Message,), dict(names, **slots, **methods))


def leave() -> None:
    """End, out of the graph if a node is in it."""
    rospy = sys.modules.get("rospy")
    if rospy is not None:
        rospy.signal_shutdown("nobody asks any more")
    os._exit(0)


def serve(wire: Wire) -> None:
    """Answer until the socket closes."""
    objects, node = Objects(), Node(wire)
    while True:
        ask, body = wire.read()
        if "topic" in ask:
            node.publish(ask["topic"], body)
            continue
        value: Any = None
        try:
            if ask["do"] == "open":
                node.open(ask)
            elif ask["do"] == "matched":
                value = node.matched(ask["of"])
            else:
                value = objects.do(ask)
        except Exception as error:  # of a module that may raise anything: the asker's to judge
            text = " ".join(str(error).split())[:300]
            wire.write({"n": ask["n"], "error": type(error).__name__, "text": text})
            continue
        wire.write({"n": ask["n"], "value": value})


def main() -> None:
    """Serve the socket of the command line."""
    sys.path.extend(sys.argv[2:])
    wire = Wire(int(sys.argv[1]))
    threading.Thread(target=wire.beat, daemon=True).start()
    serve(wire)


if __name__ == "__main__":
    main()
