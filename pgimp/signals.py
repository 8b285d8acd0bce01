"""Signals that ask a run to stop are noted here until it can.

The command imports this module before anything else: a signal that arrives before its handler
is installed kills the process. So nothing but ``signal`` and ``time`` is imported here.
"""

import signal
import time
from types import FrameType

#: `time.monotonic` when this module was imported: for the command ``pgimp``, when it was started.
BEGAN = time.monotonic()

#: Signals that ask a run to stop. mpirun passes SIGUSR1 on, schedulers send it ahead of a limit.
STOPPING = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)

#: Whether the whole process is a run whose signals are noted from the start; see `install`.
installed = False

#: The signals that arrived, each once, in order.
received: list[int] = []

#: Whether a second SIGINT arrived. Code that it interrupts, such as an import, may turn the
#: KeyboardInterrupt into another error.
interrupted = False


def note(number: int, _: FrameType | None) -> None:
    """Note a signal; the handler.

    Parameters
    ----------
    number : int
        The signal.

    Raises
    ------
    KeyboardInterrupt
        At the second SIGINT, for an impatient user.
    """
    global interrupted
    if number not in received:
        received.append(number)
    elif number == signal.SIGINT:
        interrupted = True
        raise KeyboardInterrupt


def catch(number: int) -> None:
    """Note a signal from now on, without interrupting system calls.

    Parameters
    ----------
    number : int
        The signal.
    """
    signal.signal(number, note)
    signal.siginterrupt(number, False)


def install(numbers: tuple[int, ...] = STOPPING) -> None:
    """Note signals for the rest of this process.

    A SIGINT that is ignored stays so: a shell starts its background jobs like that, and Ctrl-C is
    not for them.

    Parameters
    ----------
    numbers : tuple of int
        The signals.
    """
    global installed
    for number in numbers:
        if number != signal.SIGINT or signal.getsignal(number) != signal.SIG_IGN:
            catch(number)
    installed = True


def ignore() -> None:
    """Ignore the signals that are noted from now on.

    To be called once the exit status is decided: the interpreter, when it exits, restores the usual
    effect of signals with a handler, which would replace the status.
    """
    for number in STOPPING:
        if signal.getsignal(number) is note:
            signal.signal(number, signal.SIG_IGN)
