"""The compiled part of phex."""

from typing import Any, Optional, final

import numpy as np
from numpy.typing import NDArray

__all__ = ["Computation", "start", "Kept", "KeptSurface", "write_whole", "__version__"]

__version__: str

_Arrays = tuple[NDArray[np.float64], NDArray[np.uint32], NDArray[np.int64]]
_Given = tuple[str, str, NDArray[np.float64], NDArray[np.uint32], NDArray[np.int64]]

@final
class Kept:
    def arrays(self, /) -> list[Optional[_Arrays]]: ...

@final
class KeptSurface:
    def __new__(cls, mesh: _Given) -> KeptSurface: ...

@final
class Computation:
    def wait(self, /, seconds: float) -> bool: ...
    def events(self, /) -> list[str]: ...
    def preview(self, /) -> Optional[tuple[str, _Arrays]]: ...
    def cancel(self, /) -> None: ...
    def take(self, /) -> dict[str, Any]: ...

def write_whole(path: str, content: bytes) -> None: ...
def start(
    what: str,
    request: str,
    given: tuple[
        list[_Given], Optional[NDArray[np.float64]], Optional[Kept], Optional[KeptSurface]
    ],
    threads: Optional[int],
    preview: bool,
) -> Computation: ...
