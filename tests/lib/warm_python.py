"""A Python process that has its libraries imported already, which saves a second in each of many commands.

    warm_python.py serve SOCKET        waits for calls until the process that started it has ended
    warm_python.py call SOCKET WORD... does the work of `python3 WORD...` (-c TEXT, - or FILE) in a child of the server

A child has the folder, environment, standard streams, limit of memory and words of the call, and imports the package itself. Signals to the caller
do not reach the child. Exit code 77 of `serve` means that a library is missing.

SPDX-License-Identifier: MIT
"""
import json
import os
import resource
import socket
import sys

MOST = 1 << 20  # most bytes of the words and the environment of a call


def start():
    """Starts a server for a test in Python. From then on the program hands over to the server, which ends with the test."""
    import atexit
    import shutil
    import subprocess
    import tempfile
    import time
    folder, python = tempfile.mkdtemp(), os.environ.get("CLUSTERMCML_PYTHON", sys.executable)
    path, command = os.path.join(folder, "socket"), os.path.join(folder, "python")
    server = subprocess.Popen([python, "-B", os.path.abspath(__file__), "serve", path])
    atexit.register(lambda: (server.terminate(), server.wait(), shutil.rmtree(folder)))
    with open(command, "w", encoding="utf-8") as file:
        file.write(f'#!/bin/sh\nexec "{python}" -IS "{os.path.abspath(__file__)}" call "{path}" "$@"\n')
    os.chmod(command, 0o755)
    while not os.path.exists(path):
        if server.poll() is not None:
            sys.exit(server.returncode)
        time.sleep(0.05)
    os.environ["CLUSTERMCML_PYTHON"] = command
    return command


def call(path, words):
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as server:
        server.connect(path)
        said = json.dumps([words, os.getcwd(), dict(os.environ), resource.getrlimit(resource.RLIMIT_AS)])
        socket.send_fds(server, [said.encode()], [0, 1, 2])
        return int(server.recv(16) or 70)


def run(words):
    """Runs a script like the interpreter: modules of PYTHONPATH are found first, and modules of the script's folder before them."""
    import runpy
    import types
    sys.modules["__main__"] = types.ModuleType("__main__")
    sys.path[:0] = filter(None, os.environ.get("PYTHONPATH", "").split(":"))
    words = [word for word in words if word != "-B"]
    if words[0] in ("-c", "-"):
        text = sys.stdin.read() if words[0] == "-" else words.pop(1)
        sys.argv = words
        sys.path.insert(0, "")
        exec(compile(text, "<string>", "exec"), sys.modules["__main__"].__dict__)  # pylint: disable=exec-used
    else:
        sys.argv = words
        sys.path.insert(0, os.path.dirname(os.path.abspath(words[0])))
        runpy.run_path(words[0], run_name="__main__")


def answer(client):
    """Answers one call in a child process, which ends here."""
    said, streams, *_ = socket.recv_fds(client, MOST, 3)
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    words, folder, environment, memory = json.loads(said)
    resource.setrlimit(resource.RLIMIT_AS, memory)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    code = 1
    try:
        run(words)
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
        if code and not isinstance(end.code, int):
            print(end.code, file=sys.stderr)
    except BaseException:  # pylint: disable=broad-except
        sys.excepthook(*sys.exc_info())
    finish()
    client.send(str(code).encode())
    os._exit(0)  # the exit handlers of the server must not run in the child


def finish():
    """Ends a script like the interpreter: objects of the script are deleted, and so its files are closed."""
    import atexit
    import gc
    sys.modules["__main__"].__dict__.clear()
    gc.collect()
    atexit._run_exitfuncs()  # pylint: disable=protected-access
    sys.stdout.flush()
    sys.stderr.flush()


def load():
    """Imports the libraries and draws a picture, because matplotlib reads fonts with the first one."""
    try:
        import h5py  # noqa: F401
        import matplotlib.ticker  # noqa: F401
        import scipy.ndimage  # noqa: F401
        import scipy.optimize  # noqa: F401
        import xarray  # noqa: F401
        from matplotlib.figure import Figure
    except ImportError as error:
        print(error)
        sys.exit(77)
    import io
    figure = Figure()
    figure.subplots().set_title("$x^2$")
    figure.savefig(io.BytesIO(), format="svg")


def serve(path):
    import gc
    import signal
    parent = os.getppid()
    load()
    del sys.path[0]  # the folder of this file
    sys.dont_write_bytecode, sys.pycache_prefix = False, path + ".cache"  # only the first call compiles the package
    gc.freeze()
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    listener.bind(path + ".new")
    listener.listen()
    os.rename(path + ".new", path)
    listener.settimeout(5)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit())
    running = 0
    while os.getppid() == parent:
        while running and os.waitpid(-1, os.WNOHANG)[0]:
            running -= 1
        try:
            client, _ = listener.accept()
        except TimeoutError:
            continue
        running += 1
        if os.fork() == 0:
            signal.signal(signal.SIGTERM, signal.SIG_DFL)
            listener.close()
            client.setblocking(True)
            answer(client)
        client.close()


if __name__ == "__main__":
    if sys.argv[1] == "serve":
        serve(sys.argv[2])
    else:
        sys.exit(call(sys.argv[2], sys.argv[3:]))
