#!/usr/bin/env python3
"""Another computer at the daemon's doors with TLS, once with each role: the page's door (log-in by a token, calls as a
browser makes them), clients/python/driftwise.py as a controller, and the text line. Prints one JSON object: what was
allowed, and what was refused with its sentence.

    across_roles.py CLIENT_FOLDER CERTIFICATE_FOLDER GRPC HTTPS LINE

CERTIFICATE_FOLDER holds authority.pem, and for each role ROLE-1.pem, ROLE-1.key and ROLE.token.
"""

import http.client
import json
import os
import socket
import ssl
import sys
import urllib.parse

sys.path.insert(0, sys.argv[1])
import driftwise  # noqa: E402

FOLDER, GRPC, HTTPS, LINE = sys.argv[2:6]
ROLES = ["viewer", "controller", "operator", "engineer", "admin"]
CALLS = [("CellService/GetStatus", "viewer"), ("CellService/StopAll", "viewer"), ("TargetService/ComputeTarget", "controller"),
         ("DataService/CreateNote", "operator"), ("ModelService/PromoteModel", "engineer"), ("AccessService/ListTokens", "admin")]
allowed, refused = [], []


def path(name):
    return os.path.join(FOLDER, name)


def tls(role=None):
    context = ssl.create_default_context(cafile=path("authority.pem"))
    if role:
        context.load_cert_chain(path(role + "-1.pem"), path(role + "-1.key"))
    return context


class Page:
    """A browser's part: one connection after the other, a cookie, and calls as gRPC-Web."""

    def __init__(self):
        self.cookie = None

    def ask(self, method, where, body=b"", **headers):
        connection = http.client.HTTPSConnection(HTTPS, context=tls(), timeout=30)
        headers = {name.replace("_", "-"): value for name, value in headers.items()}
        headers["Origin"] = "https://" + HTTPS
        if self.cookie:
            headers["Cookie"] = self.cookie
        connection.request(method, where, body, headers)
        answer = connection.getresponse()
        content = answer.read()
        connection.close()
        return answer, content

    def log_in(self, token):
        answer, content = self.ask("POST", "/session", json.dumps({"token": token}).encode(), Content_Type="application/json")
        assert answer.status == 200, (answer.status, content)
        set_cookie = answer.getheader("Set-Cookie")
        assert "HttpOnly" in set_cookie and "Secure" in set_cookie and "SameSite=Strict" in set_cookie, set_cookie
        self.cookie = set_cookie.split(";")[0]
        return json.loads(content)

    def call(self, method):
        """gRPC status and message of a call with an empty request."""
        answer, content = self.ask("POST", "/driftwise.v1." + method, b"\0\0\0\0\0",
                                   Content_Type="application/grpc-web+proto")
        text = "".join(f"{name.lower()}:{value}\r\n" for name, value in answer.getheaders())
        while content:
            size = int.from_bytes(content[1:5], "big")
            if content[0] & 0x80:
                text += content[5 : 5 + size].decode()
            content = content[5 + size :]
        fields = dict(line.split(":", 1) for line in text.split("\r\n") if ":" in line)
        return int(fields["grpc-status"]), urllib.parse.unquote(fields.get("grpc-message", ""))


def note(role, door, act, sentence):
    (refused if sentence else allowed).append({"role": role, "door": door, "act": act, "sentence": sentence})


def page(role):
    browser = Page()
    status, _ = browser.call("CellService/GetStatus")
    assert status == 16, "nobody is let in before the log-in"
    with open(path(role + ".token"), encoding="ascii") as file:
        entered = browser.log_in(file.read().strip())
    assert entered["role"] == role, entered
    for method, needed in CALLS:
        status, message = browser.call(method)
        assert (status == 7) == (ROLES.index(role) < ROLES.index(needed)), (role, method, status, message)
        note(role, "page", method.split("/")[1], message if status == 7 else "")


def controller(role):
    with driftwise.Cell(GRPC, ca=path("authority.pem"), cert=path(role + "-1.pem"), key=path(role + "-1.key")) as cell:
        assert cell.who_am_i().role == role
        assert cell.stop_all(20) is not None, "who may look may stop"
        note(role, "python", "StopAll", "")
        try:
            assert "q1_mm" in cell.target(x_mm=1.5, timeout_s=20).q_mm
            note(role, "python", "ComputeTarget", "")
        except driftwise.DriftwiseError as error:
            assert error.reason == "NEEDS_ROLE", (role, error.reason, error)
            note(role, "python", "ComputeTarget", str(error))


def line(role):
    host, port = LINE.rsplit(":", 1)
    with socket.create_connection((host, int(port)), 30) as plain:
        with tls(role).wrap_socket(plain, server_hostname=host) as connection:
            connection.sendall(b"TARGET x_mm=1.5\n")
            answer = connection.makefile("r", encoding="utf-8").readline()
    assert answer.startswith("OK q1_mm=") or answer.startswith("ERR NEEDS_ROLE"), (role, answer)
    note(role, "line", "ask for targets", "" if answer.startswith("OK") else answer.strip())


for one in ROLES:
    page(one)
    controller(one)
    line(one)
print(json.dumps({"allowed": allowed, "refused": refused}))
