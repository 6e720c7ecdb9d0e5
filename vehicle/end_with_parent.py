"""Run a command that the kernel kills when its parent process ends:  python end_with_parent.py PARENT COMMAND...

A pipe from the parent tells a process of the parent's end only if it runs; one that is stopped (SIGSTOP) would stay
behind. The kernel's word (Linux: prctl) reaches it all the same. Elsewhere the command just starts.
"""

import os
import signal
import sys

PR_SET_PDEATHSIG = 1  # linux/prctl.h


def main(parent: int, command: list[str]) -> None:
    """Does not come back; raises OSError if there is no such command."""
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it ended before the kernel was asked
            os.kill(os.getpid(), signal.SIGKILL)
    os.execvp(command[0], command)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2:])
