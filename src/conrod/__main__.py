"""`python -m conrod`, and the command `conrod`."""

import signal


def main() -> None:
    """Run the command line; Ctrl-C while it is still being loaded ends it without a word, as it ends any program."""
    answer = signal.signal(signal.SIGINT, signal.SIG_DFL)
    from conrod.cli import main as run

    signal.signal(signal.SIGINT, answer)
    run()


if __name__ == "__main__":
    main()
