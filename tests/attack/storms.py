#!/usr/bin/env python3
"""Tests many connections that are reset at once, and streams of the largest picture that the format allows.

  tests/attack/storms.py resets large_pictures          as the tests do
  tests/attack/storms.py --connections 60000 resets     as ./run soak does"""
import argparse
import pathlib
import random
import threading
import time

import programs
import wire

MOST_GROWTH_KB, MOST_DESCRIPTORS = 10_000, 80
LARGEST = 4096  # pixels on an edge, docs/internals/wire_format.md


def reset_once(port, dice):
    """Opens a connection and resets it before, during or after the hello."""
    try:
        connection = wire.connect(port, timeout=1.0)
    except OSError:
        return
    try:
        hello = wire.hello()
        part = hello[:dice.choice((0, 1, 7, 8, 12, len(hello)))]
        connection.sendall(part)
        if part == hello and dice.random() < 0.2:
            connection.recv(1)
        wire.reset(connection)
    except OSError:
        connection.close()


def resets(room, checks, connections):
    """the server does not crash or leak memory and descriptors, and an honest viewer gets frames"""
    server, port = room.serve()
    with wire.Viewer(port) as honest:
        checks.expect(honest.wait_for_frames(10, 60), "an honest viewer is served")
        child = programs.child_of(server.pid)
        before, begin = programs.resident_kb(child), time.monotonic()

        def storm(seed):
            dice = random.Random(seed)
            for _ in range(connections // 4):
                reset_once(port, dice)

        threads = [threading.Thread(target=storm, args=(seed,)) for seed in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        seconds, frames = time.monotonic() - begin, len(honest.arrivals)
        checks.expect(honest.wait_for_frames(frames + 10, 60),
                      f"and after {connections} resets in {seconds:.1f} s, too")
        lost = [what for _, what in honest.events if what != "welcome"]
        checks.expect(not lost, f"the honest viewer never lost its connection: {lost[:3]}")
    checks.expect(server.is_running() and programs.child_of(server.pid) == child, "the server's child is the same")
    grown = programs.resident_kb(child) - before
    checks.expect(grown < MOST_GROWTH_KB, f"its memory grew by {grown} kB")
    limit = time.monotonic() + 60  # the server closes a connection without a hello after some seconds
    while programs.descriptors(child) > MOST_DESCRIPTORS and time.monotonic() < limit:
        time.sleep(0.1)
    checks.expect(programs.descriptors(child) <= MOST_DESCRIPTORS,
                  f"it has {programs.descriptors(child)} descriptors open")
    checks.expect(server.end() == 0, "it ends when asked")


def large_pictures(room, checks, _):
    """cameras that claim the largest picture, or a larger one, and send small frames: the other camera goes on"""
    _, honest = room.serve()
    _, bodies = wire.frames_of(honest, 12)
    for edge in (LARGEST, 2 * LARGEST, 65534):
        def behave(connection, edge=edge):
            wire.shake_hands(connection, wire.welcome(width=edge, height=edge, centre=(edge / 2, edge / 2),
                                                      parameters=(("near", 4000.0), ("far", 50000.0))))
            for body in bodies * 3:
                connection.sendall(wire.message(wire.FRAME, body))
            wire.hear_out(connection)

        with wire.Server(behave) as evil:
            client = room.view(honest, evil.port, more=["--frames", "10"])
            most = 0
            limit = time.monotonic() + 90
            while client.is_running() and time.monotonic() < limit:
                most = max(most, programs.resident_kb(client.pid))
                time.sleep(0.02)
            code = client.end()
            checks.expect(code == 0, f"{edge}x{edge}: ten views of the other camera are drawn ({code})")
            checks.expect(most < 1_500_000, f"{edge}x{edge}: at most {most} kB of memory")
            cameras = room.stats()["cameras"]
            checks.expect(len(cameras) == 2 and cameras[1]["left_out"],
                          f"{edge}x{edge}: the statistics say why the camera is left out: {cameras[1]['left_out']}")


def main():
    cases = {case.__name__: case for case in (resets, large_pictures)}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, default=programs.ROOT / "build/release/bin")
    parser.add_argument("--connections", type=int, default=2000)
    parser.add_argument("cases", nargs="*", metavar="CASE", choices=[*cases, []], help=" or ".join(cases))
    options = parser.parse_args()
    checks = programs.Checks()
    for name in options.cases or cases:
        print(f"== {name}: {cases[name].__doc__}", flush=True)
        with programs.Room(options.bin) as room:
            cases[name](room, checks, options.connections)
    checks.exit()


if __name__ == "__main__":
    main()
