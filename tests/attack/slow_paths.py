#!/usr/bin/env python3
"""Tests network paths that are slow, or become worse while a viewer watches:
tests/attack/slow_paths.py [--bin FOLDER] [CASE ...]

A simulation without a clock has the exact figures (tests/common/wire/flow_control/flow_control_test.cpp). The limits
here are wide enough for a busy machine."""
import time

import programs
import proxy
import wire


def measure(viewer, seconds):
    begin = time.monotonic()
    time.sleep(seconds)
    end = time.monotonic()
    return viewer.rate(begin, end), viewer.delay(begin, end)


def path_grows_longer(room, checks):
    """the delay rises from 5 to 90 ms each way, while a second viewer on a short path keeps the encoder busy"""
    _, port = room.serve()
    with proxy.Proxy(port, delay=5) as network, wire.Viewer(port) as near, wire.Viewer(network.port) as far:
        checks.expect(far.wait_for_frames(10, 60) and near.wait_for_frames(10, 60), "both see the stream")
        network.set(delay=90)
        time.sleep(4)
        begin = time.monotonic()
        rate, _ = measure(far, 6)
        beside = near.rate(begin, time.monotonic())
        checks.expect(rate > 0.7 * beside, f"from 4 s on: {rate:.1f} frames a second, {beside:.1f} on the short path")


def path_gets_narrower(room, checks):
    """the rate falls to 4 Mbit/s during a session, beside a fast viewer"""
    _, port = room.serve()
    with proxy.Proxy(port) as network, wire.Viewer(port) as fast, wire.Viewer(network.port) as slow:
        checks.expect(slow.wait_for_frames(10, 60), "it sees the stream")
        network.set(rate=4e6)
        time.sleep(3)
        begin = time.monotonic()
        rate, delay = measure(slow, 8)
        beside = fast.rate(begin, time.monotonic())
        keyframes = sum(1 for a in fast.between(begin, time.monotonic()) if a.keyframe) / (time.monotonic() - begin)
        checks.expect(rate > min(4, 0.7 * beside), f"{rate:.1f} frames a second, {beside:.1f} on the fast path")
        checks.expect(delay < 1.0, f"median delay {delay:.2f} s")
        checks.expect(keyframes < 1.0, f"{keyframes:.2f} keyframes a second")


def joining_over_a_narrow_path(room, checks):
    """a single viewer connects at 2 and at 0.5 Mbit/s"""
    for rate, most_delay in ((2e6, 0.8), (0.5e6, 1.6)):
        _, port = room.serve()
        with proxy.Proxy(port, rate=rate) as network, wire.Viewer(network.port) as viewer:
            checks.expect(viewer.wait_for_frames(3, 60), f"{rate / 1e6} Mbit/s: frames come")
            time.sleep(3)
            came, delay = measure(viewer, 6)
            checks.expect(delay < most_delay,
                          f"{rate / 1e6} Mbit/s: {came:.1f} frames a second, median delay {delay:.2f} s")


def crawling_path(room, checks):
    """render_client over 100 kbit/s gets frames on one connection"""
    _, port = room.serve()
    with proxy.Proxy(port, rate=100e3) as network:
        client = room.view(network.port)
        time.sleep(22)
        checks.expect(client.end() == 0, "it ends with 0")
    camera = room.stats()["cameras"][0]
    checks.expect(camera["frames_received"] >= 2, f"{camera['frames_received']} frames received")
    checks.expect("silent" not in client.said(), "without giving up its connection")


def bytes_without_end(room, checks):
    """a server that sends a frame byte by byte loses its client"""
    lost = []

    def behave(connection):
        wire.shake_hands(connection, wire.welcome(parameters=(("near", 4000), ("far", 50000))))
        connection.sendall(wire.message(wire.FRAME, bytes(100))[:8])
        begin = time.monotonic()
        try:
            while time.monotonic() - begin < 30:
                connection.sendall(b"\0")
                time.sleep(0.5)
        finally:
            lost.append(time.monotonic() - begin)

    with wire.Server(behave) as server:
        client = room.view(server.port)
        client.says("too slow", within=25)
        checks.expect("too slow" in client.said(), f"the client says why it gave up: {client.said()[-300:]}")
        client.end()
        limit = time.monotonic() + 5
        while not lost and time.monotonic() < limit:
            time.sleep(0.1)
        checks.expect(bool(lost) and lost[0] < 25, f"after {lost[0] if lost else 0:.0f} s")


if __name__ == "__main__":
    programs.run([path_grows_longer, path_gets_narrower, joining_over_a_narrow_path, crawling_path, bytes_without_end],
                 __doc__)
