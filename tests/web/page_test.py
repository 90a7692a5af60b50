#!/usr/bin/env python3
"""Opens the viewer page in headless Chromium, before a real gateway and real capture servers.

  tests/web/page_test.py TEST --build build/release

Ends with 77, which CTest reports as skipped, if the browser or its driver is missing."""
import argparse
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

from room import RECORDINGS, ROOT, Browser, Room, free_port

CODECS = ("adaptive", "quantized", "accuracy8", "accuracy10", "triangle", "direct",
          *(f"spiral{fold}{chroma}{unfiltered}" for fold in ("", "-fold") for chroma in ("", "-444")
            for unfiltered in ("", "-nofilter")))
CAMERAS = [RECORDINGS / "camera0.oni", RECORDINGS / "camera1.oni"]
MIN_PSNR_DB = 32


def depth_is_exact(build, codec, *options):
    """The page decodes each frame to the same depth as render_client's decoder."""
    with Room(build / "bin", CAMERAS[:1], ("--codec", codec, *options)) as room, Browser(320, 240) as browser:
        browser.open(room.url())
        browser.run("copresence.watchDepth()")
        native = subprocess.run([build / "tests/depth_checksums", f"127.0.0.1:{room.ports[0]}", "40"],
                                capture_output=True, text=True, timeout=200, check=True).stdout
        expected = {int(sequence): int(crc) for sequence, crc in map(str.split, native.splitlines())}
        time.sleep(2)
        decoded = {int(sequence): crc for sequence, crc in browser.run("copresence.depthChecksums()")["camera0"]}
        common = expected.keys() & decoded.keys()
        wrong = [sequence for sequence in common if expected[sequence] != decoded[sequence]]
        print(f"{codec} {' '.join(options)}: {len(common)} frames compared, {len(wrong)} differ")
        assert len(common) >= 15, f"{codec}: only {len(common)} frames to compare {browser.errors()}"
        assert not wrong, f"{codec}: depth differs in the frames {wrong[:5]}"


def every_codec(build):
    for codec in CODECS:
        depth_is_exact(build, codec)


def lossless(build):
    for codec in ("adaptive", "quantized", "accuracy8"):
        depth_is_exact(build, codec, "--depth-qp", "0")


def still_recordings(build, folder):
    """Returns recordings of one frame each, which a looping server repeats."""
    paths = [pathlib.Path(folder) / camera.name for camera in CAMERAS]
    for camera, path in zip(CAMERAS, paths):
        subprocess.run([build / "bin/record", "cut", camera, "--to", "0.03", "--out", path], check=True,
                       capture_output=True)
    return paths


def native_picture(room, eye, look, size, fov, unseen):
    """Returns the view of render_client's CPU renderer as an OpenCV image."""
    import cv2
    with tempfile.TemporaryDirectory() as folder:
        path, picture = pathlib.Path(folder) / "eye.path", pathlib.Path(folder) / "native.png"
        path.write_text("0 " + " ".join(map(str, (*eye, *look))) + "\n")
        connect = [word for port in room.ports for word in ("--connect", f"127.0.0.1:{port}")]
        subprocess.run([room.bin / "render_client", *connect, "--headless", "--renderer", "cpu", "--size", size,
                        "--fov", str(fov), "--view", f"path:{path}", "--unseen", unseen, "--frames", "20",
                        "--screenshot", picture], check=True, capture_output=True, timeout=120)
        return cv2.imread(str(picture))


def compare(page, native):
    """Fails unless both pictures show the same. Pixels that show nothing are black."""
    import numpy
    seen = (page.max(axis=2) > 0) & (native.max(axis=2) > 0)
    differ = ((page.max(axis=2) > 0) != (native.max(axis=2) > 0)).mean()
    error = ((page[seen].astype(float) - native[seen].astype(float)) ** 2).mean()
    decibels = 10 * numpy.log10(255 ** 2 / max(error, 1e-9))
    print(f"{100 * seen.mean():.1f} % seen in both, {100 * differ:.2f} % in one only, PSNR {decibels:.1f} dB")
    assert seen.mean() > 0.3, "the view shows too little"
    assert decibels >= MIN_PSNR_DB, f"PSNR {decibels:.1f} dB"
    assert differ < 0.01, f"{100 * differ:.2f} % of the pixels have another origin"


def show_eye(browser, eye, look, fov):
    browser.run(f"copresence.setView({{eye: {list(eye)}, look: {list(look)}, fovDegrees: {fov}}})")


def same_picture(build):
    """The page and render_client's CPU renderer show the same room alike from the same eye."""
    import cv2
    import numpy
    eye, look = (-0.3, -0.2, 0.4), (0.1, 0.2, 2.5)
    with tempfile.TemporaryDirectory() as folder:
        sources = still_recordings(build, folder)
        with Room(build / "bin", sources, ("--depth-qp", "0")) as room, Browser() as browser:
            browser.open(room.url())
            show_eye(browser, eye, look, 50)
            time.sleep(5)  # Until the colours are matched.
            for unseen in ("extend", "dim", "black"):
                page = cv2.imdecode(numpy.frombuffer(browser.picture(), numpy.uint8), cv2.IMREAD_COLOR)
                print(unseen, browser.run("copresence.stats()")["view"]["shares"])
                compare(page, native_picture(room, eye, look, "640x360", 50, unseen))
                browser.run("document.getElementById('unseen').click()")


