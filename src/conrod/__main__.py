"""`python -m conrod`, and the command `conrod`."""

# What is planted in the working folder is not imported: no module but these two, which are there already.
import os
import sys


def leave_working_folder() -> None:
    """Drop the folder that `python -m` put in front of Python's own library.

    A `csv.py` beside a user's model is data to conrod. A folder that conrod itself came from stays.
    """
    home = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    try:
        folder = os.getcwd()
    except FileNotFoundError:  # it has been removed, and is not on the path
        return
    if sys.path[:1] == [folder] and folder != home and not sys.flags.safe_path:
        del sys.path[0]


def main() -> None:
    """Run the command line; Ctrl-C while it is still being loaded ends it without a word, as it ends any program."""
    import signal

    answer = signal.signal(signal.SIGINT, signal.SIG_DFL)
    from conrod.crash import run_guarded

    def run() -> None:
        from conrod.cli import main

        signal.signal(signal.SIGINT, answer)
        main()

    run_guarded(run)


if __name__ == "__main__":
    leave_working_folder()
    main()
