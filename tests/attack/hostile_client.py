#!/usr/bin/env python3
"""Attacks a server with valid, mutated, truncated, repeated and random messages over many connections, and resets
some of them. The server must close these connections, must not crash or leak memory and descriptors, and must keep
serving an honest viewer.

  tests/attack/hostile_client.py --messages 400                as the test does
  tests/attack/hostile_client.py --messages 20000 --seed 7     as ./run soak does"""
import argparse
import pathlib
import random
import struct
import time

import programs
import wire

MOST_GROWTH_KB, MOST_DESCRIPTORS = 20_000, 80


def good(dice):
    return dice.choice((wire.ping(), wire.keyframe_request(), wire.frame_ack(dice.randrange(100)), wire.hello()))


def mutated(dice):
    """Returns an invalid message."""
    message = bytearray(good(dice))
    kind = dice.randrange(6)
    if kind == 0:
        message[dice.randrange(len(message))] = dice.randrange(256)
    elif kind == 1:
        struct.pack_into("<I", message, 0, dice.choice((0, 1, 7, 9, 1 << 16, 1 << 31, (1 << 32) - 1)))
    elif kind == 2:
        struct.pack_into("<I", message, 4, dice.choice((0, 5, 16, 17, 18, 19, 255, 1 << 31)))
    elif kind == 3:
        del message[dice.randrange(len(message)):]
    elif kind == 4:
        message += dice.randbytes(dice.choice((1, 8, 100, 5000)))
    else:
        message = bytearray(dice.randbytes(dice.choice((1, 8, 24, 3000))))
    return bytes(message)


def attack(port, dice, most):
    """Attacks over one connection. Returns the number of messages sent."""
    sent = 0
    try:
        connection = wire.connect(port, timeout=0.5)
    except OSError:
        return 0
    try:
        if dice.random() < 0.8:
            connection.sendall(wire.hello())
        for _ in range(dice.randrange(1, most + 1)):
            connection.sendall(mutated(dice) if dice.random() < 0.5 else good(dice))
            sent += 1
        if dice.random() < 0.5:
            connection.recv(1 << 16)
        if dice.random() < 0.3:
            wire.reset(connection)
    except OSError:
        pass
    finally:
        connection.close()
    return sent


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, default=programs.ROOT / "build/release/bin")
    parser.add_argument("--messages", type=int, default=400)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    checks, dice = programs.Checks(), random.Random(options.seed)
    with programs.Room(options.bin) as room:
        server, port = room.serve()
        with wire.Viewer(port) as honest:
            checks.expect(honest.wait_for_frames(10, 60), "an honest viewer is served")
            child, before = programs.child_of(server.pid), programs.resident_kb(programs.child_of(server.pid))
            sent = connections = 0
            while sent < options.messages and server.is_running():
                sent += attack(port, dice, 30)
                connections += 1
            frames = len(honest.arrivals)
            checks.expect(honest.wait_for_frames(frames + 10, 60),
                          f"{sent} messages over {connections} connections later, too")
            lost = [what for _, what in honest.events if what != "welcome"]
            checks.expect(not lost, f"the honest viewer never lost its connection: {lost[:3]}")
        checks.expect(server.is_running() and programs.child_of(server.pid) == child, "the server's child is the same")
        grown = programs.resident_kb(child) - before
        checks.expect(grown < MOST_GROWTH_KB, f"its memory grew by {grown} kB")
        limit = time.monotonic() + 60  # what never said hello is cut off after some seconds
        while programs.descriptors(child) > MOST_DESCRIPTORS and time.monotonic() < limit:
            time.sleep(0.1)
        checks.expect(programs.descriptors(child) <= MOST_DESCRIPTORS,
                      f"it has {programs.descriptors(child)} descriptors open")
        checks.expect(server.end() == 0, "it ends when asked")
    checks.exit()


if __name__ == "__main__":
    main()
