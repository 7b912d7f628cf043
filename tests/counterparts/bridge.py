"""The bridge of deploy/satosa, a SAML identity provider and a service, on the loopback interface, until Ctrl-C.

    bridge.py PROGRAM PORT     the service at PORT, the bridge and the identity provider at the next two ports

deploy/bridge installs the packages and calls this.
"""

import signal
import subprocess
import sys
import tempfile
import urllib.request
from pathlib import Path

from service import HEAD, PASSWORD, Service, free_address, start, stop, wait_for

HERE = Path(__file__).resolve().parent
SECRET = "a-secret-for-a-trial"
FORM = {
    "scopes": "openid profile email affiliation",
    "role_claim": "eduperson_scoped_affiliation",
    "role_map": "staff@uni.example = instructor\nstudent@uni.example = trainee",
}
# pyop requires an issuer with https, and the service accepts no certificate of our own: here the bridge is reached without TLS.
APPLICATION = """
from oic.oic.message import Message, ProviderConfigurationResponse
ProviderConfigurationResponse.verify = Message.verify
from satosa.wsgi import app
"""


class Bridge:
    """The bridge and its identity provider, with the files of deploy/satosa in a temporary folder."""

    def __init__(self, callback, address=None, idp_address=None):
        self.address, self.idp_address = address or free_address(), idp_address or free_address()
        self.url = f"http://{self.address}"
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(self.temporary.name)
        self.configure(callback)
        self.call_idp("describe").wait()
        self.start()
        with urllib.request.urlopen(f"{self.url}/Saml2/proxy_saml2_backend.xml", timeout=30) as metadata:
            (self.folder / "sp.xml").write_bytes(metadata.read())
        self.call_idp("serve")
        wait_for(f"http://{self.idp_address}/")

    def configure(self, callback):
        """Copies deploy/satosa, replaces what docs/sign-in.md asks to replace, and makes the keys."""
        for file in (HERE.parents[1] / "deploy/satosa").iterdir():
            text = file.read_text()
            for old, new in [
                ("https://bridge.example.org", self.url),
                ("https://training.example.org/sign-in/callback", callback),
                ("REPLACE-BY-A-LONG-RANDOM-TEXT-AND-KEEP-IT", "a-salt-for-a-trial"),
                ("REPLACE-BY-A-LONG-RANDOM-TEXT", SECRET),
            ]:
                text = text.replace(old, new)
            (self.folder / file.name).write_text(text)
        with open(self.folder / "proxy_conf.yaml", "a") as settings:
            settings.write("COOKIE_SECURE: false\nCOOKIE_SAMESITE: Lax\n")
        (self.folder / "plain_bridge.py").write_text(APPLICATION)
        certificate = ["req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "30", "-subj", "/CN=127.0.0.1"]
        for command in [[*certificate, "-keyout", "saml.key", "-out", "saml.crt"], ["genrsa", "-out", "oidc.key", "2048"]]:
            subprocess.run(["openssl", *command], cwd=self.folder, check=True, capture_output=True)

    def call_idp(self, action):
        """Starts an action of the identity provider."""
        return start([sys.executable, HERE / "saml_idp.py", action, self.folder, self.idp_address], self.folder)

    def start(self):
        options = ["--bind", self.address, "--workers", "1", "--threads", "4", "--no-control-socket", "--chdir", self.folder]
        command = [sys.executable, "-m", "gunicorn", *options, "plain_bridge:app"]
        self.process = start(command, self.folder, SATOSA_STATE_ENCRYPTION_KEY="0123456789abcdef" * 2)
        wait_for(f"{self.url}/.well-known/openid-configuration")

    def restart(self):
        stop(self.process)
        self.start()

    def log(self):
        return (self.folder / "log").read_text()


def start_service(program, bridge, address):
    """Starts a service that may connect to the bridge, and adds the bridge as its provider."""
    options = ["--allow-plain-http", bridge.address, "--allow-private-addresses"]
    service = Service(program, address, options=options)
    service.add_provider(bridge.url, SECRET, **FORM)
    return service


def main():
    program, port = sys.argv[1], int(sys.argv[2])
    address, public, idp = f"127.0.0.1:{port}", f"127.0.0.1:{port + 1}", f"127.0.0.1:{port + 2}"
    bridge = Bridge(f"http://{address}/sign-in/callback", public, idp)
    service = start_service(program, bridge, address)
    print(f"Open                  {service.url}/login")
    print('At the provider       any name; "teacher…" is staff. The list of answers has those that the bridge must refuse')
    print(f"Administrator here    {HEAD}, password: {PASSWORD}")
    print(f"Log of the bridge     {bridge.folder}/log")
    print("Ctrl-C stops everything and removes what it has stored.", flush=True)
    try:
        signal.pause()
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    main()
