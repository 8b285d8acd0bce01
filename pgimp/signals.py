"""Signals that ask a run to stop are noted here until it can.

The command imports this module before anything else: a signal that comes before its handler
stands kills the process. So nothing but ``signal`` and ``time`` is imported here.
"""

import signal
import time
from types import FrameType

#: `time.monotonic` when this module was imported: for the command ``pgimp``, when it was started.
BEGAN = time.monotonic()

#: What asks a run to stop. mpirun passes SIGUSR1 on, schedulers send it ahead of a limit.
STOPPING = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)

#: Whether the whole process is a run whose signals are noted from the start; see `install`.
installed = False

#: The signals that came, each once, in order.
received: list[int] = []

#: Whether a second SIGINT came. What it meets, such as a module that is being imported, may make
#: another error of the KeyboardInterrupt.
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
        At the second SIGINT, for who cannot wait.
    """
    global interrupted
    if number not in received:
        received.append(number)
    elif number == signal.SIGINT:
        interrupted = True
        raise KeyboardInterrupt


def catch(number: int) -> None:
    """Have a signal noted from now on, without breaking off the system calls that it meets.

    Parameters
    ----------
    number : int
        The signal.
    """
    signal.signal(number, note)
    signal.siginterrupt(number, False)


def install(numbers: tuple[int, ...] = STOPPING) -> None:
    """Have signals noted for the rest of this process.

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
    """Let the signals that are noted have no effect any more.

    For the time when the exit status stands: the interpreter, when it leaves, gives the signals
    that have a handler their usual effect again, which would replace the status.
    """
    for number in STOPPING:
        if signal.getsignal(number) is note:
            signal.signal(number, signal.SIG_IGN)
