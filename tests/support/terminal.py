"""What a program says on a terminal."""
import os
import pty
import re
import subprocess


def seen_on_terminal(command, stream="stderr", until=None, environment=None):
    """What `command` writes to `stream`, a terminal, the other one thrown away; until the pattern `until` is in it, or to
    the command's end."""
    main, other = pty.openpty()
    streams = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, stream: other}
    child = subprocess.Popen(list(map(str, command)), env={**os.environ, "TERM": "xterm", **(environment or {})}, **streams)
    os.close(other)
    text = ""
    while until is None or not re.search(until, text):
        try:
            chunk = os.read(main, 65536)
        except OSError:
            break
        if not chunk:
            break
        text += chunk.decode()
    if until is not None:
        child.terminate()
    child.wait()
    os.close(main)
    return text
