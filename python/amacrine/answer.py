"""What a study says."""

from __future__ import annotations

import html
import importlib
import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from . import _amacrine
from ._amacrine import Error
from .arguments import file
from .caution import caution
from .notebook import table


class Answer:
    """What a study says, in the names and numbers of the command line's ``--json``; what that repeats
    of the command (files, light, commands to run) is left out, and options in its messages are called
    as arguments are here.

    Keys are attributes: ``answer.verdict``, or ``answer["verdict"]`` where a name is no word of
    Python. Lists and numbers are plain. In a notebook it shows its report or its drawing.
    """

    def __init__(
        self,
        data: dict[str, Any],
        *,
        page: str | None = None,
        drawing: str | None = None,
        rows: str | None = None,
        shown: list[dict[str, Any]] | None = None,
    ) -> None:
        self._data = data
        self._page = page
        self._drawing = drawing
        self._rows = rows
        self._shown = shown

    @classmethod
    def parse(
        cls,
        text: str,
        *,
        page: str | None = None,
        drawing: str | None = None,
        rows: str | None = None,
        show: Callable[[dict[str, Any]], list[dict[str, Any]]] | None = None,
    ) -> Answer:
        """From JSON. ``show`` says which rows a notebook shows, where not all of its table."""
        data = _in_python(json.loads(text))
        if isinstance(data, list):
            return cls({"rows": data}, rows="rows")
        shown = None if show is None else show(data)
        page = None if page is None else _page_in_python(page)
        return cls(data, page=page, drawing=drawing, rows=rows, shown=shown)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self[name]
        except KeyError:
            known = ", ".join(self._data)
            raise AttributeError(f"there is no {name}; there are {known}") from None

    def __getitem__(self, name: str) -> Any:
        if name not in self._data:
            raise KeyError(f"there is no {name}; there are {', '.join(self._data)}")
        return _wrapped(self._data[name])

    def keys(self) -> list[str]:
        """The names of what it says, so that ``dict(answer)`` works."""
        return list(self._data)

    def __iter__(self) -> Iterator[str]:
        return iter(self._data)

    def __len__(self) -> int:
        return len(self._data)

    def __contains__(self, name: object) -> bool:
        return name in self._data

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._data]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Answer) and self._data == other._data

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self._data, self._page, self._drawing, self._rows, self._shown)

    def to_dict(self) -> dict[str, Any]:
        """All of it as plain dicts and lists."""
        return self._data

    def to_frame(self, key: str | None = None) -> Any:
        """A list of it as a pandas data frame, such as ``"chip.rows"`` for one inside of another; the
        list that is its table where ``key`` is left out. Of several kernels it is that of each where only
        each has it, with the kernel's name in the column ``kernel``. Needs pandas."""
        key = self._rows if key is None else key
        found = self._list(key)
        if found is None:
            found = self._of_kernels(key)
        if found is None:
            lists = [name for name, of in self._data.items() if isinstance(of, list)]
            lists += [self._rows] if self._rows and "." in self._rows else []
            raise KeyError(f"{key} is no table; there are {', '.join(lists)}")
        pandas = importlib.import_module("pandas")
        return pandas.json_normalize(found)

    def _list(self, key: str | None) -> list[Any] | None:
        """A list by its name, or by those that lead to it, with points in between."""
        found: Any = None if key is None else self._data
        for name in (key or "").split("."):
            found = found.get(name) if isinstance(found, dict) else None
        return found if isinstance(found, list) else None

    def _of_kernels(self, key: str | None) -> list[Any] | None:
        """The lists of this name of all kernels, one after the other."""
        kernels = [of for of in self._list("kernels") or () if isinstance(of, dict)]
        each = [(_name(of), Answer(of)._list(key)) for of in kernels]
        if all(rows is None for _, rows in each):
            return None
        return [{"kernel": name} | row for name, rows in each for row in rows or ()]

    @property
    def page(self) -> str | None:
        """The report, a page of HTML; none where the study has none."""
        return self._page

    @property
    def drawing(self) -> str | None:
        """The drawing, as SVG; none where the study has none."""
        return self._drawing

    def save(self, path: str | Path) -> None:
        """Writes the report (.html), the drawing (.svg) or all of it (.json), whole or not at all."""
        ending = Path(file("path", path, "the path of the file to write")).suffix.lower()
        texts = {".html": self._page, ".svg": self._drawing, ".json": json.dumps(self._data)}
        text = texts.get(ending)
        if text is None:
            has = ", ".join(name for name, of in texts.items() if of is not None)
            raise Error(f"{path}: there is no {ending or 'ending'} of this\nhelp: end the name in {has}")
        _amacrine.save(path, text)

    def __repr__(self) -> str:
        return f"Answer({', '.join(self._data)})"

    def _repr_html_(self) -> str:
        if self._page is not None:
            whole = html.escape(self._page, quote=True)
            return f'<iframe srcdoc="{whole}" width="100%" height="800" frameborder="0"></iframe>'
        if self._drawing is not None:
            return self._drawing
        if self._shown is not None:
            return table(self._shown)
        rows = self._list(self._rows) if self._rows else [self._data]
        return table(rows or [])


