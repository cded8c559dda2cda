"""Strategies: hostile values, sound documents with some of their parts changed, files of events, command lines."""

import copy
import io
import json
import pickle
import re
import struct
import zipfile
from pathlib import Path
from typing import Any

import click
import numpy as np
import pandas as pd
from hypothesis import strategies as st

NASTY_TEXTS = ("", " ", ".", "..", "../../x", "/etc/passwd", "a/b", "a\\b", "nul\0nul", "-", "--", "~", "*", "x" * 5000)
NASTY_TEXTS += ("planted:X", "planted.py:X", "os:system", "toys:Normal", "toys:", ":Normal", "toys:Nobody", "weinberg")
NASTY_TEXTS += ("\n", "\x1b[31m", "\u202e", "\U0001f41f", "nan", "inf", "1e999", "-1", "0x10", "None", "[]", "{}")
NASTY_NUMBERS = (0, -1, 1, 2**31, 2**63 - 1, 2**63, 2**64, -(2**63), 10**30, 0.5, -0.0, 1e-320, 1e308, 1e999, -1e999)
nasty_texts = st.sampled_from(NASTY_TEXTS) | st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
nasty_numbers = st.sampled_from(NASTY_NUMBERS) | st.floats() | st.integers()


ladders = st.builds(json.loads, st.just(150 * "[" + 150 * "]"))
"""Lists in one another, deeper than any reader needs to go: new ones each time, since they may be changed."""
nasty = st.recursive(
    st.none() | st.booleans() | nasty_numbers | nasty_texts | st.just("half \ud800") | ladders,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(nasty_texts, inner, max_size=3),
    max_leaves=6,
)


def places(value: Any, at: tuple = ()) -> list[tuple]:
    """The paths to all parts of a document."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [at, *(place for key, each in inner for place in places(each, (*at, key)))]


@st.composite
def changed(draw: st.DrawFn, document: Any) -> Any:
    """A document in which up to three parts are replaced, left out, doubled or renamed."""
    document = copy.deepcopy(document)
    for _ in range(draw(st.integers(1, 3))):
        at = draw(st.sampled_from(places(document)))
        if not at:
            if draw(st.integers(0, 9)) == 0:
                return draw(nasty)
            continue
        holder = document
        for key in at[:-1]:
            holder = holder[key]
        how = draw(st.sampled_from(["replace", "replace", "replace", "drop", "more"]))
        if how == "replace":
            holder[at[-1]] = draw(nasty)
        elif how == "drop":
            del holder[at[-1]]
        elif isinstance(holder, list):
            holder.append(copy.deepcopy(holder[at[-1]]))
        else:
            holder[draw(nasty_texts)] = draw(nasty)
    return document


@st.composite
def mutated(draw: st.DrawFn, content: bytes) -> bytes:
    """Bytes of which some are changed, left out, or put in; or which end too soon."""
    data = bytearray(content)
    for _ in range(draw(st.integers(1, 8))):
        place = draw(st.integers(0, max(0, len(data) - 1)))
        how = draw(st.sampled_from(["flip", "flip", "set", "cut", "insert", "number", "end"]))
        if how == "flip" and data:
            data[place] ^= 1 << draw(st.integers(0, 7))
        elif how == "set":
            data[place : place + 4] = draw(st.binary(max_size=4))
        elif how == "cut":
            del data[place : place + draw(st.integers(1, 64))]
        elif how == "insert":
            data[place:place] = draw(st.binary(max_size=16))
        elif how == "number":
            data[place : place + 8] = struct.pack("<Q", draw(st.sampled_from([0, 2**31, 2**40, 2**63, 2**64 - 1])))
        elif draw(st.booleans()):
            del data[place:]
    return bytes(data)


class Bomb:
    """Pickled, it leaves a file beside the data when it is loaded."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple:
        return Path.touch, (self.path,)


def sound_events(kind: str) -> bytes:
    """A small sound file of events of one format."""
    x, file = np.random.default_rng(0).normal(size=(40, 2)), io.BytesIO()
    if kind == "npy":
        np.save(file, x)
    elif kind == "npz":
        np.savez(file, x=x)
    elif kind == "csv":
        file.write(pd.DataFrame(x, columns=["a", "b"]).to_csv(index=False).encode())
    elif kind == "parquet":
        pd.DataFrame(x, columns=["a", "b"]).to_parquet(file)
    else:
        import uproot

        with uproot.recreate(file) as opened:
            opened["t"] = {"a": x[:, 0], "b": x[:, 1]}
            return file.getvalue()
    return file.getvalue()


@st.composite
def npy_headers(draw: st.DrawFn) -> bytes:
    """An array whose header says what it likes of its type, order and shape."""
    shape = draw(st.lists(st.integers(-1, 2**62), max_size=3))
    kind = draw(st.sampled_from(["<f8", "<i8", "|O", "<U9999999", "<M8[ns]", "|V8", "<c16", "|b1", "<f2", "x", "<u8"]))
    header = repr({"descr": kind, "fortran_order": draw(st.booleans()), "shape": tuple(shape)}).encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header) + 1) + header + b"\n" + draw(st.binary(max_size=64))


