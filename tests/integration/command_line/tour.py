#!/usr/bin/python3
"""deploy/tour.sh in two shells: the second is told about the first, and nobody's files are deleted. And what docs/start/tour.md has a
reader type after it to start a cell that hides something.

Usage: tour.py path/to/driftwise path/to/source
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

program, source = (pathlib.Path(one).resolve() for one in sys.argv[1:3])


def shell(root: pathlib.Path, script: str) -> str:
    environment = {**os.environ, "PS1": ""}
    done = subprocess.run(["bash", "-c", script], cwd=root, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, timeout=120)
    return done.stdout


with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR", "/tmp")) as folder:
    # A checkout of its own: the tour's folder stands beside deploy/.
    root = pathlib.Path(folder)
    (root / "deploy").mkdir()
    shutil.copy(source / "deploy/tour.sh", root / "deploy")
    (root / "deploy/cells").symlink_to(source / "deploy/cells")
    (root / "build/dev").mkdir(parents=True)
    (root / "build/dev/bin").symlink_to(program.parent)
    tour = f"source '{root}/deploy/tour.sh'"
    second = f'bash -c "{tour}; pwd; driftwise note pin second && tour_end"'
    said = shell(root, f"{tour}; echo mine > notes.txt; {second}; driftwise note pinned; cat notes.txt")
    assert "a tour of another shell runs already: nothing was started, nothing deleted" in said, said
    assert f"{root}/out/tour\n" in said, said
    assert said.endswith("mine\n") and "second" in said, "the first shell's daemon lives, and its folder: " + said
    assert not (root / "out/tour/driftwised.json").exists(), "it ended with its shell"

    said = shell(root, f"{tour}; driftwise note pinned")
    assert "the folder of the tour before is kept: " in said and "second" not in said, said
    kept = list((root / "out").glob("tour-kept-*"))
    assert len(kept) == 1 and (kept[0] / "notes.txt").read_text() == "mine\n", kept
    assert (kept[0] / "driftwise.sqlite").exists()

    page = (source / "docs/start/tour.md").read_text()
    starts = next(block for block in page.split("```") if "--hide random" in block).split("driftwise improve")[0]
    for _ in range(2):  # twice: what the first time left must not stop the second
        said = shell(root, f"{tour}; {starts}\ndriftwise status; pwd; kill $daemon $sim")
        assert "did not start" not in said and "/cell\n" in said, said