def _name(of: dict[str, Any]) -> Any:
    """What the kernel is called that a part of an answer is of."""
    return of["name"] if "name" in of else of["kernel"]["name"]


def _again(
    data: dict[str, Any],
    page: str | None,
    drawing: str | None,
    rows: str | None,
    shown: list[dict[str, Any]] | None = None,
) -> Answer:
    return Answer(data, page=page, drawing=drawing, rows=rows, shown=shown)


def _in_python(of: Any) -> Any:
    """The same with arguments in messages where the command line has options."""
    if isinstance(of, str):
        return _amacrine.in_python(of) if "--" in of else of
    if isinstance(of, list):
        return [_in_python(one) for one in of]
    if isinstance(of, dict):
        return {name: one if name in TEXTS else _in_python(one) for name, one in of.items()}
    return of


NO_TEXT = r"<(style|script|pre)\b.*?</\1>|<!--.*?-->|<[^>]*>"
"""What a page has besides its texts: tags, and what stands in them; what is to be typed, too."""

OF_JSON = "with <code>--json</code> it prints every number"


def _page_in_python(page: str) -> str:
    """The same with arguments in its texts where the command line has options; names in style sheets
    begin with two dashes, too."""
    page = page.replace(OF_JSON, "<code>to_dict()</code> has every number")
    parts, end = [], 0
    for tag in re.finditer(NO_TEXT, page, re.DOTALL):
        parts += [_in_python(page[end : tag.start()]), tag.group()]
        end = tag.end()
    return "".join([*parts, _in_python(page[end:])])


TEXTS = ("program", "sensor")
"""What is a text of a file."""


def _wrapped(of: Any) -> Any:
    if isinstance(of, dict):
        return Answer(of)
    if isinstance(of, list):
        return [_wrapped(one) for one in of]
    return of


def told(*answers: Answer) -> Answer:
    """Warns the caller of what the answers warn of, once of each thing, and gives the first back."""
    texts: dict[str, None] = {}
    for answer in answers:
        said: dict[str, str] = {}
        for one in _warnings(answer.to_dict()):
            first, *others = one["subjects"] or ["the run"]
            also = f" (also: {'; '.join(others)})" if others else ""
            text = f"{first}: {one['seen']}{also}: {one['why']}\nhelp: {one['change']}"
            said.setdefault(one["about"], text)
        texts |= dict.fromkeys(said.values())
    for text in texts:
        caution(text)
    return answers[0]


def _warnings(of: Any) -> Iterator[dict[str, Any]]:
    """All warnings of an answer, those of its parts too."""
    if isinstance(of, list):
        for part in of:
            yield from _warnings(part)
    elif isinstance(of, dict):
        for name, part in of.items():
            if name == "warnings":
                yield from (one for one in part if isinstance(one, dict))
            else:
                yield from _warnings(part)
