"""Runs a client of SCIM 2.0 with a service of its own, in whose environment are STYLET_URL and STYLET_TOKEN.

    with_directory.py PROGRAM COMMAND…     the service, and the client
"""

import os
import subprocess
import sys

from service import Service


def main():
    service = Service(sys.argv[1])
    environment = os.environ | {"STYLET_URL": service.url, "STYLET_TOKEN": service.make_token()}
    sys.exit(subprocess.run(sys.argv[2:], env=environment, check=False).returncode)


if __name__ == "__main__":
    main()
