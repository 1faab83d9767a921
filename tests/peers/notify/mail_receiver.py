"""A mail server (aiosmtpd) that reads each mail with Python's own parser and keeps it as a line of JSON.

Prints "READY <port>". Refuses addresses that begin with "gone@" for good, and those with "later@" once, as greylisting does. With a certificate and key: STARTTLS is required, and with a user and password, AUTH as well.
"""
import email
import email.policy
import json
import socket
import ssl
import sys
import time

from aiosmtpd.controller import Controller
from aiosmtpd.smtp import AuthResult, SMTP


class Keeper:
    def __init__(self, kept):
        self.kept = kept
        self.seen = set()

    async def handle_RCPT(self, server, session, envelope, address, rcpt_options):
        if address.startswith("gone@"):
            return "550 5.1.1 no such user"
        if address.startswith("later@") and address not in self.seen:
            self.seen.add(address)
            return "450 4.2.0 greylisted, try again later"
        envelope.rcpt_tos.append(address)
        envelope.rcpt_options.extend(rcpt_options)
        return "250 OK"

    async def handle_DATA(self, server, session, envelope):
        mail = email.message_from_bytes(envelope.content, policy=email.policy.default)
        line = {"from": envelope.mail_from, "to": envelope.rcpt_tos, "subject": mail["Subject"],
                "text": mail.get_content(), "defects": [str(one) for one in mail.defects],
                "message_id": mail["Message-ID"], "date": mail["Date"], "user": str(session.auth_data or ""),
                "tls": session.ssl is not None}
        with open(self.kept, "a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
        return "250 2.0.0 kept"


class AnyPort(Controller):
    def factory(self):
        return SMTP(self.handler, **self.SMTP_kwargs)

    def _trigger_server(self):  # the library's own would call port 0
        with socket.create_connection(self.server.sockets[0].getsockname(), 5) as first:
            first.recv(100)


def main():
    options = {}
    if len(sys.argv) > 2:
        context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
        context.load_cert_chain(sys.argv[2], sys.argv[3])
        options = {"tls_context": context, "require_starttls": True, "auth_required": True,
                   "authenticator": lambda server, session, envelope, mechanism, data: AuthResult(
                       success=(data.login, data.password) == (b"robot", b"secret word"),
                       auth_data=data.login.decode())}
    controller = AnyPort(Keeper(sys.argv[1]), hostname="127.0.0.1", port=0, **options)
    controller.start()
    print("READY", controller.server.sockets[0].getsockname()[1], flush=True)
    while True:
        time.sleep(3600)


main()
