"""Files that are written: checked before a long computation, written whole or not at all."""

import os
import tempfile

from ._errors import InputError


def check_writable(path: str, name: str) -> None:
    """Refuses a file that can't be written; folders that are missing are made when it is written.

    ``name`` is the keyword that asks for the file.
    """
    if os.path.isdir(path):
        raise InputError(f"{name}: {path} is a folder")
    folder = nearest_folder(path)
    if not os.path.isdir(folder):
        raise InputError(f"{name}: {path} can't be written: {folder} is no folder")
    for part in os.path.relpath(path, folder).split(os.sep):
        try:
            os.lstat(os.path.join(folder, part))
        except FileNotFoundError:
            pass
        except OSError as cause:
            # The file system does not take the name, which may be too long.
            raise InputError(f"{name}: {path} can't be written: {cause.strerror}") from None
    try:
        # A file without a name: nothing is left behind.
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as cause:
        told = f"the folder {folder} refuses files ({cause.strerror})"
        raise InputError(f"{name}: {path} can't be written: {told}") from None


def nearest_folder(path: str) -> str:
    """What exists of the folders that a file is to lie in."""
    folder = os.path.dirname(os.path.abspath(path))
    while not os.path.lexists(folder):
        folder = os.path.dirname(folder)
    return folder


def make_parent(path: str) -> None:
    """Makes the folder of a file."""
    try:
        os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
    except OSError as cause:
        raise unwritten(path, cause) from None


def write_whole(path: str, content: bytes) -> None:
    """Writes a file whole or not at all."""
    make_parent(path)
    folder = os.path.dirname(os.path.abspath(path))
    try:
        handle, new = tempfile.mkstemp(dir=folder, prefix=".phex-")
    except OSError as cause:
        raise unwritten(path, cause) from None
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(new, 0o666 & ~mask)
        os.replace(new, path)
    except OSError as cause:
        os.unlink(new)
        raise unwritten(path, cause) from None


def unwritten(path: str, cause: OSError) -> InputError:
    """The error of a file that the system refuses; it does not name the file that comes before."""
    return InputError(f"{path} can't be written: {cause.strerror or cause}")
