"""`python -m fea` is `fea`."""

from fea.cli import main

if __name__ == "__main__":
    main()
