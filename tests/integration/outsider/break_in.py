#!/usr/bin/python3
"""Ways in, tried by somebody who has docs/access.md and docs/database.md: certificates, tokens, cookies, other sites, other
host names, other users of the computer, bytes that no client sends, the files. Each ends where the documents say.

Usage: break_in.py BIN SOURCE
"""
import os
import shutil
import signal
import statistics
import sys
import time

import cell as outsider
from cell import SKIPPED, Cell, check, is_in, run, until

STATUS = "CellService/GetStatus"
NOBODY = 65534


def openssl(cell, *words):
    done = run("openssl", *words, cwd=cell.path("tls"))
    check(done.returncode == 0, "openssl " + words[0] + done.stderr[:0])


def forged_certificates(cell):
    def sign(stem, subject, more, authority=None):
        with open(cell.path("tls", stem + ".cnf"), "w", encoding="ascii") as file:
            file.write(more)
        openssl(cell, "req", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-keyout",
                stem + ".key", "-out", stem + ".csr", "-subj", "/CN=" + subject)
        signer = ["-signkey", stem + ".key"] if authority is None else [
            "-CA", authority + ".pem", "-CAkey", authority + ".key", "-CAcreateserial"]
        openssl(cell, "x509", "-req", "-in", stem + ".csr", *signer, "-days", "2", "-extfile", stem + ".cnf", "-out",
                stem + ".pem")

    role = "extendedKeyUsage = clientAuth\nsubjectAltName = URI:driftwise:role/admin\n"
    sign("self", "eve", role)
    subject = run("openssl", "x509", "-in", cell.path("tls/authority.pem"), "-noout", "-subject", "-nameopt",
                  "multiline").stdout.split("=")[-1].strip()
    sign("twin", subject, "basicConstraints = critical, CA:TRUE\nkeyUsage = keyCertSign\n")
    sign("of-twin", "eve", role, "twin")
    sign("of-viewer", "eve", role, "viewer")
    with open(cell.path("tls/chain.pem"), "w", encoding="ascii") as chain:
        chain.write(open(cell.path("tls/of-viewer.pem"), encoding="ascii").read())
        chain.write(open(cell.path("tls/viewer.pem"), encoding="ascii").read())
    for stem, key, what in [("self", "self", "a role in a certificate that signed itself"),
                            ("of-twin", "of-twin", "an authority of the same name with another key"),
                            ("chain", "of-viewer", "a viewer's certificate in the part of an authority"),
                            ("server", "server", "the daemon's own certificate as a client's")]:
        done = cell.remote(f"tls/{stem}.pem", f"tls/{key}.key", "token", "list")
        check(done.returncode in (4, 5) and "dwt" not in done.stdout, what + " opens nothing at the gRPC door")
        context = cell.tls(cell.path("tls", stem + ".pem"), cell.path("tls", key + ".key"))
        check(not cell.raw("target_line_tls", b"TARGET x_mm=1\n", context).startswith(b"OK"), "nor at the text line")


