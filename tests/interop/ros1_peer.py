"""A ROS 1 node of genpy's own messages: prints what it gets, field by field, and sends it back under /echo.

python3 ros1_peer.py MASTER FILE     FILE: JSON, [name, type, definition] a topic. Standard output: "== name", fields.
"""

import json
import os
import sys
import threading


def main() -> None:
    """Serve until standard input closes."""
    os.environ["ROS_MASTER_URI"], os.environ["ROS_IP"] = sys.argv[1], "127.0.0.1"
    import genpy.dynamic
    import rospy

    with open(sys.argv[2], encoding="utf-8") as file:
        topics = json.load(file)
    rospy.init_node("peer", disable_signals=True, disable_rosout=True)
    lock = threading.Lock()
    for name, kind, text in topics:
        made = genpy.dynamic.generate_dynamic(kind, text)[kind]
        out = rospy.Publisher("/echo" + name, made, queue_size=10)

        def back(message, name=name, out=out):  # type: ignore[no-untyped-def]
            with lock:
                print(f"== {name}\n{message}", flush=True)
            out.publish(message)

        rospy.Subscriber(name, made, back)
    sys.stdin.read()
    rospy.signal_shutdown("the test is over")


if __name__ == "__main__":
    main()