@st.composite
def events(draw: st.DrawFn, kind: str, bomb: Path) -> bytes:
    """What a file of this format may hold that nobody should send."""
    how = draw(st.integers(0, 9))
    if how == 0:
        return draw(st.binary(max_size=200))
    if kind in ("npy", "npz") and how in (1, 2):
        array = np.array([[Bomb(bomb)]], dtype=object)
        file = io.BytesIO()
        np.save(file, array) if kind == "npy" else np.savez(file, x=array)
        return file.getvalue() if draw(st.booleans()) else pickle.dumps(Bomb(bomb))
    if kind == "npy" and how in (3, 4, 5):
        return draw(npy_headers())
    if kind == "npz" and how in (3, 4, 5):
        file = io.BytesIO()
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            name = draw(st.sampled_from(["x.npy", "../../x.npy", "/x.npy", "x", ""]))
            archive.writestr(name or "y.npy", draw(npy_headers()))
        return file.getvalue()
    if kind == "csv" and how < 7:
        cells = st.floats().map(str) | nasty_texts
        rows = draw(st.lists(st.lists(cells, max_size=4).map(",".join), max_size=8))
        return "\n".join(rows).encode(errors="surrogatepass")
    return draw(mutated(sound_events(kind)))


LINES = {
    "list": ("effects --task poisson", "tasks", ""),
    "infer": ("--task toys:Normal --method toys:Moment --data x.npy --budget 400 --out fit.json",),
    "run": (
        "--task toys:Normal --method toys:Moment --targets 0-1 --budget 400 --observations 100 --jobs 1",
        "--task model.json --method toys:Moment --targets 0 --budget 400 --observations 100 --results fresh --seed 0",
        "--task poisson --method toys:Moment --set moment.steps=2 --targets 0 --budget 400 --observations 100",
    ),
    "status": ("--results store",),
    "export": ("--results store --format csv --out table.csv",),
    "pack": ("--results store",),
    "report": ("--results store --out page",),
    "figure": ("benchmark --results store --out drawn", "efficiency --results store --out drawn"),
    "check": ("task poisson", "method toys:Moment", "effect dead_time"),
    "challenge make": ("--task toys:Normal --cases 1 --events 200 --kinds none --out made",),
    "challenge score": ("made", "made --format json --targets"),
    "challenge solve": ("challenge --alpha 0.05 --trust",),
    "diagnose": ("--task poisson --data x.npy --out answer --seed 0 --alpha 0.05 --max-effects 1",),
}
"""Sound command lines, on what `CommandLines` puts into the folder."""
UNKNOWN = ("--no-such-option", "-Q")
SLOW = ("challenge solve", "diagnose")
"""Commands that would work for long if their line were right: of these, lines that must be refused only."""
POSITIVE = ("--budget", "--observations", "--repetitions", "--jobs", "-j", "--cases", "--events", "--group")
POSITIVE += ("--time-limit", "--memory-limit", "--simulations")
"""Options that take a number above 0."""
WRONG_NUMBERS = ("", "x", "nan", "0", "-1", "1e3x", "0x10", "0.5.1", "inf", "-inf", "1e999", "\u0663\u0663x", "--")
OWN_FILES = ("", ".", "x.npy", "x.npy/inside", "store", "store/records", "nothing", "model.json")
OWN_FILES += ("y" * 300, "a\nb", "n\u00ef")
"""Places within the folder: a user who names another one means it."""
NUMBERS = ("0", "1", "-1", "3", "200", "1e3", "0.05", "nan", "0-", "3-1", "0-1-2", "1,,2", "0-99999999999", "9" * 20)


@st.composite
def command_lines(draw: st.DrawFn, commands: dict[str, click.Command]) -> tuple[list[str], bool]:
    """A sound command line in which one to three parts are changed, and whether it must be refused.

    It must where an option does not exist, a number is none or not positive, or a needed option is missing; the rest
    may make sense by chance.
    """
    name = draw(st.sampled_from(sorted(LINES)))
    options = [option for option in commands[name].params if isinstance(option, click.Option)]
    by_flag = {flag: option for option in options for flag in option.opts}
    line = draw(st.sampled_from(LINES[name]))
    parts = [part.split() for part in re.findall(r"--\S+(?: (?!--)\S+)?|\S+", line)]
    for _ in range(draw(st.integers(1, 3))):
        how = draw(st.sampled_from(["value", "value", "drop", "more", "word"]))
        if how == "value" and (given := [part for part in parts if len(part) == 2]):
            part = draw(st.sampled_from(given))
            part[1] = draw(_values(by_flag[part[0]]))
        elif how == "drop" and parts:
            parts.remove(draw(st.sampled_from(parts)))
        elif how == "more" and options:
            flag = draw(st.sampled_from(sorted(by_flag)))
            parts.append([flag] if by_flag[flag].is_flag else [flag, draw(_values(by_flag[flag]))])
        elif how == "word":
            word = draw(st.sampled_from([*OWN_FILES, *NUMBERS, *UNKNOWN, "--"]))
            parts.insert(draw(st.integers(0, len(parts))), [word])
    options_end = parts.index(["--"]) if ["--"] in parts else len(parts)
    last = {part[0]: part[1] for part in parts if len(part) == 2}
    wrong = any(part[0] in UNKNOWN for part in parts[:options_end])
    wrong |= any(flag in POSITIVE and value in WRONG_NUMBERS for flag, value in last.items())
    wrong |= not {option.opts[0] for option in options if option.required} <= set(last)
    if name in SLOW and not wrong:
        parts, wrong = [["--no-such-option"], *parts], True
    line = [*name.split(), *(word for part in parts for word in part)]
    return [word.replace("\0", "") for word in line], wrong


def _values(option: click.Option) -> st.SearchStrategy[str]:
    """What may be given to an option: sense and nonsense."""
    if isinstance(option.type, click.Path) or option.opts[0] == "--data":
        return st.sampled_from(OWN_FILES)
    texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
    if isinstance(option.type, click.types.IntParamType | click.types.FloatParamType):
        return st.sampled_from(NUMBERS + WRONG_NUMBERS) | texts
    named = [each for each in NASTY_TEXTS if not each.startswith("planted")]  # which would rightly be run
    return st.sampled_from((*named, *NUMBERS)) | texts
