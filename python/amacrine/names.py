"""What comes with the package, by name."""

from __future__ import annotations

import errno
import os
from pathlib import Path

from . import _amacrine, arguments
from ._amacrine import Error


def names(of: str) -> list[str]:
    """The names of what comes with the package.

    Args:
        of: ``sensors``, ``programs``, ``kernels``, ``studies``, ``readouts``, ``chips`` or
            ``patterns``.
    """
    return _amacrine.names(arguments.word("of", of, "sensors"))


def text(of: str, name: str) -> str:
    """The text of what comes with the package, such as ``text("sensors", "rgc-4")``: of a chip its
    numbers, of a pattern its parameters."""
    known = names(of)
    found = _amacrine.text(of, arguments.word("name", name, known[0]))
    if found is None:
        raise Error(f"there is no {name} in {of}\nhelp: there are {', '.join(known)}")
    return found[1]


def opened(
    of: str, name: arguments.File, argument: str = "path"
) -> tuple[str, str, Path | None]:
    """A file by its path, else by its name among those that come with the package: what it is
    called, its text, and the folder that paths in it are relative to."""
    path = Path(arguments.file(argument, name, "the path of a file, or a name"))
    if path.is_file():
        try:
            # It is found from another folder, too.
            return str(path), path.read_text(encoding="utf-8"), path.parent.absolute()
        except (OSError, UnicodeDecodeError) as cause:
            raise Error(f"{path}: {cause}\nhelp: give a file of text that can be read") from cause
    found = _amacrine.text(of, str(name))
    if found is not None:
        return *found, None
    number = errno.EISDIR if path.is_dir() else errno.ENOENT
    raise Error(
        f"cannot read {name}: {os.strerror(number)} (os error {number})\n"
        f"help: {_amacrine.meant(of, str(name), _otherwise(of))}"
    )


def _otherwise(of: str) -> str:
    """What is taken: a file, or a name of those that come with the package."""
    file = {"sensors": "a sensor file", "programs": "the path of a program", "studies": "a study file"}
    known = ", ".join(names(of))
    return f'give {file.get(of, "the path of a file")}, or one of amacrine.names("{of}"): {known}'


def chip(given: arguments.File) -> str:
    """A chip by its name, or its folder, which is found from another folder, too."""
    named = str(arguments.file("chip", given, "the name of a chip, or its folder"))
    is_folder = named not in names("chips") and Path(named).is_dir()
    return str(Path(named).absolute()) if is_folder else named
