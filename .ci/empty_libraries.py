"""Empty libraries in the places of those that torch's libraries name and that are not installed.

    python empty_libraries.py SITE_PACKAGES

Needs cc and nm. Each has the functions that torch asks of it, in the versions it asks for; they
return 1, an error of all of CUDA's libraries.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path


def said(*words: str) -> str:
    return subprocess.run(words, check=True, capture_output=True, text=True).stdout


def main(packages: Path) -> None:
    folder = packages / "torch/lib"
    own = sorted(folder.glob("*.so*"))
    there = {path.name for path in [*own, *packages.glob("nvidia/*/lib/*.so*")]}
    needed: set[str] = set()
    wanted: dict[str, set[str]] = {}
    has: set[str] = set()
    for path in own:
        head = said("readelf", "--dynamic", "--version-info", "--wide", str(path))
        needed |= set(re.findall(r"\(NEEDED\).*\[(.*)\]", head))
        files = {}
        for file, versions in re.findall(r"File: (\S+).*((?:\n.*Name: .*)*)", head):
            for version in re.findall(r"Name: (\S+)", versions):
                files[version] = file
        for line in said("nm", "--dynamic", str(path)).splitlines():
            *_, kind, name = line.split()
            name, _, version = name.partition("@")
            version = version.lstrip("@")
            if kind not in "Uwv":
                has.add(name)
            elif kind == "U" and version in files:
                wanted.setdefault(f"{files[version]}:{version}", set()).add(name)
            elif kind == "U" and not version:
                wanted.setdefault("", set()).add(name)
    wanted[""] = {name for name in wanted.get("", set()) - has if re.match(r"nccl|cu[a-zA-Z]", name)}
    gpu = re.compile(r"lib(cu|nv|nccl)(?!da\.so)")
    missing = sorted(name for name in needed if name not in there and gpu.match(name))
    for number, library in enumerate(missing):
        versions = {k.partition(":")[2]: v for k, v in wanted.items() if k.startswith(f"{library}:")}
        loose = wanted[""] if number == 0 else set()
        build(folder / library, versions, loose)
        print(f"{library}: {sum(map(len, versions.values())) + len(loose)} functions")


def build(path: Path, versions: dict[str, set[str]], loose: set[str]) -> None:
    names = sorted(loose.union(*versions.values()))
    with tempfile.TemporaryDirectory() as scratch:
        source, script = Path(scratch, "empty.c"), Path(scratch, "versions")
        source.write_text("".join(f"int {name}(void) {{ return 1; }}\n" for name in names) or "int empty;")
        script.write_text(
            "".join(
                f"{version} {{ global: {' '.join(f'{n};' for n in sorted(own))} }};\n"
                for version, own in versions.items()
            )
        )
        words = ["cc", "-shared", "-fPIC", "-w", "-fno-builtin", str(source), "-o", str(path)]
        words += [f"-Wl,-soname,{path.name}"]
        said(*words, *([f"-Wl,--version-script={script}"] if versions else []))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
