"""Capture servers, the web gateway and a headless browser for the tests of the page. Has no command line."""
import base64
import contextlib
import pathlib
import signal
import socket
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
RECORDINGS = ROOT / "data/recordings"


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def wait_for_port(port, process, within=20):
    limit = time.monotonic() + within
    while time.monotonic() < limit:
        if process.poll() is not None:
            raise RuntimeError(f"{process.args[0]} has ended with {process.returncode}")
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), 1):
            return
        time.sleep(0.05)
    raise RuntimeError(f"{process.args[0]} does not listen on port {port} after {within} s")


class Room:
    """Capture servers for `sources`, and a gateway that connects to them and to `more` addresses."""

    def __init__(self, bin_folder, sources, server_options=(), gateway_options=("--open",), more=()):
        self.bin = pathlib.Path(bin_folder)
        self.server_options = server_options
        self.ports = [free_port() for _ in sources]
        self.servers = [self.start_server(index, source) for index, source in enumerate(sources)]
        self.gateway_port = free_port()
        addresses = [f"127.0.0.1:{port}" for port in self.ports] + list(more)
        connect = [word for address in addresses for word in ("--connect", address)]
        self.gateway = subprocess.Popen([self.bin / "web_gateway", *connect, "--listen",
                                         f"127.0.0.1:{self.gateway_port}", *gateway_options],
                                        stderr=subprocess.DEVNULL)
        for port, server in zip(self.ports, self.servers):
            wait_for_port(port, server)
        wait_for_port(self.gateway_port, self.gateway)

    def start_server(self, index, source):
        return subprocess.Popen([self.bin / "capture_server", "--source", source, "--name", f"camera{index}",
                                 "--listen", f"127.0.0.1:{self.ports[index]}", "--scene", RECORDINGS / "scene.toml",
                                 "--loop", *self.server_options], stderr=subprocess.DEVNULL)

    def url(self, token=""):
        return f"http://127.0.0.1:{self.gateway_port}/" + (f"#token={token}" if token else "")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        processes = [self.gateway, *self.servers]
        for process in processes:
            process.send_signal(signal.SIGTERM)
        for process in processes:
            try:
                process.wait(5)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


class Browser:
    """Headless Chromium with a page of `width` x `height` pixels."""

    def __init__(self, width=640, height=360):
        from selenium import webdriver
        options = webdriver.ChromeOptions()
        for argument in ("--headless=new", "--no-sandbox", "--enable-unsafe-swiftshader"):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(options=options)
        self.driver.set_script_timeout(60)
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})

    def open(self, url, waits_until_ready=True):
        self.driver.get(url)
        if waits_until_ready:
            self.wait_for("copresence.ready")

    def run_before_page(self, script):
        """Runs a script in each page that is opened from now on, before its own scripts."""
        self.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": script})

    def run(self, expression):
        return self.driver.execute_script(f"return {expression}")

    def wait_for(self, promise):
        return self.driver.execute_async_script(f"const done = arguments[0]; {promise}.then(done)")

    def picture(self):
        """Returns the next view as the bytes of a PNG."""
        return base64.b64decode(self.wait_for("copresence.picture()").split(",")[1])

    def text(self, element):
        return self.run(f"document.getElementById('{element}').innerText")

    def wait_for_text(self, element, part, within=20):
        limit = time.monotonic() + within
        while time.monotonic() < limit:
            text = self.text(element)
            if part in text:
                return text
            time.sleep(0.1)
        raise AssertionError(f"#{element} says '{self.text(element)}' instead of '{part}' after {within} s")

    def errors(self):
        return [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] == "SEVERE"]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.driver.quit()
