#!/usr/bin/env python3
"""Tests render_client with a server that sends damaged frames with valid checksums. Real frames are changed and get a
new CRC-32 and sequence number. The client also shows an honest camera. The client must neither end, nor leak memory,
nor lose the honest camera.

  tests/attack/mutated_frames.py --frames 150               as the test does
  tests/attack/mutated_frames.py --frames 20000 --seed 7    as ./run soak does (about a quarter of an hour)"""
import argparse
import pathlib
import random
import struct
import threading
import zlib

import programs
import wire

UUID = bytes.fromhex("5c1e37a02f6b4d589e43c097e51d806a")
CODECS = ("adaptive", "quantized", "accuracy8", "spiral-fold", "triangle")
SLICES_AND_PARAMETERS = (1, 5, 7, 8)
WINDOW = 4
MOST_GROWTH_KB = 150_000


def nal_units(access_unit):
    """Returns NAL units from the header byte to the end, without start codes and trailing zeros."""
    parts = access_unit.split(b"\0\0\1")[1:]
    return [part.rstrip(b"\0") for part in parts]


def without_emulation_prevention(data):
    return data.replace(b"\0\0\3", b"\0\0")


def with_emulation_prevention(data):
    out, zeros = bytearray(), 0
    for byte in data:
        if zeros >= 2 and byte <= 3:
            out.append(3)
            zeros = 0
        out.append(byte)
        zeros = zeros + 1 if byte == 0 else 0
    return bytes(out)


