#!/usr/bin/env python3
"""What an installation holds, seen from its own prefix: documents that point to what is there, manual pages without a
warning, completion that shells read, a module that Python imports. usage: installed_tree.py PREFIX"""
import gzip
import pathlib
import re
import shutil
import subprocess
import sys

PREFIX = pathlib.Path(sys.argv[1]).resolve()
PROGRAM = PREFIX / "bin" / "orbweave"


def check(what, condition):
    if not condition:
        sys.exit(f"installed_tree: {what}")


def links_of_the_readme():
    folder = PREFIX / "share" / "doc" / "orbweave"
    readme = (folder / "README.md").read_text(encoding="utf-8")
    links = [link for link in re.findall(r"\]\(([^)\s#]+)\)", readme) if "://" not in link]
    links += re.findall(r"`((?:docs|configs)/[\w./-]+\.\w+)`", readme)
    check("the README has no links", len(links) > 10)
    for link in links:
        check(f"README.md points to {link}, which is not installed", (folder / link).exists())
    check("configs are missing", len(list((folder / "configs").glob("*.toml"))) >= 6)


def commands():
    out = subprocess.run([PROGRAM, "--help"], capture_output=True, text=True, check=True).stdout
    return re.findall(r"^  ([a-z]+) {2,}", out[out.index("Commands:"):], re.M)


def manual_pages():
    folder = PREFIX / "share" / "man" / "man1"
    names = ["orbweave"] + [f"orbweave-{command}" for command in commands()]
    if (PREFIX / "bin" / "orbweave-mpi").exists():
        names.append("orbweave-mpi")
    for name in names:
        pages = list(folder.glob(f"{name}.1*"))
        check(f"no manual page {name}", len(pages) == 1)
        text = pages[0].read_bytes()
        text = gzip.decompress(text) if pages[0].suffix == ".gz" else text
        check(f"{name}: no exit statuses", b"EXIT STATUS" in text)
        if shutil.which("groff"):
            done = subprocess.run(["groff", "-man", "-Tutf8", "-ww", "-rLL=100n"], input=text, capture_output=True, check=True)
            check(f"{name}: {done.stderr.decode()}", not done.stderr)
            check(f"{name}: no text", name.encode() in done.stdout)
    return len(names)


def completion():
    script = PREFIX / "share" / "bash-completion" / "completions" / "orbweave"
    code = (f'set -eu; . "{script}"; COMP_WORDS=(orbweave reconstruct --kern); COMP_CWORD=2; _orbweave; echo "${{COMPREPLY[*]}}";'
            'COMP_WORDS=(orbweave reconstruct --kernel tri); COMP_CWORD=3; _orbweave; echo "${COMPREPLY[*]}";'
            'COMP_WORDS=(orbweave insp); COMP_CWORD=1; _orbweave; echo "${COMPREPLY[*]}"')
    done = subprocess.run(["bash", "-c", code], capture_output=True, text=True, check=True)
    check(f"bash completes {done.stdout!r}", done.stdout.split("\n")[:3] == ["--kernel", "triharmonic", "inspect"])
    for shell, path in (("zsh", "zsh/vendor-completions/_orbweave"), ("fish", "fish/vendor_completions.d/orbweave.fish")):
        check(f"no completion for {shell}", (PREFIX / "share" / path).stat().st_size > 1000)
        if shutil.which(shell):
            subprocess.run([shell, "-n", str(PREFIX / "share" / path)], check=True)


def python_module():
    folder = PREFIX / "lib" / "python3" / "dist-packages"
    if not folder.exists():
        return "without Python"
    code = f"import sys; sys.path.insert(0, {str(folder)!r}); import orbweave; print(orbweave.__file__)"
    done = subprocess.run(["/usr/bin/python3", "-c", code], capture_output=True, text=True, check=True)
    check("another module is imported", str(PREFIX) in done.stdout)
    return "with Python"


links_of_the_readme()
pages = manual_pages()
completion()
print(f"{PREFIX}: {pages} manual pages, completion, documents, {python_module()}")