def headset(build):
    """An eye of a headset sees what render_client shows from there."""
    import cv2
    import numpy
    eye, look = (-0.1, 0, 0.2), (-0.1, 0, 2)
    with tempfile.TemporaryDirectory() as folder:
        sources = still_recordings(build, folder)
        with Room(build / "bin", sources, ("--depth-qp", "0")) as room, Browser() as browser:
            browser.run_before_page((pathlib.Path(__file__).parent / "headset.js").read_text())
            browser.open(room.url())
            show_eye(browser, eye, look, 50)
            browser.run("document.getElementById('unseen').click(), document.getElementById('unseen').click()")
            browser.run("document.getElementById('headset').click()")
            time.sleep(8)  # Until the colours are matched.
            width, height = browser.run("scriptedHeadset.size")
            pixels = numpy.array(browser.run("scriptedHeadset.pixels"), numpy.uint8).reshape(height, width, 4)
            page = cv2.cvtColor(pixels[::-1], cv2.COLOR_RGBA2BGR)
            x = -0.1 - browser.run("scriptedHeadset.eyeX")
            compare(page, native_picture(room, (x, 0, 0.2), (x, 0, 2), f"{width}x{height}", 60, "black"))
            browser.wait_for("scriptedHeadset.session.end()")
            browser.picture()  # The canvas shows views again.


def looking_around(build):
    """Mouse, keys and the device's tilt move the eye, and Reset brings it back."""
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.keys import Keys
    with Room(build / "bin", CAMERAS) as room, Browser() as browser:
        browser.open(room.url())
        home = browser.run("copresence.eye()")
        canvas = browser.driver.find_element("id", "view")

        def moves(what, *actions):
            for action in actions:
                action()
            assert browser.run("copresence.eye()") != home, f"{what} does not move the eye"
            ActionChains(browser.driver).send_keys("r").perform()
            assert browser.run("copresence.eye()") == home, f"Reset does not undo {what}"

        moves("dragging", ActionChains(browser.driver).drag_and_drop_by_offset(canvas, 60, 20).perform)
        moves("an arrow key", ActionChains(browser.driver).send_keys(Keys.ARROW_LEFT).perform)
        moves("Shift and an arrow key", ActionChains(browser.driver).key_down(Keys.SHIFT).send_keys(
            Keys.ARROW_UP).key_up(Keys.SHIFT).perform)
        moves("the + key", ActionChains(browser.driver).send_keys("+").perform)
        # On a slow machine the driver's two clicks are too far apart.
        moves("a double click", lambda: browser.run(
            "document.getElementById('view').dispatchEvent(new MouseEvent('dblclick', {clientX: 420, clientY: 210}))"))

        # Only a device with a touch screen has the button.
        browser.driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True})
        browser.driver.refresh()
        browser.wait_for("copresence.ready")
        home = browser.run("copresence.eye()")
        browser.run("document.getElementById('tilt').click()")
        for gamma in (0, 5, 10, 15):
            browser.driver.execute_cdp_cmd("DeviceOrientation.setDeviceOrientationOverride",
                                           {"alpha": 0, "beta": 40, "gamma": gamma})
            time.sleep(0.2)
        assert browser.run("copresence.eye()") != home, "tilting the device does not move the eye"
        browser.run("document.getElementById('tilt').click()")
        assert browser.run("copresence.eye()") == home, "the view stays tilted"
        assert not browser.errors(), browser.errors()


def words(build):
    """The page says in words what it waits for, and recovers by itself."""
    with tempfile.TemporaryDirectory() as folder:
        token = pathlib.Path(folder) / "room.token"
        subprocess.run([build / "bin/web_gateway", "--make-token", token], check=True, capture_output=True)
        secret = token.read_text().strip()
        missing = f"127.0.0.1:{free_port()}"
        with Room(build / "bin", CAMERAS[:1], gateway_options=("--token", token), more=(missing,)) as room, \
                Browser() as browser:
            browser.open(room.url("wrong"), waits_until_ready=False)
            browser.wait_for_text("message", "token is wrong")
            browser.driver.get("about:blank")
            browser.open(room.url(secret), waits_until_ready=False)
            browser.wait_for_text("notes", missing)
            assert browser.text("message") == "", browser.text("message")
            room.servers[0].terminate()
            room.servers[0].wait()
            browser.wait_for_text("notes", "camera0")
            room.servers[0] = room.start_server(0, CAMERAS[0])
            limit = time.monotonic() + 20
            while "camera0" in browser.text("notes") and time.monotonic() < limit:
                time.sleep(0.2)
            assert "camera0" not in browser.text("notes"), browser.text("notes")


TESTS = {test.__name__: test for test in (every_codec, lossless, same_picture, headset, looking_around, words)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("test", choices=TESTS)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    options = parser.parse_args()
    try:
        import cv2  # noqa: F401
        import selenium  # noqa: F401
    except ImportError as error:
        print(f"skipped: {error}; ./run test installs it")
        return 77
    if not shutil.which("chromedriver"):
        print("skipped: no chromedriver; ./run test installs it")
        return 77
    TESTS[options.test](options.build.resolve())
    return 0


if __name__ == "__main__":
    sys.exit(main())
