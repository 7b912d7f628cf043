"""Two programs of others verify badges: those of a running service, and a thousand with hostile names. Each changed byte must be refused.

    badges.py PROGRAM FOLDER BADGES     the service, the folder of npm's packages, and the badges written by a test of `web-admin/model`
"""

import contextlib
import io
import json
import random
import re
import subprocess
import sys
import tempfile
import urllib.parse
from collections import Counter
from pathlib import Path

from openbadgeslib import baking
from openbadgeslib.errors import LibOpenBadgesException
from openbadgeslib.ob3 import OB3LdpVerifier, decode_encoded_list, resolve_verification_method, set_indices, verify_data_integrity_proof
from openbadgeslib.ob3.contexts import bundled_contexts

from service import Browser, Demonstration, expect

# The demonstration has one trainee who has mastered a course by supervised attempts.
TRAINEE = "hana.suzuki@demo.example"
HEAD = "ingrid.halvorsen@demo.example"
GENUINE, REVOKED, REFUSED = "genuine", "revoked", "refused"
# Changed bytes of each generated badge; of one of the service, every byte is changed.
CHANGES = 10


class Judge:
    """openbadgeslib, and the documents that it would fetch."""

    def __init__(self, documents):
        self.documents = documents
        did = next(address for address in documents if address.startswith("did:"))
        self.verifier = OB3LdpVerifier.for_issuer_did(did)

    def download(self, address):
        """Returns a document as if it were fetched; that of an issuer stands at the address that follows from its name."""
        for known, document in self.documents.items():
            host = urllib.parse.unquote(known.removeprefix("did:web:"))
            if address in (known, f"https://{host}/.well-known/did.json"):
                return json.dumps(document).encode()
        raise OSError(f"{address} is not known")

    def judge(self, text):
        """Returns the verdict of openbadgeslib on a badge."""
        # It prints nothing of use about a refusal.
        with contextlib.redirect_stderr(io.StringIO()):
            try:
                badge = self.verifier.verify(text, download=self.download)
            except LibOpenBadgesException:
                return REFUSED
            try:
                # It verifies the proofs of lists in JWT only, so that of ours is verified apart: `check_list`.
                self.verifier.verify(text, check_status=True, verify_status_list=False, download=self.download)
            except LibOpenBadgesException as why:
                expect("status 'revocation' is set" in str(why), f"another reason than revocation: {why}")
                return REVOKED
        return GENUINE if badge.credential_status else REFUSED

    def check_list(self, published):
        """Verifies the proof of a status list; returns the revoked indices."""
        method = published["proof"]["verificationMethod"]
        expect(method.startswith(published["issuer"] + "#"), "the list is signed by its issuer")
        verify_data_integrity_proof(published, resolve_verification_method(method, download=self.download))
        return set_indices(decode_encoded_list(published["credentialSubject"]["encodedList"]))


def change(text, place, numbers):
    """Returns a text with another character at a place."""
    other = numbers.choice([c for c in '0aAz"{}[],: \\é' if c != text[place]])
    return text[:place] + other + text[place + 1 :]


def try_both(name, documents, cases, folder):
    """Asserts that both programs judge each badge as expected."""
    judge = Judge(documents)
    for text, expected in cases:
        judged = judge.judge(text)
        expect(judged == expected, f"{name}: openbadgeslib: {judged} instead of {expected}: {text}")
    counts = Counter(expected for _, expected in cases)
    print(f"{name}: openbadgeslib:", dict(counts), flush=True)
    given = {
        "contexts": bundled_contexts(),
        "documents": documents,
        "cases": [{"text": text, "expected": expected} for text, expected in cases],
    }
    with tempfile.NamedTemporaryFile("w", suffix=".json", encoding="utf-8") as file:
        json.dump(given, file)
        file.flush()
        script = Path(__file__).with_suffix(".mjs")
        done = subprocess.run(["node", str(script), folder, file.name], check=False)
    expect(done.returncode == 0, f"{name}: @digitalbazaar/vc")


def try_generated(file, folder):
    """Tries badges with hostile names, and changed ones."""
    generated = json.loads(Path(file).read_text(encoding="utf-8"))
    numbers = random.Random(1)
    cases = []
    for badge in generated["badges"]:
        text = badge["text"]
        cases.append((text, REVOKED if badge["revoked"] else GENUINE))
        cases += [(change(text, numbers.randrange(len(text)), numbers), REFUSED) for _ in range(CHANGES)]
    for address, published in generated["documents"].items():
        if not address.startswith("did:"):
            Judge(generated["documents"]).check_list(published)
    try_both("generated", generated["documents"], cases, folder)


class Badges(Demonstration):
    """A running service whose demonstration has a badge."""

    def documents(self, badge):
        """Returns the published documents that a badge leads to."""
        anybody = Browser(self.url)
        did = json.loads(anybody.get("/.well-known/did.json").text)
        address = badge["credentialStatus"]["statusListCredential"]
        return {did["id"]: did, address: json.loads(anybody.get(address).text)}


def try_service(program, folder):
    """Tries the badge of a running service, before and after its holder is erased."""
    demonstration = Badges(program)
    trainee = demonstration.sign_in(TRAINEE)
    home = trainee.get("/").text
    link = re.search(r'href="(/trainees/[^"]+/badge)\.json"', home).group(1)
    text, picture = trainee.get(f"{link}.json").text, trainee.get(f"{link}.svg").text
    badge = json.loads(text)
    baked = baking.extract_svg(picture.encode(), element=baking.SVG_ELEMENT_OB3, text_fallback=True)
    documents = demonstration.documents(badge)
    numbers = random.Random(2)
    cases = [(text, GENUINE), (baked, GENUINE), *((change(text, place, numbers), REFUSED) for place in range(len(text)))]
    try_both("service", documents, cases, folder)
    index = int(badge["credentialStatus"]["statusListIndex"])
    (published,) = (document for address, document in documents.items() if not address.startswith("did:"))
    expect(index not in Judge(documents).check_list(published), "the list has a valid badge")

    head = demonstration.sign_in(HEAD)
    person = re.match(r"/trainees/([^/]+)/", link).group(1)
    erased = head.post(f"/people/{person}/erase", head.get(f"/people/{person}/erase"), confirm=TRAINEE)
    expect(erased.status == 200, f"the person is erased: {erased.status}")
    documents = demonstration.documents(badge)
    try_both("service, revoked", documents, [(text, REVOKED), (baked, REVOKED)], folder)
    (published,) = (document for address, document in documents.items() if not address.startswith("did:"))
    expect(Judge(documents).check_list(published) == {index}, "the list has the revoked badge alone")


def main():
    program, folder, badges = sys.argv[1:4]
    try_service(program, folder)
    try_generated(badges, folder)


if __name__ == "__main__":
    main()
