"""README.md is true in what can be looked up: links, paths, commands, options, length.

Usage: readme.py DRIFTWISE SOURCE_DIR. Programs beside DRIFTWISE are asked for their --help.
"""
import pathlib
import re
import shlex
import subprocess
import sys

driftwise = pathlib.Path(sys.argv[1])
root = pathlib.Path(sys.argv[2])
text = (root / "README.md").read_text()
problems = []

lines = text.splitlines()
if len(lines) > 100:
    problems.append(f"README.md has {len(lines)} lines, at most 100")
for number, line in enumerate(lines, 1):
    if len(line) > 140:
        problems.append(f"README.md:{number}: {len(line)} characters, at most 140")


def check_links(page):
    for target in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", page.read_text()):
        if not target.startswith("http") and not (page.parent / target).exists():
            problems.append(f"{page.relative_to(root)}: link to {target}, which does not exist")


check_links(root / "README.md")
for page in sorted((root / "docs").rglob("*.md")):
    check_links(page)

for path in re.findall(r"`((?:deploy|docs|server|drivers|storage|clients|proto|tests)/[^\s`*]*)", text):
    if not (root / path).exists():
        problems.append(f"README.md names {path}, which does not exist")

helps = {}


def help_of(words):
    """The --help of `driftwise run start`, or None where there is no such command."""
    key = tuple(words)
    if key not in helps:
        program = driftwise.parent / words[0]
        done = subprocess.run([program, *words[1:], "--help"], capture_output=True, text=True, timeout=60)
        helps[key] = done.stdout if done.returncode == 0 else None
    return helps[key]


def check_command(command):
    words = shlex.split(command, comments=True)
    if not words:
        return
    if words[0] == "source":
        if not (root / words[1]).exists():
            problems.append(f"README.md: {command}: no file {words[1]}")
        return
    options = [w.split("=")[0] for w in words if w.startswith("--")]
    if words[0].startswith("deploy/"):
        script = root / words[0]
        if not script.exists():
            problems.append(f"README.md: {command}: no script {words[0]}")
            return
        for option in options:
            if option + ")" not in script.read_text() and option + " " not in script.read_text():
                problems.append(f"README.md: {command}: {words[0]} knows no {option}")
        return
    if not words[0].startswith("driftwise"):
        return
    # The verb: words until the first that is an option, a value or a file.
    verb = [words[0]]
    for word in words[1:]:
        if not re.fullmatch(r"[a-z][a-z0-9-]*", word) or help_of(verb + [word]) is None:
            break
        verb.append(word)
    page = help_of(verb)
    if page is None or (len(verb) == 1 and len(words) > 1 and not words[1].startswith("-")):
        problems.append(f"README.md: {command}: no such command")
        return
    for option in options:
        if not re.search(re.escape(option) + r"\b", page):
            problems.append(f"README.md: {command}: {' '.join(verb)} knows no {option}")


count = 0
for block in re.findall(r"```\n(.*?)```", text, re.S):
    for line in block.splitlines():
        count += 1
        check_command(line)
for inline in re.findall(r"`((?:driftwise|driftwised|deploy/[a-z]+\.sh)[ ][^`]*)`", text):
    count += 1
    check_command(inline)
if count < 8:
    problems.append(f"only {count} commands were found in README.md: does this test still read it?")

print(f"{count} commands, {len(lines)} lines")
for problem in problems:
    print(problem)
sys.exit(1 if problems else 0)
