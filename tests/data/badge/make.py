"""Writes the badge and the status list of this folder with openbadgeslib and PyLD, for the tests of `web-admin/model`:

    pip install 'openbadgeslib[ldp]==4.6.3'
    make.py

`escapes.nq` was written by rdf-canonize 5.0.0, because PyLD does not escape every control character: see `escapes.mjs`.
"""

import json
from datetime import datetime, timezone
from pathlib import Path

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from openbadgeslib.ob3 import add_data_integrity_proof, encode_bitstring
from openbadgeslib.ob3.contexts import document_loader
from pyld import jsonld

FOLDER = Path(__file__).parent
KEY = Ed25519PrivateKey.from_private_bytes(bytes([7] * 32))
URL = "https://stylet.example:8443"
DID = "did:web:stylet.example%3A8443"
METHOD = f"{DID}#z6MkvDqGT54cXesYGvABpF1UapVNwjCqRcafi4Px6Thv5T3Z"
NOW = datetime(2026, 5, 20, 9, tzinfo=timezone.utc)
LIST = f"{URL}/badges/status/2"
INDEX = 131071


def make_badge(statement):
    """Returns the credential for a statement, without a proof."""
    name = statement["course"]
    exercises = "; ".join(title for title, _ in statement["exercises"])
    narrative = f"An exercise is {statement['rule']}. Attempts counted: {statement['attempts']}. {statement['scope']}"
    return {
        "@context": ["https://www.w3.org/ns/credentials/v2", "https://purl.imsglobal.org/spec/ob/v3p0/context-3.0.3.json"],
        "id": "urn:uuid:00000000-0000-0000-0000-000000000017",
        "type": ["VerifiableCredential", "OpenBadgeCredential"],
        "name": name,
        "issuer": {"id": DID, "type": ["Profile"], "name": statement["school"], "url": URL},
        "validFrom": "2026-05-02T11:30:00Z",
        "credentialSubject": {
            "id": "urn:uuid:00000000-0000-0000-0000-000000000ada",
            "type": ["AchievementSubject"],
            "achievement": {
                "id": f"{URL}/curricula/{statement['curriculum_id']}/revisions/{statement['curriculum_sha256']}",
                "type": ["Achievement"],
                "achievementType": "Course",
                "name": name,
                "description": f"All exercises mastered in the simulator: {exercises}.",
                "criteria": {"narrative": narrative},
            },
        },
        "credentialStatus": {
            "id": f"{LIST}#{INDEX}",
            "type": "BitstringStatusListEntry",
            "statusPurpose": "revocation",
            "statusListIndex": str(INDEX),
            "statusListCredential": LIST,
        },
    }


def make_list():
    """Returns a list with three revoked badges, without a proof."""
    return {
        "@context": ["https://www.w3.org/ns/credentials/v2"],
        "id": LIST,
        "type": ["VerifiableCredential", "BitstringStatusListCredential"],
        "issuer": DID,
        "validFrom": "2026-05-20T09:00:00Z",
        "validUntil": "2026-05-21T09:00:00Z",
        "credentialSubject": {
            "id": f"{LIST}#list",
            "type": "BitstringStatusList",
            "statusPurpose": "revocation",
            "encodedList": encode_bitstring([0, 17, INDEX]),
        },
    }


def write(name, credential):
    """Writes a credential with its proof, and its canonical N-Quads. Returns those of the proof's options."""
    pem = KEY.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
    signed = add_data_integrity_proof(credential, pem, METHOD, created=NOW)
    text = json.dumps(signed, indent=2, ensure_ascii=False, sort_keys=True)
    (FOLDER / f"{name}.json").write_text(text + "\n", encoding="utf-8")
    (FOLDER / f"{name}.nq").write_text(canonize(credential), encoding="utf-8")
    options = {key: value for key, value in signed["proof"].items() if key != "proofValue"}
    return canonize(options | {"@context": credential["@context"]})


def canonize(document):
    """Returns the canonical N-Quads of a document."""
    options = {"algorithm": "URDNA2015", "format": "application/n-quads", "documentLoader": document_loader()}
    return jsonld.normalize(document, options)


def main():
    statement = json.loads((FOLDER / "input.json").read_text(encoding="utf-8"))["statement"]
    options = write("badge", make_badge(statement))
    (FOLDER / "options.nq").write_text(options, encoding="utf-8")
    write("list", make_list())


if __name__ == "__main__":
    main()
