"""The folder of workshop files, in which everything of others stays: by the rules of ``phex fab``.

The file ``phex.sha256`` lists what a run wrote, with checksums. Only a file that is listed and
still has its checksum is written over or removed. Where anything else has a name that is needed,
nothing is written at all.
"""

import hashlib
import os
import re
from typing import Dict, Iterable, List, Set

from ._errors import InputError
from ._output import check_writable, write_whole

#: The list of a folder's files with their checksums, which the program keeps, too.
LIST = "phex.sha256"
#: Its first line, by which the program knows it.
HEAD = (
    "# Files of `phex fab`: it writes over them and removes them as long as they are as listed.\n"
)
#: Where a run of the program that was killed keeps files until all of them are written.
STAGE = ".phex-new"
ENTRY = re.compile(r"([0-9a-fA-F]{64})  (.+)")
#: Files that a refusal names.
NAMED = 5

#: The checksums that each listed file may have: two while a run replaces it.
Sums = Dict[str, Set[str]]


def check_folder(folder: str, names: Iterable[str] = (), inputs: Iterable[str] = ()) -> Sums:
    """Refuses a folder that can't be written with files of these names (and others), or that holds
    inputs; gives what an earlier run wrote there."""
    if os.path.lexists(folder) and not os.path.isdir(folder):
        raise InputError(f"folder: {folder} is no folder")
    check_writable({"folder": os.path.join(folder, LIST)})
    whole = os.path.realpath(folder)
    for path in map(os.path.realpath, inputs):
        if path.startswith(os.path.join(whole, "")):
            told = f"folder: {path} is read and lies in the folder that is written ({folder})"
            raise InputError(f"{told}: give another folder")
    listed = _listed(folder)
    _check_files(folder, listed, names)
    return listed


def save_folder(folder: str, files: Dict[str, bytes]) -> None:
    """Writes files into a folder, and removes those of an earlier run that are no longer made."""
    listed = check_folder(folder, files)
    new = {name: {_checksum(content)} for name, content in files.items()}
    # A run that is killed leaves every file with a checksum that is listed.
    names = {*listed, *new}
    either = {name: listed.get(name, set()) | new.get(name, set()) for name in names}
    _write_list(folder, either)
    for name, content in files.items():
        write_whole(_path(folder, name), content)
    for name in listed:
        path = _path(folder, name)
        if name not in files and os.path.lexists(path):
            try:
                os.unlink(path)
            except OSError as cause:
                raise InputError(f"{path} can't be removed: {cause.strerror}") from None
    _write_list(folder, new)


def _listed(folder: str) -> Sums:
    """What an earlier run wrote."""
    path = os.path.join(folder, LIST)
    try:
        with open(path, "rb") as file:
            return _parsed(folder, file.read())
    except FileNotFoundError:
        if os.path.isdir(folder) and set(os.listdir(folder)) - {STAGE}:
            told = f"it holds other files (and no `{LIST}` of an earlier run)"
            raise InputError(f"folder: {folder}: {told}; give a new or an empty folder") from None
        return {}
    except OSError as cause:
        raise InputError(f"folder: {path}: {cause.strerror}") from None


def _parsed(folder: str, content: bytes) -> Sums:
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError:
        text = ""
    if not text.startswith(HEAD):
        told = f"`{LIST}` is not a list that `phex fab` wrote; give another folder"
        raise InputError(f"folder: {folder}: {told}")
    sums: Sums = {}
    entries = text[len(HEAD) :].removesuffix("\n")
    for number, line in enumerate(entries.split("\n") if entries else (), 2):
        entry = ENTRY.fullmatch(line)
        if entry is None or not _is_inside(entry[2]):
            told = f"`{LIST}` can't be used: line {number} is no checksum and name"
            raise InputError(f"folder: {folder}: {told}")
        sums.setdefault(entry[2], set()).add(entry[1])
    return sums


def _is_inside(name: str) -> bool:
    """Whether a path leads to a file below the folder that it starts from."""
    parts = name.replace(os.sep, "/").split("/")
    return not os.path.splitdrive(name)[0] and not {"", ".", ".."} & set(parts)


def _check_files(folder: str, listed: Sums, names: Iterable[str]) -> None:
    """Refuses files of others with names that are needed, and listed ones that have changed."""
    others = [n for n in sorted({*names, *listed}) if not _is_free(folder, n, listed.get(n, set()))]
    if not others:
        return
    told = [f"{n} {'has been changed since' if n in listed else 'is in the way'}" for n in others]
    more = f" and {len(told) - NAMED} more" if len(told) > NAMED else ""
    raise InputError(
        f"folder: {folder}: only files that an earlier `phex fab` wrote are written over; "
        f"{', '.join(told[:NAMED])}{more}: move them away, or give another folder"
    )


def _is_free(folder: str, name: str, sums: Set[str]) -> bool:
    """Whether a file of this name may be written: there is none, or one that is as listed."""
    path = folder
    *folders, _ = parts = name.split("/")
    for k, part in enumerate(parts):
        path = os.path.join(path, part)
        if not os.path.lexists(path):
            return True
        is_kind = os.path.isdir if k < len(folders) else os.path.isfile
        if os.path.islink(path) or not is_kind(path):
            return False
    try:
        with open(path, "rb") as file:
            return _checksum(file.read()) in sums
    except OSError:
        return False


def _write_list(folder: str, sums: Sums) -> None:
    lines: List[str] = [f"{s}  {n}\n" for n in sorted(sums) for s in sorted(sums[n])]
    write_whole(os.path.join(folder, LIST), (HEAD + "".join(lines)).encode())


def _path(folder: str, name: str) -> str:
    return os.path.join(folder, *name.split("/"))


def _checksum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
