"""A cell with [access], as somebody outside meets it: the simulated cell and the daemon as processes, certificates and
tokens made by the command line, and the ways of an attacker: raw sockets, TLS, HTTP, another user, another host name."""
import http.client
import json
import os
import signal
import socket
import ssl
import subprocess
import sys
import tempfile
import time

BIN, SOURCE = sys.argv[1], sys.argv[2]
SKIPPED = 77  # ctest's SKIP_RETURN_CODE
ROLES = ["viewer", "controller", "operator", "engineer", "admin"]
passed = 0


def check(condition, sentence):
    global passed
    print(("ok: " if condition else "FAILED: ") + sentence, flush=True)
    if not condition:
        raise SystemExit(1)
    passed += 1


def until(what, holds, seconds=60):
    end = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > end:
            raise SystemExit("FAILED: in vain waited for " + what)
        time.sleep(0.05)


def run(*words, limit=120, **more):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=limit, check=False, **more)


class Cell:
    def __init__(self, access=True, name="linear-axis", speed=100, edit=None):
        self.scratch = tempfile.TemporaryDirectory(prefix="driftwise-outsider-")
        self.folder = self.scratch.name
        cell = os.path.join(SOURCE, "deploy", "cells", name)
        self.log = open(self.path("driftwised.log"), "ab")
        self.plant = subprocess.Popen(
            [BIN + "/driftwise-cellsim", "--plant", cell + "/plant.toml", "--cell", cell + "/cell.toml", "--instantiate",
             self.folder, "--speed", str(speed), "--seed", "1"], stdout=subprocess.PIPE, stderr=self.log, text=True)
        ready = self.plant.stdout.readline()
        if not ready.startswith("READY "):
            raise SystemExit("driftwise-cellsim did not start")
        self.devices = json.loads(ready[len("READY "):])
        for found, instead in edit or []:
            self.edit("cell.toml", found, instead)
        self.daemon = None
        if access:
            made = self.cli("cert", "init", "--name", "127.0.0.1")
            check(made.returncode == 0, "the command line makes an authority " + made.stderr)
            for role in ROLES:
                self.cli("cert", "client", role, "--role", role)
            with open(self.path("cell.toml"), "a", encoding="utf-8") as file:
                file.write('\n[access]\nlisten = "127.0.0.1:0"\nhttp = "127.0.0.1:0"\ntarget_line = "127.0.0.1:0"\n'
                           'certificate = "tls/server.pem"\nkey = "tls/server.key"\nauthority = "tls/authority.pem"\n'
                           'revoked = "tls/revoked.pem"\n')
        self.start()

    # Other text in a file of the cell's folder, wherever `found` is.
    def edit(self, name, found, instead):
        with open(self.path(name), encoding="utf-8") as file:
            text = file.read()
        if found not in text:
            raise SystemExit(f"FAILED: {name} has no {found!r}")
        self.write(name, text.replace(found, instead))

    def write(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        return self.path(name)

    # A line to the simulated cell: "fault break-beam laser-x"; its answer.
    def control(self, line):
        host, port = self.devices["control"].split("//")[-1].rsplit(":", 1)
        with socket.create_connection((host, int(port)), 20) as connection:
            connection.sendall(line.encode() + b"\n")
            return connection.makefile(encoding="utf-8").readline().strip()

    # Exit code and error of a command that must be refused.
    def refusal(self, *words, **more):
        done = self.cli(*words, "--json", **more)
        lines = [line for line in done.stderr.splitlines() if line.startswith("{")]
        if done.returncode == 0 or not lines:
            raise SystemExit(f"FAILED: driftwise {' '.join(words)} was not refused: {done.stdout}{done.stderr}")
        error = json.loads(lines[-1])["error"]
        return done.returncode, error["reason"], error["message"]

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def start(self):
        if os.path.exists(self.path("driftwised.json")):
            os.remove(self.path("driftwised.json"))
        self.daemon = subprocess.Popen([BIN + "/driftwised", "--cell", self.path("cell.toml")], stdout=self.log, stderr=self.log)
        until("the daemon", lambda: os.path.exists(self.path("driftwised.json")) or self.daemon.poll() is not None)
        check(self.daemon.poll() is None, "the daemon starts")
        with open(self.path("driftwised.json"), encoding="utf-8") as file:
            self.notice = json.load(file)

    def stop(self, how=signal.SIGTERM):
        self.daemon.send_signal(how)
        self.daemon.wait(60)

    def __enter__(self):
        return self

    def __exit__(self, *unused):
        if self.daemon is not None and self.daemon.poll() is None:
            self.stop()
        self.plant.send_signal(signal.SIGTERM)
        self.plant.wait(30)
        self.scratch.cleanup()

    def cli(self, *words, **more):
        return run(BIN + "/driftwise", *words, cwd=self.folder, env={**os.environ, "NO_COLOR": "1"}, **more)

    def ask(self, *words):
        done = self.cli(*words, "--json")
        if done.returncode != 0:
            raise SystemExit(f"FAILED: driftwise {' '.join(words)}: {done.stderr}")
        return json.loads(done.stdout)

    def remote(self, certificate, key, *words):
        return self.cli(*words, "--server", self.notice["grpc_tls"], "--tls-ca", "tls/authority.pem", "--tls-cert", certificate,
                        "--tls-key", key, "--timeout", "20")

    def token(self, name, role):
        return self.ask("token", "create", name, "--role", role)["text"]

    def database(self):
        return self.path(next(name for name in os.listdir(self.folder) if name.endswith((".db", ".sqlite"))))

    def sql(self, text):
        done = run("sqlite3", "-bail", self.database(), ".timeout 20000", text)
        check(done.returncode == 0, "sqlite3 writes what it is told " + done.stderr)
        return done.stdout.strip()

    def verify(self, *words):
        done = self.cli("audit", "verify", "--database", self.database(), *words)
        return done.returncode, done.stdout + done.stderr

    # The address of a door: "web", "web_tls", "target_line_tls".
    def address(self, door):
        host, port = self.notice[door].split("//")[-1].rstrip("/").rsplit(":", 1)
        return host, int(port)

    def tls(self, certificate=None, key=None, trust=True):
        context = ssl.create_default_context(cafile=self.path("tls", "authority.pem"))
        if not trust:
            context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
        if certificate:
            context.load_cert_chain(certificate, key)
        return context

    def connect(self, door, context=None, source=None):
        plain = socket.create_connection(self.address(door), 20, (source, 0) if source else None)
        return context.wrap_socket(plain, server_hostname="127.0.0.1") if context else plain

    # What a door answers to these bytes, until it closes or says nothing more for a while.
    def raw(self, door, data, context=None, source=None, pause=3):
        answer = b""
        try:
            with self.connect(door, context, source) as connection:
                connection.sendall(data)
                connection.settimeout(pause)
                while piece := connection.recv(65536):
                    answer += piece
        except (TimeoutError, socket.timeout, ConnectionError, ssl.SSLError):
            pass
        return answer

    # One HTTP request: status, headers as a list, body.
    def http(self, door, method, where, body=b"", headers=None, source=None):
        host, port = self.address(door)
        more = {"source_address": (source, 0)} if source else {}
        if door.endswith("tls"):
            connection = http.client.HTTPSConnection(host, port, context=self.tls(), timeout=60, **more)
        else:
            connection = http.client.HTTPConnection(host, port, timeout=60, **more)
        connection.request(method, where, body, headers or {})
        answer = connection.getresponse()
        content = answer.read()
        connection.close()
        return answer.status, answer.getheaders(), content

    def origin(self, door):
        return ("https" if door.endswith("tls") else "http") + "://%s:%d" % self.address(door)

    # A call as the page makes it: HTTP status, and the text of all that came.
    def call(self, door, method, headers=None, own=True, **more):
        all_headers = {"Content-Type": "application/grpc-web+proto", **({"Origin": self.origin(door)} if own else {}),
                       **(headers or {})}
        status, fields, content = self.http(door, "POST", "/driftwise.v1." + method, b"\0\0\0\0\0", all_headers, **more)
        return status, "".join(f"{name.lower()}: {value}\n" for name, value in fields) + content.decode(errors="replace")

    # The cookie of a log-in, "name=value"; None: refused.
    def log_in(self, door, proof, source=None, headers=None):
        status, fields, content = self.http(door, "POST", "/session", json.dumps(proof).encode(),
                                            {"Content-Type": "application/json", "Origin": self.origin(door), **(headers or {})},
                                            source)
        self.said = content.decode()
        cookies = [value for name, value in fields if name.lower() == "set-cookie"]
        return cookies[0].split(";")[0] if status == 200 else None


def is_in(answer):
    """A call was made: its answer has the status of gRPC 0."""
    status, text = answer
    return status == 200 and "grpc-status:0" in text.replace(" ", "")
