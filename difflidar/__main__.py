"""`python -m difflidar`."""

from difflidar.cli import main

main()
