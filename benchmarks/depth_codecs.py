#!/usr/bin/env python3
"""Compares the depth codec `adaptive` with the best other codec at equal bitrates. Prints the table
in docs/internals/compression.md. The error is the RMSE of depth_bench in disparity steps.

  benchmarks/depth_codecs.py                        all available recordings, 90 frames, 1, 2 and 4 Mbit/s
  benchmarks/depth_codecs.py room.oni --frames 30   one recording
"""
import argparse
import json
import os
import pathlib
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
BENCH = ROOT / "build/release/bin/depth_bench"
REAL = pathlib.Path(os.environ.get("COPRESENCE_RECORDINGS", ROOT / "../shared/recordings"))
OWN = ROOT / "data/recordings"
OTHERS = ("quantized", "accuracy10")


def measure(recording, kbps, frames):
    """Returns the rows of depth_bench by codec and setting."""
    with tempfile.NamedTemporaryFile(suffix=".json") as file:
        subprocess.run([BENCH, recording, "--codec", ",".join(("adaptive",) + OTHERS), "--kbps", kbps,
                        "--frames", str(frames), "--json", file.name], check=True, stdout=subprocess.DEVNULL)
        return {(row["codec"], row["setting"]): row for row in json.load(file)}


def cells(rows, setting):
    """Returns the two table cells and the ratio of the errors."""
    own = rows["adaptive", setting]
    best = min((rows[codec, setting] for codec in OTHERS), key=lambda row: row["rmse_steps"])
    text = [f"{row['rmse_steps']:.2f} ({row['rmse_mm']:.1f})" for row in (own, best)]
    ratio = own["rmse_steps"] / best["rmse_steps"]
    return f" {text[0]} | {text[1]} `{best['codec']}` | {100 * (ratio - 1):+.0f} % |", ratio


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", nargs="*", type=pathlib.Path)
    parser.add_argument("--kbps", default="1000,2000,4000", help="bit rates (default %(default)s)")
    parser.add_argument("--frames", type=int, default=90, help="frames of each recording (default %(default)s)")
    arguments = parser.parse_args()
    recordings = arguments.recordings or sorted(REAL.glob("*.oni")) + sorted(OWN.glob("*.oni"))
    rates = arguments.kbps.split(",")
    print("| recording |" + "".join(f" {int(rate) / 1000:g} Mbit/s: `adaptive` | best other | difference |"
                                     for rate in rates))
    print("|---" * (1 + 3 * len(rates)) + "|")
    worst = 0
    for recording in recordings:
        rows = measure(recording, arguments.kbps, arguments.frames)
        line = f"| `{recording.stem}` |"
        for rate in rates:
            text, ratio = cells(rows, f"kbps={rate}")
            line += text
            worst = max(worst, ratio)
        print(line, flush=True)
    print(f"\nlargest difference: {100 * (worst - 1):+.1f} %")


if __name__ == "__main__":
    main()
