#!/usr/bin/env python3
"""Mutates the text files that programs read: scene files, settings files, view paths and camera_info. A program that
reads a mutated file must end with 0, 1 or 2 within seconds, and print a readable message.

  tests/attack/hostile_files.py --files 60               as the test does
  tests/attack/hostile_files.py --files 700 --seed 7     as ./run soak does"""
import argparse
import pathlib
import random
import subprocess
import sys

import programs

LONGEST_SENTENCE, RUNS_S, WITHIN_S, MOST_MB = 2500, 2, 30, 700

SCENE = (programs.ROOT / "data/recordings/scene.toml").read_bytes()
SETTINGS = (b'source = "nowhere.oni"\nname = "left"\nlisten = "127.0.0.1:0"\ndepth-kbps = 4000\n'
            b'range = "0.4:5"\nloop = true\n')
PATH = (programs.ROOT / "data/recordings/demo.path").read_bytes()
CAMERA_INFO = b"""image_width: 640
image_height: 480
camera_name: left
camera_matrix:
  rows: 3
  cols: 3
  data: [585.0, 0.0, 320.0, 0.0, 585.0, 240.0, 0.0, 0.0, 1.0]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0.1, -0.2, 0.0, 0.0, 0.0]
"""
# What has broken programs before: nesting, sizes, characters.
BOMBS = (b"[" + b"a." * 60_000 + b"a]\n", b"a." * 60_000 + b"a = 1\n", b"a = " + b"[" * 60_000 + b"\n",
         b"a = " + b"{a=" * 60_000 + b"\n", b"k" * 5_000_000 + b" = 1\n", b"name = \"" + b"n" * 5_000_000 + b"\"\n",
         b"\xff\xfe\x00\x00" * 1000, b"\0" * 100_000, b"a: " + b"[" * 60_000, b"- " * 60_000, b"{" * 60_000,
         b"a: &a [1]\nb: &b [*a,*a,*a,*a,*a,*a,*a,*a]\nc: &c [*b,*b,*b,*b,*b,*b,*b,*b]\n" * 3,
         b"x = 1\n" * 300_000, b"\xef\xbb\xbf" + SCENE, b"")


def commands(bin_folder, folder):
    """Yields name, original file, and a command that reads FILE."""
    server = [bin_folder / "capture_server", "--listen", "127.0.0.1:0"]
    missing = ["--source", folder / "nowhere.oni"]
    return (("scene", SCENE, lambda file: [*server, *missing, "--name", "camera0", "--scene", file]),
            ("scene source", SCENE, lambda file: [bin_folder / "capture_server", "--name", "camera7", "--scene", file]),
            ("settings", SETTINGS, lambda file: [bin_folder / "capture_server", "--config", file]),
            ("viewer's scene", SCENE, lambda file: [bin_folder / "render_client", "--headless", "--scene", file,
                                                    "--view", "path:nowhere"]),
            ("path", PATH, lambda file: [bin_folder / "render_client", "--headless", "--connect", "nowhere", "--view",
                                         f"path:{file}"]),
            ("camera_info", CAMERA_INFO, lambda file: [bin_folder / "calibrate", "intrinsics", "--camera-info", file,
                                                       "--scene", folder / "scene.toml",
                                                       "--scene-out", folder / "out.toml"]))


def mutate(original, dice):
    data = bytearray(original)
    for _ in range(dice.choice((1, 2, 8))):
        kind = dice.randrange(7)
        at = dice.randrange(len(data) + 1)
        end = min(len(data), at + dice.choice((1, 5, 40)))
        if kind == 0 and data:
            data[min(at, len(data) - 1)] = dice.randrange(256)
        elif kind == 1:
            del data[at:end]
        elif kind == 2:
            data[at:at] = data[at:end] * dice.choice((1, 3, 300))
        elif kind == 3:
            data[at:at] = dice.choice((b"[", b"]", b"{", b"}", b"\"", b"'''", b"\"\"\"", b".", b"=", b"\n",
                                       b"#", b"\\", b"\r", b"\0"))
        elif kind == 4:
            data[at:at] = dice.choice((b"nan", b"inf", b"-1", b"1e999", b"0x7fffffffffffffff",
                                       b"99999999999999999999", b"true"))
        elif kind == 5:
            data[at:at] = dice.choice(BOMBS)[:dice.choice((100, 10_000, 200_000))]
        else:
            del data[at:]
    return bytes(data)


def fault_of(command, goes_on, most_mb):
    """Returns what is wrong with the end of a program, or None. `goes_on` is true if it runs until it is stopped."""
    limit = f"ulimit -v {most_mb * 1024}; " if most_mb else ""
    shell = ["bash", "-c", limit + 'exec "$@"', "bash", *map(str, command)]
    with subprocess.Popen(shell, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as process:
        try:
            said, _ = process.communicate(timeout=RUNS_S if goes_on else WITHIN_S)
        except subprocess.TimeoutExpired:
            process.terminate() if goes_on else process.kill()
            try:
                process.communicate(timeout=WITHIN_S)
            except subprocess.TimeoutExpired:
                process.kill()
            return None if goes_on and process.returncode == 0 else "has not ended"
    longest = max(map(len, said.splitlines()), default=0)
    if process.returncode not in (0, 1, 2):
        return f"exit code {process.returncode}: {said[-300:]!r}"
    if process.returncode and not said.strip():
        return "says nothing"
    return f"a line of {longest} bytes" if longest > LONGEST_SENTENCE else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, default=programs.ROOT / "build/release/bin")
    parser.add_argument("--files", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--unlimited", action="store_true", help="no limit of memory: sanitizers need all of it")
    options = parser.parse_args()
    dice, faults, tried = random.Random(options.seed), [], 0
    with programs.Room(options.bin) as room:
        (room.folder / "scene.toml").write_bytes(SCENE)
        file = room.folder / "file"
        readers = commands(options.bin, room.folder)
        inputs = [(reader, bomb) for bomb in BOMBS for reader in readers]
        dice.shuffle(inputs)
        inputs = inputs[:max(options.files // 2, 1)]
        while len(inputs) < options.files:
            reader = dice.choice(readers)
            inputs.append((reader, mutate(reader[1], dice)))
        for (name, _, command), data in inputs:
            file.write_bytes(data)
            tried += 1
            # A viewer maps gigabytes of address space for its workers.
            fault = fault_of(command(file), name == "path",
                             0 if options.unlimited or command(file)[0].name == "render_client" else MOST_MB)
            if fault:
                kept = pathlib.Path(f"hostile_file_{options.seed}_{tried}")
                kept.write_bytes(data)
                faults.append(f"{name}, {kept}: {fault}")
    print("\n".join(faults))
    print(f"{tried} files: {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
