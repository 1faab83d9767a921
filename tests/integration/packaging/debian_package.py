#!/usr/bin/python3
"""The Debian package holds what a person needs, its programs run from where they are put, and systemd accepts its unit.

Usage: debian_package.py BUILD_FOLDER
Exit code 77: cpack or dpkg-deb is not there (a skipped test).
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77
SOURCE = os.path.abspath(os.path.join(os.path.dirname(__file__), "../../.."))


def check(condition, sentence):
    print(("ok: " if condition else "FAILED: ") + sentence)
    if not condition:
        raise SystemExit(1)


def said(command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        print(done.stdout)
    check(done.returncode == 0, " ".join(command[:3]))
    return done.stdout


def main():
    build = sys.argv[1]
    if not all(shutil.which(tool) for tool in ("cpack", "dpkg-deb", "dpkg-shlibdeps")):
        print("skipped: cpack, dpkg-deb or dpkg-shlibdeps is missing")
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        said(["cpack", "--config", build + "/CPackConfig.cmake", "-B", folder])
        packages = [name for name in os.listdir(folder) if name.endswith(".deb")]
        check(len(packages) == 1, "one package: %s" % packages)
        package = os.path.join(folder, packages[0])
        fields = said(["dpkg-deb", "--field", package, "Package", "Depends"])
        check("libgrpc++" in fields and "libsqlite3-0" in fields, "it depends on what it is linked with: " + fields.strip())
        tree = os.path.join(folder, "tree")
        said(["dpkg-deb", "--extract", package, tree])
        prefix = next(os.path.join(root[:-len("/bin")]) for root, _, files in os.walk(tree) if "driftwised" in files)
        for path in ("bin/driftwise", "bin/driftwise-cellsim", "lib/systemd/system/driftwised@.service",
                     "lib/sysusers.d/driftwise.conf", "share/driftwise/systemd/serial.conf", "share/driftwise/monitoring/rules.yml", "share/man/man1/driftwise-run.1",
                     "share/bash-completion/completions/driftwise", "share/zsh/site-functions/_driftwise",
                     "share/fish/vendor_completions.d/driftwise.fish", "share/driftwise/cells/linear-axis/cell.toml"):
            check(os.path.exists(os.path.join(prefix, path)), "holds " + path)
        if os.path.exists(os.path.join(SOURCE, "clients/web/dist/index.html")):  # without Node there is none
            check(os.path.exists(os.path.join(prefix, "share/driftwise/web/index.html")), "holds the page")
        check(not os.path.exists(os.path.join(prefix, "include")), "holds no headers: those are for developers")
        check(re.match(r"\d+\.\d+\.\d+", said([prefix + "/bin/driftwise", "--version"])), "the command line runs")
        if shutil.which("systemd-analyze"):
            # verify looks for the program where the unit names it: here that is inside the extracted tree.
            unit = os.path.join(folder, "driftwised@.service")
            with open(prefix + "/lib/systemd/system/driftwised@.service") as file:
                text = re.sub(r"^ExecStart=\S+", "ExecStart=%s/bin/driftwised" % prefix, file.read(), flags=re.M)
            with open(unit, "w") as file:
                file.write(text)
            verified = subprocess.run(["systemd-analyze", "verify", "--man=no", unit], capture_output=True, text=True)
            words = [line for line in verified.stderr.splitlines() if "driftwised@" in line]
            check(not words, "systemd accepts the unit: %s" % words)
            with open(prefix + "/share/driftwise/systemd/serial.conf") as file:
                names = set(re.findall(r"^DeviceAllow=char-(\S+)", file.read(), flags=re.M))
            check(not names & {"ttyUSB", "ttyACM"} and {"188", "166"} <= names,
                  "adapters that are plugged in later are allowed by number: %s" % sorted(names))
            for what, dropin, tenths in (("network-only", None, 15), ("serial lines", "serial.conf", 18)):
                if dropin:
                    os.mkdir(unit + ".d")
                    shutil.copy(prefix + "/share/driftwise/systemd/" + dropin, unit + ".d")
                judged = subprocess.run(["systemd-analyze", "security", "--offline=true", "--threshold=%d" % tenths, unit],
                                        capture_output=True, text=True)
                check(judged.returncode == 0, "exposure, %s: %s, at most %.1f"
                      % (what, (judged.stdout.strip().splitlines() or ["?"])[-1], tenths / 10))
    return 0


if __name__ == "__main__":
    sys.exit(main())
