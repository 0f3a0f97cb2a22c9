#!/usr/bin/env python3
"""Runs a command beside a PostgreSQL server of its own.

    with_postgres.py COMMAND …

Starts a server on a socket in a scratch folder, puts its URI into TRUNNION_TEST_POSTGRES and in place of the word {uri},
runs the command, stops the server and returns the command's exit status; 77 (skipped) where there is no PostgreSQL.
"""
import glob
import os
import pwd
import shutil
import subprocess
import sys
import tempfile


def server_programs():
    """The folder of initdb and pg_ctl, which Debian keeps out of the PATH."""
    found = sorted(glob.glob("/usr/lib/postgresql/*/bin/initdb"))
    return os.path.dirname(found[-1] if found else shutil.which("initdb") or "")


def unprivileged():
    """The server refuses to run as root: a user that is not, and the way to become it."""
    if os.getuid() != 0:
        return pwd.getpwuid(os.getuid()), []
    for name in ("postgres", "nobody"):
        try:
            user = pwd.getpwnam(name)
        except KeyError:
            continue
        return user, ["setpriv", f"--reuid={user.pw_uid}", f"--regid={user.pw_gid}", "--clear-groups"]
    return None, []


def main():
    programs = server_programs()
    user, become = unprivileged()
    if not programs or user is None or not shutil.which("psql"):
        print("no PostgreSQL server here: skipped (cmake/install-dependencies.sh postgres)")
        return 77
    with tempfile.TemporaryDirectory(prefix="tpg") as folder:  # short: a socket's path has a limit
        os.chmod(folder, 0o755)
        data = os.path.join(folder, "data")
        os.mkdir(data)
        os.chown(data, user.pw_uid, user.pw_gid)

        def server(program, *words):
            subprocess.run([*become, os.path.join(programs, program), "-D", data, *words], check=True, cwd=data,
                           stdout=subprocess.DEVNULL)
        server("initdb", "--auth=trust", "--username=trunnion", "--encoding=UTF8", "--locale=C.UTF-8", "--no-sync")
        # Durable as in a plant: fsync stays on.
        server("pg_ctl", "start", "--wait", "--log", os.path.join(data, "log"),
               "--options", f"-c listen_addresses='' -c unix_socket_directories={data} -c unix_socket_permissions=0777")
        try:
            os.chmod(data, 0o755)
            uri = f"postgresql:///postgres?host={data}&user=trunnion"
            words = [word.replace("{uri}", uri) for word in sys.argv[1:]]
            return subprocess.run(words, env={**os.environ, "TRUNNION_TEST_POSTGRES": uri}).returncode
        finally:
            server("pg_ctl", "stop", "--mode=fast")


if __name__ == "__main__":
    sys.exit(main())