class Frame:
    """A keyframe divided into side data and NAL units."""

    def __init__(self, body):
        self.body = body
        depth_bytes = wire.frame_head(body)["depth_bytes"]
        depth, self.color = body[wire.HEAD.size:][:depth_bytes], body[wire.HEAD.size + depth_bytes:]
        self.units, self.side_data = [], None
        for unit in nal_units(depth):
            plain = without_emulation_prevention(unit)
            if unit[0] & 31 == 6 and UUID in plain[:40]:
                self.side_data = bytearray(plain[plain.index(UUID):-1])  # without the end bit's byte
            else:
                self.units.append(bytearray(unit))
        if self.side_data is None:
            raise ValueError("no side data in the frame")

    def assemble(self, sequence):
        struct.pack_into("<QQ", self.side_data, 23, sequence, 0)
        if self.side_data:
            crc = zlib.crc32(self.side_data[20:])
            for unit in [*self.units, *nal_units(self.color)]:
                if unit and unit[0] & 31 in SLICES_AND_PARAMETERS:
                    crc = zlib.crc32(unit, crc)
            struct.pack_into("<I", self.side_data, 16, crc)
        size = len(self.side_data)
        sei = bytes([6, 5]) + b"\xff" * (size // 255) + bytes([size % 255]) + bytes(self.side_data) + b"\x80"
        depth = b"\0\0\0\1" + with_emulation_prevention(sei)
        for unit in self.units:
            depth += b"\0\0\0\1" + bytes(unit)
        head = wire.frame_body(self.body[:wire.HEAD.size], sequence=sequence, captured=sequence, depth_bytes=len(depth))
        return head + depth + self.color


def mutate(frame, dice):
    """Changes data that only the decoder can check: numbers, tables and masks of the side data, and bits of
    the pictures."""
    kind = dice.choice(("head", "sizes", "side data", "side data", "side data", "cut", "picture", "color"))
    data = frame.side_data
    if kind == "head":
        data[dice.choice((20, 21, 22, *range(39, 47), *range(47, min(143, len(data)))))] = dice.randrange(256)
    elif kind == "sizes":
        at = dice.choice((47, 143))
        if at + 4 <= len(data):
            struct.pack_into("<I", data, at, dice.choice((0, 1, 255, len(data), 1 << 16, 1 << 31, (1 << 32) - 1)))
    elif kind == "side data":
        for _ in range(dice.choice((1, 1, 3, 20))):
            data[dice.randrange(min(47, len(data) - 1), len(data))] ^= 1 << dice.randrange(8)
    elif kind == "cut":
        del data[dice.randrange(47, len(data)):]
    elif kind == "picture" and frame.units:
        unit = dice.choice(frame.units)
        for _ in range(dice.choice((1, 5))):
            unit[dice.randrange(len(unit))] ^= 1 << dice.randrange(8)
    elif frame.color:
        color = bytearray(frame.color)
        color[dice.randrange(len(color))] ^= 1 << dice.randrange(8)
        frame.color = bytes(color)
    return kind


class MutatingServer:
    """Behaviour for wire.Server: every second frame is mutated."""

    def __init__(self, streams, seed, count):
        self.streams, self.dice, self.left = streams, random.Random(seed), count
        self.lock, self.sent = threading.Condition(), {}

    def wait_until_left(self, count, within):
        with self.lock:
            return self.lock.wait_for(lambda: self.left <= count, within)

    def next_frame(self, body, sequence):
        with self.lock:
            frame = Frame(body)
            if sequence % 2 == 0 and self.left > 0:
                self.left -= 1
                kind = mutate(frame, self.dice)
                self.sent[kind] = self.sent.get(kind, 0) + 1
                self.lock.notify_all()
            return frame.assemble(sequence)

    def __call__(self, connection):
        first, body = self.dice.choice(self.streams)
        wire.shake_hands(connection, wire.message(wire.WELCOME, first))
        in_flight, sequence = 0, 0
        while sequence < 60:  # then another codec's turn
            while in_flight < WINDOW:
                sequence += 1
                connection.sendall(wire.message(wire.FRAME, self.next_frame(body, sequence)))
                in_flight += 1
            kind, _ = wire.read_message(connection)
            in_flight -= kind == wire.FRAME_ACK


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, default=programs.ROOT / "build/release/bin")
    parser.add_argument("--frames", type=int, default=150, help="mutated frames")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    checks = programs.Checks()
    with programs.Room(options.bin) as room:
        streams = []
        for codec in CODECS:
            server, port = room.serve("--codec", codec)
            first, bodies = wire.frames_of(port, 1)
            streams.append((first, bodies[0]))
            checks.expect(Frame(bodies[0]).side_data is not None, f"{codec}: the frame is taken apart")
            server.end()
        whole = MutatingServer(streams, options.seed, 0)
        _, honest_port = room.serve("--name", "honest")
        with wire.Server(whole) as server:
            viewer = room.view(server.port, more=["--frames", "3"])
            checks.expect(viewer.wait(120) == 0, "frames that were put together again without a change are shown")
        hostile = MutatingServer(streams, options.seed, options.frames)
        with wire.Server(hostile) as server:
            viewer = room.view(server.port, honest_port)
            a_quarter = hostile.wait_until_left(options.frames * 3 // 4, 60 + options.frames * 0.3)
            checks.expect(a_quarter and viewer.is_running(), "the viewer takes mutated frames")
            before = programs.resident_kb(viewer.pid) if viewer.is_running() else 0
            finished = hostile.wait_until_left(0, 60 + options.frames * 0.5)
            checks.expect(finished,
                      f"{sum(hostile.sent.values())} of {options.frames} mutated frames were taken: {hostile.sent}")
            checks.expect(viewer.is_running(), f"the viewer goes on: {viewer.said()[-500:]}")
            grown = programs.resident_kb(viewer.pid) - before if viewer.is_running() else 0
            checks.expect(grown < MOST_GROWTH_KB, f"its memory grew by {grown} kB")
            checks.expect(viewer.end() == 0, "it ends when asked")
        cameras = {camera["name"]: camera for camera in room.stats()["cameras"]}
        mutated = cameras["camera0"]
        checks.expect(mutated["drops"]["decode_error"] > 0 and mutated["frames_decoded"] > 0,
                      f"of the other frames {mutated['frames_decoded']} were decoded and "
                      f"{mutated['drops']['decode_error']} refused")
        honest = cameras["honest"]["frames_received"]
        checks.expect(honest >= 10, f"{honest} frames of the honest camera were shown meanwhile")
    checks.exit()


if __name__ == "__main__":
    main()