def downgrade(cell):
    for door in ("web_tls", "grpc_tls", "target_line_tls"):
        address = cell.notice[door].split("//")[-1].rstrip("/")
        for version in ("-tls1", "-tls1_1"):
            done = run("openssl", "s_client", "-connect", address, version, "-cipher", "DEFAULT@SECLEVEL=0", input="")
            check("Cipher is (NONE)" in done.stdout or done.returncode != 0, f"{version[1:]} is not spoken at {door}")
        done = run("openssl", "s_client", "-connect", address, "-tls1_2", "-cipher", "NULL:aNULL@SECLEVEL=0", input="")
        check("Cipher is (NONE)" in done.stdout or done.returncode != 0, "nor TLS without encryption or identity")
    plain = cell.raw("web_tls", b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
    check(b"<html" not in plain and b"200 OK" not in plain, "plain words at the door with TLS get no page")


def cookies(cell, token):
    cookie = cell.log_in("web_tls", {"token": token})
    check(cookie and is_in(cell.call("web_tls", STATUS, {"Cookie": cookie})), "a log-in opens the door it was made at")
    name, value = cookie.split("=", 1)
    plain_name = "driftwise-%d" % cell.address("web")[1]
    for stolen in (cookie, f"{plain_name}={value}", f"{plain_name}={value}; {cookie}"):
        check(not is_in(cell.call("web", STATUS, {"Cookie": stolen})), "a cookie of one door opens no other door")
    check(not is_in(cell.call("web_tls", STATUS, {"Cookie": f"{name}=x; {name}={value}"})), "two cookies of a name are none")
    check(not is_in(cell.call("web_tls", STATUS, {"Cookie": cookie}, own=False)),
          "a cookie that some page lends, without its origin, makes no call")
    fixed = cell.log_in("web_tls", {"token": token}, headers={"Cookie": name + "=" + "A" * 43})
    check(fixed.split("=", 1)[1] != "A" * 43, "a session's cookie is never the attacker's choice")
    status, _, _ = cell.http("web_tls", "DELETE", "/session", b"", {"Cookie": fixed, "Origin": cell.origin("web_tls")})
    check(status in (200, 204) and not is_in(cell.call("web_tls", STATUS, {"Cookie": fixed})), "a cookie ends with its log-out")
    return cookie


def other_sites(cell, cookie):
    def told(headers):
        return cell.call("web_tls", "CellService/StopAll", {"Cookie": cookie, **headers}, own="Origin" not in headers)

    check(told({"Origin": "https://evil.example"})[0] == 403, "a page of another site commands nothing")
    check(told({"Origin": "null"})[0] == 403, "nor one without an origin of its own")
    check(told({"Origin": cell.origin("web_tls") + ".evil.example"})[0] == 403, "nor one whose name begins as ours")
    check(told({"Sec-Fetch-Site": "cross-site"})[0] == 403, "nor one that the browser calls foreign")
    for kind in ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data"):
        check(not is_in(told({"Content-Type": kind})), "a form of a page is no call: " + kind)
    status, _, _ = cell.http("web_tls", "POST", "/session", b'{"token": "x"}',
                             {"Content-Type": "text/plain", "Origin": cell.origin("web_tls")})
    check(status == 415, "a log-in that a form could send is refused")
    _, fields, _ = cell.http("web_tls", "OPTIONS", "/driftwise.v1." + STATUS, b"", {
        "Origin": "https://evil.example", "Access-Control-Request-Method": "POST"})
    check(not any(name.lower().startswith("access-control-allow") for name, _ in fields), "no other site is allowed to read")


def host_games(cell, cookie):
    def first_line(text):
        answer = cell.raw("web_tls", text.encode(), cell.tls(), pause=2)
        return answer.split(b"\r\n")[0].decode(errors="replace"), answer

    for host in ("evil.example", "127.0.0.1.evil.example", "localhost.evil.example:1", "[::1].evil.example", "127.0.0.1@evil"):
        line, _ = first_line(f"GET / HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n")
        check(" 421" in line or " 400" in line, f"the door is not called {host}")
    line, _ = first_line("GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n")
    check(" 400" in line, "two host names are one too many")
    line, answer = first_line("GET http://evil.example/ HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n")
    check(b"<html" not in answer, "a request for another host gets no page: " + line)
    line, _ = first_line("GET / HTTP/1.1\r\nConnection: close\r\n\r\n")
    check(" 400" in line, "a request that names no host is refused")


def smuggled(cell):
    inner = "GET /metrics HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
    begin = "POST /driftwise.v1.CellService/GetStatus HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/grpc-web+proto\r\n"
    for what, text in [
            ("a length and chunks", begin + f"Content-Length: {len(inner)}\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n{inner}"),
            ("two lengths", begin + f"Content-Length: 0\r\nContent-Length: {len(inner)}\r\n\r\n{inner}"),
            ("a list of lengths", begin + f"Content-Length: 0, {len(inner)}\r\n\r\n{inner}"),
            ("a blank before the colon", begin + f"Transfer-Encoding : chunked\r\n\r\n0\r\n\r\n{inner}"),
            ("a folded header", begin + f"X-One: a\r\n Content-Length: {len(inner)}\r\n\r\n{inner}"),
            ("a sign before the length", begin + f"Content-Length: +{len(inner)}\r\n\r\n{inner}"),
            ("a length below zero", begin + "Content-Length: -1\r\n\r\n" + inner),
            ("a lone line feed", begin.replace("\r\n", "\n") + "Content-Length: 0\n\n" + inner)]:
        answer = cell.raw("web_tls", text.encode(), cell.tls(), pause=2)
        check(b"driftwise_" not in answer and b"grpc-status: 0" not in answer, "nothing is carried inside " + what)
    until("the door", lambda: cell.http("web_tls", "GET", "/healthz")[0] == 200)


def addresses(cell, token):
    for where in (f"/?token={token}", f"/now?access_token={token}", f"/log-in?link={token}"):
        status, fields, _ = cell.http("web_tls", "GET", where)
        check(status in (200, 400, 404) and not any(name.lower() == "set-cookie" for name, _ in fields),
              "a token in an address logs nobody in")
    status, fields, content = cell.http("web_tls", "POST", f"/driftwise.v1.{STATUS}?token={token}", b"\0\0\0\0\0", {
        "Content-Type": "application/grpc-web+proto", "Origin": cell.origin("web_tls")})
    check(not is_in((status, str(fields) + content.decode(errors="replace"))), "nor is a call made by it")
    for where in ("/../tokens.json", "/assets/../../tokens.json", "/%2e%2e/tokens.json", "/..%2ftokens.json", "/assets//etc/passwd",
                  "/%00", "/assets/%5c..%5ctokens.json", "//etc/passwd"):
        answer = cell.raw("web_tls", f"GET {where} HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n".encode(), cell.tls())
        check(b"scrypt" not in answer and b"root:" not in answer, "no file beyond the page: " + where)
    check(cell.http("web_tls", "GET", "/metrics")[0] == 401, "the metrics want a name")


def open_links(cell):
    link = cell.ask("open")["link"].split("#")[1]
    check(cell.log_in("web", {"link": link.swapcase()}) is None, "a link is no link in other letters")
    cookie = cell.log_in("web", {"link": link})
    check(cookie is not None, "a link logs one browser in")
    check(cell.log_in("web", {"link": link}) is None and "used before" in cell.said, "and once: the replay is refused")
    check(cell.log_in("web_tls", {"link": link}, source="127.0.9.1") is None, "at the other door as well")
    check(cell.log_in("web", {"token": link}, source="127.0.9.2") is None, "and it is no token")
    return link, cookie


def forged_insides(cell, viewer):
    inside = {"driftwise-identity-bin": "eyJuYW1lIjoiZXZlIiwicm9sZSI6NX0=", "driftwise-peer": "unix:", "driftwise-operator": "root"}
    check(not is_in(cell.call("web_tls", STATUS, inside)), "an identity that a browser makes up is none")
    bearer = {"Authorization": "Bearer " + viewer}
    check("needs" in cell.call("web_tls", "CellService/Home", {**bearer, **inside})[1], "and adds nothing to a viewer's token")
    try:
        import grpc
    except ImportError:
        return
    credentials = grpc.ssl_channel_credentials(open(cell.path("tls/authority.pem"), "rb").read())
    with grpc.secure_channel(cell.notice["grpc_tls"], credentials) as channel:
        def status_of(method, metadata):
            try:
                channel.unary_unary("/driftwise.v1." + method)(b"", timeout=20, metadata=metadata)
                return "OK"
            except grpc.RpcError as error:
                return error.code().name
        made_up = [("driftwise-identity-bin", b"{}"), ("driftwise-peer", "inproc"), ("driftwise-operator", "root")]
        check(status_of(STATUS, made_up) == "UNAUTHENTICATED", "nor is one in gRPC's metadata")
        check(status_of("CellService/Home", made_up + [("authorization", "Bearer " + viewer)]) == "PERMISSION_DENIED",
              "a viewer who calls itself root is a viewer")
        check(status_of(STATUS, [("authorization", "Basic cm9vdDpyb290")]) == "UNAUTHENTICATED", "a password is no token")
        check(status_of(STATUS, [("authorization", "Bearer " + viewer), ("authorization", "Bearer x")]) in
              ("UNAUTHENTICATED", "OK"), "two tokens are looked at as one")
    acts = cell.ask("audit", "list", "--limit", "50")["acts"]
    homes = [act for act in acts if act.get("subject") == "Home"]
    check(len(homes) == 2 and all(act["who"] == "vera" for act in homes), "the audit has the viewer's own name, not root's")
    check(all("127.0.0.1" in act["from"] for act in homes), "and where it came from")


def other_users(cell):
    os.chmod(cell.folder, 0o755)  # so that the files' own modes are what counts
    for name in ("driftwised.token", "tokens.json", "driftwised.sock", "tls/server.key", "tls/authority.key", "tls/admin.key"):
        if os.path.exists(cell.path(name)):
            check(os.stat(cell.path(name)).st_mode & 0o077 == 0, f"{name} is its owner's alone")
    if os.geteuid() != 0 or not shutil.which("setpriv"):
        print("NOT TRIED: another user of the computer (this test is not root, or setpriv is missing)")
        return
    bare = cell.path("bare")  # the program, where another user may execute it
    shutil.copy(outsider.BIN + "/driftwise", bare)
    os.chmod(bare, 0o755)

    def as_nobody(*words):
        return run("setpriv", "--reuid", NOBODY, "--regid", NOBODY, "--clear-groups", *words, cwd="/")

    def refused(done):
        return done.returncode != 0 and '"cell_name"' not in done.stdout

    plain = cell.notice["grpc"]
    done = as_nobody(bare, "status", "--json", "--server", plain)
    check(refused(done) and "asks for a token" in done.stderr, "another user of this computer is nobody at the port on loopback")
    check(refused(as_nobody(bare, "status", "--json", "--server", "unix:" + cell.path("driftwised.sock"))), "and has no socket")
    check(refused(as_nobody(bare, "status", "--json", "--server", plain, "--token-file", cell.path("driftwised.token"))),
          "and reads no token")
    check(as_nobody("cat", cell.path("tokens.json")).returncode != 0, "nor the hashes of tokens")
    check(as_nobody("/bin/sh", "-c", f"echo x >> {cell.database()}").returncode != 0, "and writes no record")
    arguments = open(f"/proc/{cell.daemon.pid}/cmdline", "rb").read()
    check(b"dw" + b"t_" not in arguments, "no secret stands in the daemon's arguments")
    os.chmod(cell.folder, 0o700)


def token_ids(cell, viewer):
    """A wrong secret of a known id takes as long as an unknown id, and gets the same sentence."""
    known_wrong = viewer[:-4] + ("AAAA" if viewer[-4:] != "AAAA" else "BBBB")
    id_length = len(viewer.split("_")[1]) if "_" in viewer else 0
    unknown = "dwt_" + "z" * 8 + viewer[12:] if id_length > 8 else "dwt_" + "z" * len(viewer[4:])
    times, sentences = {known_wrong: [], unknown: []}, set()
    for round_ in range(12):
        for number, text in enumerate(times):
            source = f"127.0.{10 + round_}.{1 + number}"  # so that no try is slowed
            begin = time.monotonic()
            check(cell.log_in("web", {"token": text}, source=source) is None, "a wrong token opens nothing")
            times[text].append(time.monotonic() - begin)
            sentences.add(cell.said)
    check(len(sentences) == 1, "known and unknown ids get the same sentence")
    one, two = (statistics.median(values[2:]) for values in times.values())
    check(max(one, two) < 2 * min(one, two) + 0.02, f"after the same time: {1e3 * one:.1f} and {1e3 * two:.1f} ms")
    for _ in range(7):
        cell.log_in("web", {"token": "dwt_wrong"}, source="127.0.40.1")
    check(cell.log_in("web", {"token": "dwt_wrong"}, source="127.0.40.1") is None and "too many" in cell.said,
          "who tries on is slowed")


def text_line(cell, viewer):
    def ask(data, role=None):
        context = cell.tls(cell.path("tls", role + ".pem"), cell.path("tls", role + ".key")) if role else cell.tls()
        return cell.raw("target_line_tls", data, context, pause=2)

    check(not ask(b"TARGET x_mm=1\n").startswith(b"OK"), "the line answers nobody")
    check(b"OK name" not in ask(b"TOKEN dwt_x\rTOKEN " + viewer.encode() + b"\x00\n"), "a token with bytes behind it is none")
    answer = ask(b"TOKEN " + viewer.encode() + b"\nTARGET x_mm=1\n")
    check(b"NEEDS_ROLE" in answer, "a viewer gets no target there")
    check(b"NEEDS_ROLE" in ask(b"TARGET x_mm=1\n", "viewer"), "by a certificate neither")
    until("the refusal in the audit", lambda: sum(
        act["what"] == "access.refused" and act.get("subject") == "ask for targets"
        for act in cell.ask("audit", "list", "--limit", "200")["acts"]) == 2)
    check(b"OK" not in ask(b"STOP\nMOVE q1_mm=1\nHOME\n", "admin").replace(b"TOKEN", b""), "the line does nothing but targets")


def record(cell):
    head = cell.cli("audit", "head").stdout.strip()
    cell.sql("UPDATE audit SET outcome = '' WHERE what = 'access.refused'")
    check(cell.cli("audit", "verify").returncode == 1, "a refusal made to an act that was done, while the daemon works, is found")
    cell.stop()
    cell.start()
    done = cell.cli("audit", "verify")
    check(done.returncode == 1 and "audit with audit_id" in done.stdout, "and after a restart, by its row")
    cell.stop()
    path = cell.database()
    shutil.copy(path, path + ".before")
    cell.sql("PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql = replace(sql, 'outcome TEXT NOT NULL', "
             "'outcome TEXT') WHERE name = 'audit'")
    code, said = cell.verify()
    check(code == 1 and "definition of table audit" in said, "a definition that was changed is found")
    shutil.copy(path + ".before", path)
    cell.sql("DELETE FROM audit; DELETE FROM chain WHERE entry_id > 5")
    code, said = cell.verify("--head", head)
    check(code == 1, "entries and rows that were dropped at the end are found")
    shutil.copy(path + ".before", path)
    later = ("passage", "indentation", "repeated_point", "closure_coordinate", "closure", "rest", "time_note", "plan_promotion", "plan_model", "plan", "telling", "receiver", "alarm_shelf", "queue_run", "queue_result", "queue_hold", "queue_entry", "run_metadata",
             "thinned_value", "thinning", "chain", "audit")  # tables that version 6 did not have
    cell.sql("DROP TRIGGER point_once; DROP VIEW planned_point; " + "".join(f"DROP TABLE {table}; " for table in later) + "PRAGMA user_version = 6")
    cell.start()
    check(cell.cli("audit", "verify").returncode == 0, "a chain that is begun anew by an older version is whole in itself")
    check(cell.cli("audit", "verify", "--head", head).returncode == 1, "and the kept head finds it")
    cell.stop()


def log_of_writes(cell):
    """The write-ahead log: replaced by an older one, or cut."""
    path = cell.database()
    for number in range(5):
        cell.token(f"early-{number}", "viewer")
    for end in ("", "-wal"):
        shutil.copy(path + end, path + end + ".early")
    for number in range(5):
        cell.token(f"late-{number}", "viewer")
    head = cell.cli("audit", "head").stdout.strip()
    cell.stop(signal.SIGKILL)
    check(os.path.getsize(path + "-wal") > 0, "a killed daemon leaves its log")
    late = {end: open(path + end, "rb").read() for end in ("", "-wal")}

    def put(files):
        for end, data in files.items():
            with open(path + end, "wb") as file:
                file.write(data)
        for end in ("-shm",):
            if os.path.exists(path + end):
                os.remove(path + end)

    code, said = cell.verify("--head", head)
    check(code == 0, "the record with its log holds the head " + said[:100])
    early = {end: open(path + end + ".early", "rb").read() for end in ("", "-wal")}
    for what, files in [("an older log", {**late, "-wal": early["-wal"]}),
                        ("an older record with its log", early),
                        ("a log cut in half", {**late, "-wal": late["-wal"][:len(late["-wal"]) // 2]}),
                        ("an empty log", {**late, "-wal": b""}),
                        ("a log with a changed byte", {**late, "-wal": late["-wal"][:-3000] + bytes([late["-wal"][-3000] ^ 1]) +
                                                       late["-wal"][-2999:]})]:
        put(files)
        code, said = cell.verify("--head", head)
        check(code != 0 or what.startswith("a log with"), f"{what}: the kept head finds what is gone: {said.strip()[-150:]}")
    put(late)
    code, _ = cell.verify("--head", head)
    check(code == 0, "put back as it was, it holds again")


def main():
    if not shutil.which("sqlite3") or not shutil.which("openssl"):
        print("skipped: sqlite3 and openssl are needed")
        return SKIPPED
    with Cell() as cell:
        viewer = cell.token("vera", "viewer")
        forged_certificates(cell)
        downgrade(cell)
        cookie = cookies(cell, viewer)
        other_sites(cell, cookie)
        host_games(cell, cookie)
        smuggled(cell)
        addresses(cell, viewer)
        link, linked = open_links(cell)
        forged_insides(cell, viewer)
        other_users(cell)
        text_line(cell, viewer)
        token_ids(cell, viewer)
        cell.log.flush()
        log = open(cell.path("driftwised.log"), encoding="utf-8", errors="replace").read()
        secrets = [viewer, viewer[8:], link, cookie.split("=", 1)[1], linked.split("=", 1)[1],
                   open(cell.path("driftwised.token"), encoding="ascii").read().strip()]
        check(not any(secret in log for secret in secrets), "no token, link or cookie stands in the log")
        events = cell.cli("events").stdout + cell.cli("audit", "list", "--limit", "1000").stdout
        check(not any(secret in events for secret in secrets), "nor in the record")
        check(cell.daemon.poll() is None, "the daemon stands after all this")
        record(cell)
    with Cell() as cell:
        log_of_writes(cell)
    print(f"{outsider.passed} checks")
    return 0


if __name__ == "__main__":
    sys.exit(main())
