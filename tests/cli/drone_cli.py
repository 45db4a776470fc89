"""`python -m tests.cli.drone_cli`: drone-cli in a process of its own."""

from cli.main import main

if __name__ == "__main__":
    main()
