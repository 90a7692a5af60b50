#!/usr/bin/env python3
"""Plays damaged recordings to capture_server: cut off, with flipped bytes in the header, in the streams' definitions,
in records and in payloads, with huge node ids. The server must neither crash nor hang nor use all CPU time. It must end
within two seconds with a message, or continue to play. Damage in payloads alone is no reason to refuse a file.

  tests/pipeline/damaged_recordings.py                 all 830, as docs/guide/recording.md quotes them (about 3 minutes)
  tests/pipeline/damaged_recordings.py --count 60      as the test does
  tests/pipeline/damaged_recordings.py --more --count 100 --recording FILE.oni
                                                       other kinds: all pictures of a stream damaged, records swapped,
                                                       missing or twice, one stream only,
                                                       wrong codec, type, counts, times and positions, gaps and
                                                       insertions

Prints the result of each kind of damage. The exit code is 0 if all tests pass."""
import argparse
import collections
import os
import pathlib
import random
import signal
import struct
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
RECORD_MAGIC, NEW_DATA, SEEK_TABLE, END = 0x0052494E, 0x0A, 0x0E, 0x0B
NODE_ADDED, FIRST_PROPERTY, LAST_PROPERTY = 0x0D, 0x03, 0x06
WITHIN_S, GIVE_UP_S = 2.0, 12.0


def records(data):
    """Returns (position, type, bytes of head and fields, bytes of payload) of every record."""
    at, found = 24, []
    while at + 28 <= len(data):
        magic, kind, _, fields, payload, _ = struct.unpack_from("<IIIIIQ", data, at)
        if magic != RECORD_MAGIC:
            break
        payload = payload if kind in (NEW_DATA, SEEK_TABLE) else 0
        found.append((at, kind, fields, payload))
        if kind == END:
            break
        at += fields + payload
    return found


