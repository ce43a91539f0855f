"""`python -m conrod`, and the command `conrod`."""

import signal
import sys
from threading import Timer, main_thread


def main() -> None:
    """Run the command line; Ctrl-C while it is still being loaded ends it without a word, as it ends any program."""
    answer = signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.unraisablehook = _interrupt_again
    from conrod.cli import main as run

    signal.signal(signal.SIGINT, answer)
    run()


def _interrupt_again(ignored: "sys.UnraisableHookArgs") -> None:
    """Repeat a Ctrl-C that Python has dropped, with a traceback, in a callback of an import or a finalizer."""
    if ignored.exc_type is KeyboardInterrupt:
        Timer(0.01, signal.pthread_kill, (main_thread().ident, signal.SIGINT)).start()
    else:
        sys.__unraisablehook__(ignored)


if __name__ == "__main__":
    main()
