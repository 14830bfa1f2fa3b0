"""Reads an MCAP recording with the packages of its makers, and compares event by event.

    recording.py FOLDER     FOLDER/{reference.npy, a.mcap}
"""

import pathlib
import re
import sys

import numpy as np
from mcap_ros2.reader import read_ros2_messages


def micros(time):
    return time.sec * 1_000_000 + time.nanosec // 1000


def main(folder):
    reference = np.load(folder / "reference.npy")
    found, pictures = {}, {}
    for message in read_ros2_messages(str(folder / "a.mcap")):
        ros, topic = message.ros_msg, message.channel.topic
        height, width = ros.height, ros.width
        assert message.log_time_ns == micros(ros.header.stamp) * 1000
        if topic.startswith("/events/"):
            rows = [(micros(e.ts), e.x, e.y, int(e.polarity)) for e in ros.events]
            found.setdefault(topic, []).extend(rows)
            assert all(t <= micros(ros.header.stamp) for t, *_ in rows)
            last = rows
        else:
            assert (ros.encoding, ros.step) == ("rgb8", 3 * width)
            pixels = np.frombuffer(bytes(ros.data), np.uint8).reshape(height, width, 3)
            # A pixel is coloured where the message before has an event.
            spoke = np.zeros((height, width), bool)
            for _, x, y, _ in last:
                spoke[y, x] = True
            empty = pixels[~spoke]
            assert len(empty) == 0 or (empty == empty[0]).all(), topic
            assert (pixels[spoke] != empty[:1]).any(axis=1).all(), topic
            pictures[topic] = pictures.get(topic, 0) + 1
    assert sorted(found) == ["/events/kind0_centre_on", "/events/kind1_edges"], sorted(found)
    assert all(re.fullmatch(r"(/[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*)+", topic) for topic in found)
    for kind, topic in enumerate(sorted(found)):
        own = reference[reference["channel"] == kind]
        wanted = [(int(e["t"]), int(e["x"]), int(e["y"]), int(e["p"])) for e in own]
        assert found[topic] == wanted, topic
        print("agrees", topic, len(wanted), "events", flush=True)
    assert set(pictures.values()) == {max(pictures.values())} and len(pictures) == 2


main(pathlib.Path(sys.argv[1]))
