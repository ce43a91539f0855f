"""`python -m conrod`."""

from conrod.cli import main

if __name__ == "__main__":
    main()
