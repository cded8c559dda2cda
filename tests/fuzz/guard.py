"""What no input may bring about, watched for by an audit hook: writing elsewhere, network, processes, foreign code."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
ON_PATHS = {"os.remove": (0,), "os.rename": (0, 1), "os.mkdir": (0,), "os.rmdir": (0,), "os.link": (0, 1)}
ON_PATHS |= {"os.chmod": (0,), "os.truncate": (0,), "os.symlink": (1,), "shutil.rmtree": (0,), "tempfile.mkstemp": (0,)}
FORBIDDEN = ("socket.connect", "socket.getaddrinfo", "socket.bind")
FORBIDDEN += ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn")
HARMLESS = ("/dev/null", "/dev/shm", "/proc", "__pycache__", "/.cache/", "/.config/", "/torchinductor_")
PLANTED = '''"""Code that a file names and nobody asked for: its import leaves a trace."""
from pathlib import Path

Path(__file__).with_name("was-run").touch()
'''


class Guard:
    """Watches this process while a block runs; `broken` tells what happened that must not."""

    def __init__(self) -> None:
        self.broken: list[str] = []
        self._allowed: list[str] | None = None
        sys.addaudithook(self._hook)

    @contextmanager
    def watching(self, *folders: Path) -> Iterator[None]:
        """Let files be written in these folders alone. Raises AssertionError for all that happened beside that."""
        self.broken, self._allowed = [], [str(folder.resolve()) for folder in folders]
        try:
            yield
        finally:
            self._allowed = None
        assert not self.broken, self.broken
        for folder in folders:
            assert not (folder / "was-run").exists(), "foreign code was run"

    def _hook(self, event: str, arguments: tuple) -> None:
        if self._allowed is None:
            return
        if event == "open":
            path, _, flags = arguments
            if isinstance(path, str | bytes | os.PathLike) and flags is not None and flags & WRITING:
                self._check(event, path)
        elif event in ON_PATHS:
            for place in ON_PATHS[event]:
                self._check(event, arguments[place], follows=event in ("os.chmod", "os.truncate"))
        elif event == "subprocess.Popen" and arguments[0] == "git":
            pass  # asks for the commit of the source
        elif event in FORBIDDEN:
            self.broken.append(f"{event} {arguments!r:.200}")

    def _check(self, event: str, path: object, follows: bool = True) -> None:
        if not isinstance(path, str | bytes | os.PathLike):
            return
        folder, name = os.path.split(os.path.abspath(os.fsdecode(path)))
        place = os.path.join(os.path.realpath(folder), name)  # of a link itself
        if follows:
            place = os.path.realpath(place)
        allowed = any(place == folder or place.startswith(folder + os.sep) for folder in self._allowed or ())
        if not allowed and not any(part in place for part in HARMLESS):
            self.broken.append(f"{event} {place}")


def plant(folder: Path) -> None:
    """A module `planted` in the folder, which is the current one, and first on the path, of what is fuzzed."""
    (folder / "planted.py").write_text(PLANTED)
