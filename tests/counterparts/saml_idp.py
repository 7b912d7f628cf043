"""A SAML identity provider (pysaml2) with a form: every name signs in, and names that begin with "teacher" are staff.

    saml_idp.py describe FOLDER ADDRESS    makes the keys and FOLDER/idp.xml, the metadata for the bridge
    saml_idp.py serve FOLDER ADDRESS       serves at ADDRESS (HOST:PORT); FOLDER/sp.xml is the metadata of the bridge

The form also offers answers that a bridge must refuse.
"""

import copy
import html
import logging
import re
import subprocess
import sys
import urllib.parse
from datetime import datetime, timedelta
from pathlib import Path
from wsgiref.simple_server import WSGIRequestHandler, make_server

from saml2 import BINDING_HTTP_POST, BINDING_HTTP_REDIRECT, class_name
from saml2.authn_context import PASSWORDPROTECTEDTRANSPORT
from saml2.config import IdPConfig
from saml2.metadata import create_metadata_string
from saml2.saml import NAME_FORMAT_URI, NAMEID_FORMAT_TRANSIENT
from saml2.samlp import response_from_string
from saml2.server import Server
from saml2.sigver import pre_signature_part
from saml2.xmldsig import DIGEST_SHA256, SIG_RSA_SHA256

ANSWERS = {
    "": "a correct answer",
    "other_key": "signed by a key that is not in the metadata",
    "unsigned": "without signatures",
    "other_audience": "for another service provider",
    "expired": "expired five minutes ago",
}

TIME = r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ"
# A second service provider, which differs from the bridge in its name only.
ELSEWHERE = "https://elsewhere.example.org/metadata"

PAGE = """<!doctype html><html lang="en"><meta charset="utf-8"><title>{title}</title><h1>{title}</h1>
<form method="post" action="{action}">{fields}<p><button>Continue</button></p></form></html>"""


def make_config(folder, address, key="idp"):
    """Returns the configuration, with the key by which answers are signed."""
    settings = {
        "entityid": f"http://{address}/metadata",
        "service": {
            "idp": {
                "endpoints": {"single_sign_on_service": [(f"http://{address}/sign-in", BINDING_HTTP_REDIRECT)]},
                "policy": {
                    "default": {
                        "lifetime": {"minutes": 5},
                        "attribute_restrictions": None,
                        "name_form": NAME_FORMAT_URI,
                    },
                },
                "name_id_format": [NAMEID_FORMAT_TRANSIENT],
            },
        },
        "key_file": str(folder / f"{key}.key"),
        "cert_file": str(folder / f"{key}.crt"),
        "signing_algorithm": SIG_RSA_SHA256,
        "digest_algorithm": DIGEST_SHA256,
    }
    if (folder / "sp.xml").exists():
        settings["metadata"] = {"local": [str(folder / "sp.xml"), str(folder / "elsewhere.xml")]}
    return IdPConfig().load(copy.deepcopy(settings))


def describe(folder, address):
    for key in ["idp", "intruder"]:
        command = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "30", "-subj", f"/CN={key}"]
        files = ["-keyout", folder / f"{key}.key", "-out", folder / f"{key}.crt"]
        subprocess.run([*command, *files], check=True, capture_output=True)
    (folder / "idp.xml").write_bytes(create_metadata_string(None, make_config(folder, address)))


def attributes_of(name):
    affiliation = "staff" if name.startswith("teacher") else "student"
    return {
        "pairwise-id": f"{name.encode().hex()}@uni.example",
        "displayName": name.capitalize(),
        "mail": f"{name}@uni.example",
        "eduPersonScopedAffiliation": f"{affiliation}@uni.example",
    }


def subtract_ten_minutes(found):
    return (datetime.fromisoformat(found[0]) - timedelta(minutes=10)).strftime("%Y-%m-%dT%H:%M:%SZ")


def sign(server, message):
    """Signs the assertion and the response around it."""
    response = response_from_string(message)
    [assertion] = response.assertion
    algorithms = {"sign_alg": SIG_RSA_SHA256, "digest_alg": DIGEST_SHA256}
    assertion.signature = pre_signature_part(assertion.id, server.sec.my_cert, **algorithms)
    return server.sign(response, to_sign=[(class_name(assertion), assertion.id)])


class Provider:
    """The identity provider as a WSGI application."""

    def __init__(self, folder, address):
        metadata = (folder / "sp.xml").read_text()
        (folder / "elsewhere.xml").write_text(re.sub('entityID="[^"]*"', f'entityID="{ELSEWHERE}"', metadata))
        self.server = Server(config=make_config(folder, address))
        self.intruder = Server(config=make_config(folder, address, key="intruder"))

    def ask_name(self, fields):
        """Returns the form."""
        kept = "".join(hidden(name, fields[name]) for name in ["SAMLRequest", "RelayState"])
        options = "".join(f'<option value="{value}">{text}</option>' for value, text in ANSWERS.items())
        asked = f'<p>Name <input name="name" autofocus required></p><p>Answer <select name="answer">{options}</select></p>'
        return PAGE.format(title="University sign-in", action="/sign-in", fields=kept + asked)

    def answer_request(self, fields):
        """Returns a page that takes the signed answer to the bridge."""
        answer = fields.get("answer", "")
        request = self.server.parse_authn_request(fields["SAMLRequest"], BINDING_HTTP_REDIRECT).message
        arguments = self.server.response_args(request, [BINDING_HTTP_POST])
        if answer == "other_audience":
            arguments["sp_entity_id"] = ELSEWHERE
        response = self.server.create_authn_response(
            attributes_of(fields["name"]),
            userid=fields["name"],
            authn={"class_ref": PASSWORDPROTECTEDTRANSPORT},
            **{name: arguments[name] for name in ["in_response_to", "destination", "sp_entity_id", "name_id_policy"]},
        )
        message = str(response)
        if answer == "expired":
            # An answer is valid for five minutes.
            message = re.sub(TIME, subtract_ten_minutes, message)
        if answer != "unsigned":
            message = sign(self.intruder if answer == "other_key" else self.server, message)
        form = self.server.apply_binding(
            BINDING_HTTP_POST, message, arguments["destination"], fields["RelayState"], response=True
        )
        return form["data"]

    def __call__(self, environ, start):
        text = environ["QUERY_STRING"]
        if environ["REQUEST_METHOD"] == "POST":
            text = environ["wsgi.input"].read(int(environ["CONTENT_LENGTH"])).decode()
        fields = dict(urllib.parse.parse_qsl(text, keep_blank_values=True))
        if environ["PATH_INFO"] != "/sign-in" or "SAMLRequest" not in fields:
            start("404 Not Found", [("Content-Type", "text/plain")])
            return [b"start at the service\n"]
        page = self.answer_request(fields) if "name" in fields else self.ask_name(fields)
        start("200 OK", [("Content-Type", "text/html; charset=utf-8")])
        return [page.encode()]


def hidden(name, value):
    return f'<input type="hidden" name="{name}" value="{html.escape(value)}">'


class QuietHandler(WSGIRequestHandler):
    def log_message(self, *_):
        pass


def main():
    action, folder, address = sys.argv[1], Path(sys.argv[2]), sys.argv[3]
    if action == "describe":
        describe(folder, address)
        return
    logging.basicConfig(level=logging.ERROR)
    host, port = address.split(":")
    make_server(host, int(port), Provider(folder, address), handler_class=QuietHandler).serve_forever()


if __name__ == "__main__":
    main()
