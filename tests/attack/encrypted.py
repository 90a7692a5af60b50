"""Connections that are encrypted with a room's key, by the program openssl: Python's ssl has no pre-shared keys before
version 3.13. So these tests also show that another TLS program can talk to a server.

Test programs import this module; it has no command line."""
import os
import re
import select
import socket
import subprocess

OPENSSL = ["openssl", "s_client", "-tls1_3", "-ciphersuites", "TLS_AES_128_GCM_SHA256", "-groups", "X25519", "-quiet",
           "-psk_identity", "copresence"]
ANOTHER_KEY = 32 * "5a"


def digits_of(key_file):
    """Returns the hexadecimal digits in a key file."""
    return re.search(r"^[0-9a-f]{64}$", key_file.read_text(), re.MULTILINE).group()


class Connection:
    """Has the methods of a socket that wire.Viewer uses. `source` is the local address."""

    def __init__(self, port, digits, source=None, timeout=3.0):
        bound = ["-bind", source] if source else []
        self._timeout = timeout
        self._process = subprocess.Popen([*OPENSSL, *bound, "-psk", digits, "-connect", f"127.0.0.1:{port}"],
                                         stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)

    def settimeout(self, seconds):
        self._timeout = seconds

    def sendall(self, data):
        self._process.stdin.write(data)
        self._process.stdin.flush()

    def recv(self, count):
        output = self._process.stdout.fileno()
        if not select.select([output], [], [], self._timeout)[0]:
            raise TimeoutError("nothing came")
        return os.read(output, count)

    def close(self):
        self._process.kill()
        self._process.communicate()


def client_hello(digits):
    """Returns the bytes with which a client with this key begins."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        connection = Connection(listener.getsockname()[1], digits)
        try:
            accepted, _ = listener.accept()
            with accepted:
                hello = accepted.recv(4096)
                while len(hello) < 5 or len(hello) < 5 + int.from_bytes(hello[3:5], "big"):
                    hello += accepted.recv(4096)
                return hello
        finally:
            connection.close()
