"""A receiver of webhooks: Python's own HTTP server, which keeps what it is sent.

Prints "READY <port>". Every POST is a line of the file: {"path", "authorization", "type", "body"}.
What it answers stands in the mode file: ok, 500, hang (nothing), slow (after a second).
"""
import http.server
import json
import sys
import threading
import time


def main():
    kept, mode_file = sys.argv[1], sys.argv[2]
    lock = threading.Lock()

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_POST(self):
            body = self.rfile.read(int(self.headers.get("Content-Length", "0"))).decode("utf-8")
            with open(mode_file, encoding="ascii") as file:
                mode = file.read().strip()
            with lock, open(kept, "a", encoding="utf-8") as file:
                line = {"mode": mode, "path": self.path, "authorization": self.headers.get("Authorization", ""),
                        "type": self.headers.get("Content-Type", ""), "body": body}
                file.write(json.dumps(line) + "\n")
            if mode == "hang":
                time.sleep(3600)
            if mode == "slow":
                time.sleep(1)
            try:
                self.send_response(500 if mode == "500" else 200)
                self.end_headers()
                self.wfile.write(b"kept\n")
            except ConnectionError:
                pass  # the sender was killed

        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = True
    print("READY", server.server_address[1], flush=True)
    server.serve_forever()


main()