class Damage:
    def __init__(self, whole):
        self.whole, self.random = whole, None
        self.records = records(whole)
        self.frames = [r for r in self.records if r[1] == NEW_DATA and r[3] > 100]
        self.definitions = [r for r in self.records if r[1] == NODE_ADDED or FIRST_PROPERTY <= r[1] <= LAST_PROPERTY]

    def with_bytes(self, places, at_most=6):
        data = bytearray(self.whole)
        for _ in range(self.random.randint(1, at_most)):
            begin, end = self.random.choice(places)
            data[self.random.randrange(begin, end)] = self.random.randrange(256)
        return bytes(data)

    def make(self, kind, seed):
        self.random = random.Random(seed)
        return getattr(self, kind)()

    def truncated(self):
        return self.whole[:self.random.randrange(len(self.whole))]

    def header(self):
        return self.with_bytes([(0, 24)], 3)

    def first_bytes(self):
        return self.with_bytes([(0, 2048)])

    def definition(self):
        return self.with_bytes([(at, at + fields) for at, _, fields, _ in self.definitions], 3)

    def record_head(self):
        return self.with_bytes([(at, at + fields) for at, _, fields, _ in self.records], 4)

    def frame_head(self):
        return self.with_bytes([(at, at + fields) for at, _, fields, _ in self.frames], 4)

    def tables(self):
        return self.with_bytes([(at, at + fields + payload) for at, kind, fields, payload in self.records
                                if kind == SEEK_TABLE], 20)

    def payload(self):
        return self.with_bytes([(at + fields, at + fields + payload) for at, _, fields, payload in self.frames], 20)

    def all_payloads(self):
        """Damages every picture of one stream, or of all streams."""
        data = bytearray(self.whole)
        nodes = [struct.unpack_from("<I", data, at + 8)[0] for at, _, _, _ in self.frames]
        lost = self.random.choice([{node} for node in sorted(set(nodes))] + [set(nodes)])
        byte = self.random.choice([None, 0x00, 0xE0, 0xFF])
        for node, (at, _, fields, payload) in zip(nodes, self.frames):
            if node in lost:
                data[at + fields:at + fields + payload] = (self.random.randbytes(payload) if byte is None
                                                           else bytes([byte]) * payload)
        return bytes(data)

    def anywhere(self):
        data = bytearray(self.whole)
        for _ in range(50):
            data[self.random.randrange(len(data))] ^= 1 << self.random.randrange(8)
        return bytes(data)

    def node_ids(self):
        data = bytearray(self.whole)
        huge = self.random.choice([0x7FFFFFFF, 0xFFFFFFFF, 1 << 24, 1_000_000, 33])
        struct.pack_into("<I", data, 20, huge)
        if self.random.random() < 0.5:
            at = self.random.choice(self.records)[0]
            struct.pack_into("<I", data, at + 8, huge)
        return bytes(data)

    def rebuilt(self, kept):
        return self.whole[:24] + b"".join(self.whole[at:at + fields + payload] for at, _, fields, payload in kept)

    def swapped(self):
        kept = list(self.records)
        for _ in range(self.random.randint(1, 4)):
            i, j = self.random.randrange(len(kept)), self.random.randrange(len(kept))
            kept[i], kept[j] = kept[j], kept[i]
        return self.rebuilt(kept)

    def missing(self):
        kept = list(self.records)
        for _ in range(self.random.randint(1, 4)):
            kept.pop(self.random.randrange(len(kept)))
        return self.rebuilt(kept)

    def doubled(self):
        kept = list(self.records)
        kept.insert(self.random.randrange(len(kept)), self.random.choice(kept))
        return self.rebuilt(kept)

    def one_stream(self):
        node = lambda record: struct.unpack_from("<I", self.whole, record[0] + 8)[0]
        lost = self.random.choice(sorted({node(record) for record in self.frames}))
        frames_only = self.random.random() < 0.5
        return self.rebuilt([r for r in self.records if node(r) != lost or (frames_only and r[1] != NEW_DATA)])

    def lie(self):
        """Falsifies a stream's definition: type, codec, frames, first and last time, position of the seek table."""
        data = bytearray(self.whole)
        at = self.random.choice([r for r in self.records if r[1] == NODE_ADDED])[0] + 28
        at += 4 + struct.unpack_from("<I", data, at)[0]
        offset, form = self.random.choice([(0, "<I"), (4, "<I"), (8, "<I"), (12, "<Q"), (20, "<Q"), (28, "<Q")])
        codecs = [int.from_bytes(code, "little") for code in (b"NONE", b"16zT", b"16zP", b"JPEG", b"Im8z", b"H264")]
        value = self.random.choice(codecs if offset == 4 else [0, 1, 2, 3, 5, 24, 1000, 1 << 22, len(data), 0xFFFFFFFF])
        struct.pack_into(form, data, at + offset, value)
        return bytes(data)

    def payload_size(self):
        data = bytearray(self.whole)
        at, _, _, payload = self.random.choice(self.frames)
        size = self.random.choice([0, 1, 2, 4, payload - 1, payload + 1, 2 * payload, 0x7FFFFFFF, 0xFFFFFFFF])
        struct.pack_into("<I", data, at + 16, size)
        return bytes(data)

    def filled(self):
        data = bytearray(self.whole)
        at, size = self.random.randrange(len(data)), self.random.choice([16, 512, 4096, 65536])
        size = min(size, len(data) - at)
        data[at:at + size] = self.random.choice([b"\0", b"\xFF"]) * size
        return bytes(data)

    def bytes_gone(self):
        at = self.random.randrange(len(self.whole))
        return self.whole[:at] + self.whole[at + self.random.choice([1, 4, 512, 4096]):]

    def bytes_more(self):
        at = self.random.randrange(len(self.whole))
        return self.whole[:at] + self.random.randbytes(self.random.choice([1, 4, 512, 4096])) + self.whole[at:]

    def no_recording(self):
        return self.random.choice([b"", b"NI10", self.whole[:24], self.whole[:2000], b"\x7fELF" + bytes(100),
                                   bytes(1000), self.random.randbytes(5000), b"NI10" + self.random.randbytes(3000)])


# Of 83: how many of each kind.
KINDS = {"truncated": 13, "header": 8, "first_bytes": 10, "definition": 10, "record_head": 10, "frame_head": 10,
         "tables": 3, "payload": 12, "anywhere": 4, "node_ids": 3}
# Of 20.
MORE_KINDS = {"swapped": 2, "missing": 2, "doubled": 2, "one_stream": 1, "lie": 5, "payload_size": 1, "filled": 2,
              "bytes_gone": 1, "bytes_more": 1, "no_recording": 1, "all_payloads": 2}


