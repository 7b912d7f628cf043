"""Sign-in by SAML: a service, the bridge of deploy/satosa and an identity provider, with answers that the bridge must refuse.

    saml.py PROGRAM     the service to check
"""

import html
import re
import sys
import urllib.parse

from bridge import Bridge, start_service
from service import Browser, expect, find_field, free_address

# By answer of the identity provider: what the bridge writes to its log.
REFUSED = {
    "other_key": "Failed to verify signature",
    "unsigned": "Signature missing for response",
    "other_audience": "AudienceRestrictions conditions not satisfied",
    "expired": "Can't use response, too old",
}


def ask_provider(browser, name, answer=""):
    """Goes from the sign-in page to the identity provider; returns where its answer is to be posted, and the form."""
    page = browser.leave_for_provider()
    asked = {field: find_field(page.text, field) for field in ["SAMLRequest", "RelayState"]}
    expect("rsa-sha256" in page.url, f"the bridge's request is not signed by SHA-256: {page.url}")
    address = urllib.parse.urljoin(page.url, "/sign-in")
    answered = browser.open(address, asked | {"name": name, "answer": answer}).text
    target = html.unescape(re.search(r'action="([^"]+)"', answered).group(1))
    return target, {field: find_field(answered, field) for field in ["SAMLResponse", "RelayState"]}


def sign_in(service, name, answer=""):
    browser = Browser(service.url)
    return browser, browser.open(*ask_provider(browser, name, answer))


def check_accounts(service):
    """Signs a student and a teacher in."""
    for name, role in [("ada", "trainee"), ("teacher", "instructor")]:
        browser, page = sign_in(service, name)
        expect(browser.is_signed_in(), f"{name} is not signed in: {page.status} {page.url}")
        expect((name.capitalize(), role) in service.people(), f"{name} is {role}: {service.people()}")
        print(f"signed in: {name}, {role}")


def check_refused(service, bridge, what, browser, page, reason):
    """Asserts that the bridge has refused an answer for a reason, and that no user is signed in."""
    shown = re.search(r'role="alert">([^<]*)<', page.text)
    shown = shown.group(1) if shown else page.text[:80]
    expect(reason in bridge.log(), f"{what}: the bridge's log has no {reason!r}")
    expect(page.status >= 400, f"{what}: status {page.status} at {page.url}")
    expect(not browser.is_signed_in(), f"{what}: a user is signed in")
    where = "the service" if page.url.startswith(service.url) else "the bridge"
    print(f"refused: {what}; {where} answers {page.status}: {shown}")
    return where


def check_forgeries(service, bridge):
    for number, (answer, reason) in enumerate(REFUSED.items(), 1):
        browser, page = sign_in(service, "mallory", answer)
        check_refused(service, bridge, answer, browser, page, reason)
        expect(service.refusals() == number, f"{answer}: {service.refusals()} rows in the audit log")


def check_replay(service, bridge):
    """Posts an answer again, in the same browser and in another one that has begun to sign in."""
    browser = Browser(service.url)
    target, form = ask_provider(browser, "ada")
    browser.open(target, form)
    expect(browser.is_signed_in(), "ada is not signed in")
    other = Browser(service.url)
    page = other.open(target, form)
    check_refused(service, bridge, "replayed in another browser", other, page, "without a SATOSA session cookie")
    begun = Browser(service.url)
    _, own = ask_provider(begun, "mallory")
    page = begun.open(target, form | {"RelayState": own["RelayState"]})
    check_refused(service, bridge, "replayed in a sign-in of another user", begun, page, "Unsolicited response")


def main():
    address = free_address()
    bridge = Bridge(f"http://{address}/sign-in/callback")
    service = start_service(sys.argv[1], bridge, address)
    check_accounts(service)
    known = service.people()
    check_forgeries(service, bridge)
    check_replay(service, bridge)
    bridge.restart()
    check_accounts(service)
    expect(service.people() == known, f"accounts {known} became {service.people()}")
    identities = service.rows("SELECT count(*) FROM identities")[0][0]
    expect(identities == 2, f"{identities} identities of two people")
    print("the same people after a restart of the bridge")


if __name__ == "__main__":
    main()
