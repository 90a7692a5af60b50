"""One bash in a page's folder that keeps its variables and jobs from command to command, as a reader's
terminal does."""
import os
import re
import selectors
import shlex
import signal
import subprocess
import time

DEFAULT_ADDRESS = "127.0.0.1:7001"
LISTENS = re.compile(r" on (\S+:\d+)\s*$", re.MULTILINE)


class CommandFault(Exception):
    pass


class Server:
    """A capture_server that runs until it is stopped."""

    def __init__(self, command, pid, log):
        self.command, self.pid, self.log = command, pid, log

    def said(self):
        return self.log.read_text(errors="replace") if self.log.exists() else ""

    def address(self):
        found = LISTENS.search(self.said())
        return found[1] if found else None


class Terminal:
    def __init__(self, folder, logs, environment):
        self.folder, self.logs = folder, logs
        self.servers, self.count = [], 0
        self.status_read, status_write = os.pipe()
        self.bash = subprocess.Popen(["bash", "--norc", "--noprofile"], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL,
                                     stderr=subprocess.DEVNULL, cwd=folder, env=environment, text=True,
                                     pass_fds=[status_write], start_new_session=True)
        self.status_fd = status_write
        os.close(status_write)

    def ask(self, script, limit_s):
        """Runs a script and returns what it writes to the status pipe."""
        self.bash.stdin.write(script + "\n")
        self.bash.stdin.flush()
        answer, end = "", time.monotonic() + limit_s
        with selectors.DefaultSelector() as selector:
            selector.register(self.status_read, selectors.EVENT_READ)
            while not answer.endswith("\n"):
                if not selector.select(max(0.0, end - time.monotonic())):
                    raise CommandFault(f"has not ended within {limit_s:.0f} s")
                piece = os.read(self.status_read, 1000)
                if not piece:
                    raise CommandFault("has ended the shell")
                answer += piece.decode()
        return answer.split()[0]

    def new_log(self):
        self.count += 1
        return self.logs / f"{self.count:03}.log"

    def run(self, command, limit_s):
        """Runs a command to its end. Returns its exit code and what it said."""
        log = self.new_log()
        code = self.ask(f"{{ {command}\n}} >{shlex.quote(str(log))} 2>&1; echo $? >&{self.status_fd}", limit_s)
        if "jobs -p" in command:  # the page has stopped them itself
            self.servers.clear()
        return int(code), log.read_text(errors="replace")

    def serve(self, command, limit_s):
        """Starts a server and waits until it accepts viewers, or has come to its end. Returns why that failed, or None."""
        listen = re.search(r"--listen[ =](\S+)", command)
        address = listen[1] if listen else None if "--scene" in command or "--config" in command else DEFAULT_ADDRESS
        for server in [s for s in self.servers if address and s.address() == address]:
            self.stop(server)
        log = self.new_log()
        # As a process that this test can end: a job of the shell, without a shell of its own.
        pid = int(self.ask(f"{{ exec {command}\n}} >{shlex.quote(str(log))} 2>&1 & echo $! >&{self.status_fd}", 10))
        server = Server(command, pid, log)
        self.servers.append(server)
        end = time.monotonic() + limit_s
        while not server.address():
            code = self.exit_code(server)
            if code is not None:
                self.servers.remove(server)
                return None if code == 0 else f"ended with {code}: {server.said()[-600:]}"
            if time.monotonic() > end:
                return f"does not serve within {limit_s:.0f} s: {server.said()[-600:]}"
            time.sleep(0.05)
        return None

    def exit_code(self, server):
        """None while it runs."""
        code = self.ask(f"if kill -0 {server.pid} 2>/dev/null; then echo runs; else wait {server.pid}; echo $?; fi "
                        f">&{self.status_fd}", 10)
        return None if code == "runs" else int(code)

    def stop(self, server):
        """Ends a server; it must have gone on until then, or have ended well."""
        self.servers.remove(server)
        code = self.exit_code(server)
        if code is None:
            os.kill(server.pid, signal.SIGTERM)
            code = int(self.ask(f"wait {server.pid}; echo $? >&{self.status_fd}", 20))
        if code:
            raise CommandFault(f"{server.command}: ended with {code}: {server.said()[-600:]}")

    def stop_all(self):
        for server in list(self.servers):
            self.stop(server)

    def close(self):
        """Ends the shell and everything that it started."""
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
