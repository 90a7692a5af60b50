"""One bash for a page. It keeps variables and jobs from command to command, like a reader's terminal."""
import os
import re
import selectors
import shlex
import signal
import subprocess
import time

DEFAULT_ADDRESS = "127.0.0.1:7001"
LISTENS = re.compile(r" on (\S+:\d+)/?\s*$", re.MULTILINE)


class CommandFault(Exception):
    pass


class Server:
    """A running capture_server or web_gateway."""

    def __init__(self, command, pid, log):
        self.command, self.pid, self.log = command, pid, log

    def log_text(self):
        return self.log.read_text(errors="replace") if self.log.exists() else ""

    def address(self):
        found = LISTENS.search(self.log_text())
        return found[1] if found else None


class Terminal:
    def __init__(self, folder, logs, environment):
        self.folder, self.logs = folder, logs
        self.servers, self.count = [], 0
        self.status_read, status_write = os.pipe()
        self.bash = subprocess.Popen(["bash", "--norc", "--noprofile"], stdin=subprocess.PIPE,
                                     stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=folder,
                                     env=environment, text=True, pass_fds=[status_write], start_new_session=True)
        self.status_fd = status_write
        os.close(status_write)

    def run_script(self, script, limit_s):
        """Runs a script and returns the text that it writes to the status pipe."""
        self.bash.stdin.write(script + "\n")
        self.bash.stdin.flush()
        answer, end = "", time.monotonic() + limit_s
        with selectors.DefaultSelector() as selector:
            selector.register(self.status_read, selectors.EVENT_READ)
            while not answer.endswith("\n"):
                if not selector.select(max(0.0, end - time.monotonic())):
                    raise CommandFault(f"did not end within {limit_s:.0f} s")
                piece = os.read(self.status_read, 1000)
                if not piece:
                    raise CommandFault("ended the shell")
                answer += piece.decode()
        return answer.split()[0]

    def new_log(self):
        self.count += 1
        return self.logs / f"{self.count:03}.log"

    def run(self, command, limit_s):
        """Runs a command to its end. Returns its exit code and its output."""
        log = self.new_log()
        code = self.run_script(f"{{ {command}\n}} >{shlex.quote(str(log))} 2>&1; echo $? >&{self.status_fd}", limit_s)
        if "jobs -p" in command:  # the page stops them itself
            self.servers.clear()
        return int(code), log.read_text(errors="replace")

    def serve(self, command, limit_s):
        """Starts a server and waits until it accepts viewers or ends. Returns the fault, or None."""
        listen = re.search(r"--listen[ =](\S+)", command)
        elsewhere = any(flag in command for flag in ("--scene", "--config", "--connect"))
        address = listen[1] if listen else None if elsewhere else DEFAULT_ADDRESS
        for server in [s for s in self.servers if address and s.address() == address]:
            self.stop(server)
        log = self.new_log()
        # With exec the process id is that of the server, so that this test can end it.
        pid = int(self.run_script(f"{{ exec {command}\n}} >{shlex.quote(str(log))} 2>&1 & "
                                  f"echo $! >&{self.status_fd}", 10))
        server = Server(command, pid, log)
        self.servers.append(server)
        end = time.monotonic() + limit_s
        while not server.address():
            code = self.exit_code(server)
            if code is not None:
                self.servers.remove(server)
                return None if code == 0 else f"ended with {code}: {server.log_text()[-600:]}"
            if time.monotonic() > end:
                return f"does not accept viewers within {limit_s:.0f} s: {server.log_text()[-600:]}"
            time.sleep(0.05)
        return None

    def exit_code(self, server):
        """The exit code, or None while the server runs."""
        code = self.run_script(f"if kill -0 {server.pid} 2>/dev/null; then echo runs; "
                               f"else wait {server.pid}; echo $?; fi >&{self.status_fd}", 10)
        return None if code == "runs" else int(code)

    def stop(self, server):
        """Ends a server. Raises CommandFault if its exit code is not 0."""
        self.servers.remove(server)
        code = self.exit_code(server)
        if code is None:
            os.kill(server.pid, signal.SIGTERM)
            code = int(self.run_script(f"wait {server.pid}; echo $? >&{self.status_fd}", 20))
        if code:
            raise CommandFault(f"{server.command}: ended with {code}: {server.log_text()[-600:]}")

    def stop_all(self):
        for server in list(self.servers):
            self.stop(server)

    def close(self):
        """Ends the shell and all that it started."""
        for server in self.servers:
            try:
                os.kill(server.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        try:
            os.killpg(self.bash.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        self.bash.wait()
        os.close(self.status_read)