def play(server, path, port, sanitized):
    """Returns "played", "refused" or what is wrong, with seconds and CPU seconds."""
    begin = time.monotonic()
    patience = 20 if sanitized else 1
    # 8 GB of address space: a recording that makes the player allocate without bounds is found, not swapped. A
    # sanitizer takes more for itself.
    limit = "" if sanitized else "ulimit -v 8000000; "
    of_open_ni = f"suppressions={ROOT}/tests/lsan_suppressions.txt:print_suppressions=0"
    process = subprocess.Popen(["bash", "-c", limit + 'exec "$@"', "-", str(server), "--source", str(path),
                                "--listen", f"127.0.0.1:{port}", "--pace", "fast"],
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True,
                               env={"LSAN_OPTIONS": of_open_ni, **os.environ})
    status = usage = None
    while time.monotonic() - begin < patience * GIVE_UP_S:
        pid, status, usage = os.wait4(process.pid, os.WNOHANG)
        if pid:
            break
        status = None
        time.sleep(0.002)
    seconds = time.monotonic() - begin
    if status is None:
        os.killpg(process.pid, signal.SIGKILL)
        os.wait4(process.pid, 0)
        process.returncode = -9
        return "HUNG", seconds, 0, ""
    process.returncode = os.waitstatus_to_exitcode(status)
    words = process.stderr.read().decode(errors="replace")
    process.stderr.close()
    cpu = usage.ru_utime + usage.ru_stime
    sentences = [line for line in words.splitlines() if " info " not in line and " warn" not in line]
    if "Sanitizer" in words or "runtime error" in words:
        verdict = "REPORTED BY THE SANITIZER"
    elif process.returncode not in (0, 1):
        verdict = f"EXIT {process.returncode}"
    elif "crashed" in words:
        verdict = "CRASHED, and its parent said so"
    elif "hung" in words:
        verdict = "HUNG, and its parent said so"
    elif process.returncode == 1 and len(sentences) != 1:
        verdict = "NO SENTENCE"
    elif process.returncode == 1 and seconds > patience * WITHIN_S:
        verdict = "TOO LONG"
    elif cpu > patience * WITHIN_S:
        verdict = "SPUN"
    else:
        verdict = "played" if process.returncode == 0 else "refused"
    return verdict, seconds, cpu, words


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=830)
    parser.add_argument("--first", type=int, default=0, help="the first one's number: each is made by its own")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--port", type=int, default=7870)
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/bin")
    parser.add_argument("--recording", type=pathlib.Path, default=ROOT / "data/recordings/camera0.oni")
    parser.add_argument("--more", action="store_true", help="the other kinds")
    parser.add_argument("--sanitized", action="store_true",
                        help="the programs are built with a sanitizer: they may take more memory and twenty times "
                             "as long")
    parser.add_argument("--keep", type=pathlib.Path, help="a folder for the files that something was wrong with")
    options = parser.parse_args()

    with tempfile.TemporaryDirectory() as folder:
        short = pathlib.Path(folder) / "short.oni"
        subprocess.run([options.bin / "record", "cut", options.recording, "--to", "0.4", "--out", short], check=True,
                       stdout=subprocess.DEVNULL)
        damage = Damage(short.read_bytes())
        # Round robin in proportion, so that every count has a bit of everything.
        kinds = MORE_KINDS if options.more else KINDS
        plan = [kind for kind, count in kinds.items() for _ in range(count)]
        random.Random(options.seed).shuffle(plan)
        results = collections.defaultdict(collections.Counter)
        longest = {"played": 0.0, "refused": 0.0}
        worst_cpu = 0.0
        faults = []
        path = pathlib.Path(folder) / "damaged.oni"
        for index in range(options.first, options.first + options.count):
            kind = plan[index % len(plan)]
            data = damage.make(kind, f"{options.seed}:{index}")
            path.write_bytes(data)
            verdict, seconds, cpu, words = play(options.bin / "capture_server", path, options.port + index % 50,
                                                options.sanitized)
            if verdict in longest:
                longest[verdict] = max(longest[verdict], seconds)
            if kind in ("payload", "all_payloads") and verdict == "refused":
                verdict = "REFUSED FOR ITS PAYLOADS"
            results[kind][verdict] += 1
            worst_cpu = max(worst_cpu, cpu)
            if verdict not in ("played", "refused"):
                faults.append(f"{index} {kind}: {verdict}, {seconds:.2f} s, {cpu:.2f} s of CPU: {words.strip()[-300:]}")
                if options.keep:
                    options.keep.mkdir(parents=True, exist_ok=True)
                    (options.keep / f"{index:03}_{kind}.oni").write_bytes(data)
    for kind in kinds:
        print(f"{kind:<12} " + ", ".join(f"{n} {verdict}" for verdict, n in sorted(results[kind].items())))
    for fault in faults:
        print(fault)
    print(f"{options.count} damaged recordings: {len(faults)} faults; "
          f"the longest refusal took {longest['refused']:.2f} s, the longest playing {longest['played']:.2f} s, "
          f"the most CPU was {worst_cpu:.2f} s")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
