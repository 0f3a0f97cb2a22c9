"""A locale that writes 1,5 and 1.000: what people in half of Europe have set."""
import os
import pathlib
import shutil
import subprocess

NAME = "trunnion_comma"
DEFINITION = """comment_char %
escape_char /
LC_NUMERIC
decimal_point ","
thousands_sep "."
grouping 3;3
END LC_NUMERIC
"""


def comma_locale(folder):
    """Environment under which NAME can be set, compiled into `folder`; None where that cannot be done."""
    folder = pathlib.Path(folder)
    if shutil.which("localedef") is None:
        return None
    (folder / "comma.def").write_text(DEFINITION)
    made = folder / "locales"
    made.mkdir(exist_ok=True)
    subprocess.run(["localedef", "-c", "-i", folder / "comma.def", "-f", "UTF-8", made / NAME], capture_output=True, check=False)
    if not (made / NAME / "LC_NUMERIC").exists():
        return None
    return {**os.environ, "LOCPATH": str(made), "LC_ALL": NAME}
