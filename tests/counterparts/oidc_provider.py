"""Sign-in by oidc-provider (a certified OpenID provider for node).

    oidc_provider.py PROGRAM FOLDER     the service to check, and the folder with oidc-provider in its node_modules
"""

import html
import re
import sys
from pathlib import Path

from service import Browser, Service, expect, find_field, free_address, start, wait_for

SCRIPT = Path(__file__).with_name("oidc-provider.mjs")
FORM = {
    "match_claim": "matriculation",
    "role_claim": "affiliation",
    "role_map": "staff@uni.example = instructor\nstudent@uni.example = trainee",
}


def sign_in(browser, name):
    """Goes from the sign-in page of the service through the forms of the provider and back."""
    page = browser.leave_for_provider()
    for fields in [{"prompt": "login", "login": name, "password": "any"}, {"prompt": "consent"}]:
        expect(find_field(page.text, "prompt") == fields["prompt"], f"the provider asks otherwise: {page.text}")
        page = browser.open(html.unescape(re.search(r'action="([^"]+)"', page.text).group(1)), fields)
    return page


def start_both(program, folder):
    """Starts a service and a provider, and adds the provider to the service; returns the service and the provider's address."""
    provider, address = free_address(), free_address()
    service = Service(program, address, options=["--allow-plain-http", provider, "--allow-private-addresses"])
    start(["node", SCRIPT, folder, provider, f"{service.url}/sign-in/callback"], service.folder)
    wait_for(f"http://{provider}")
    service.add_provider(f"http://{provider}", "a-secret-for-a-trial", **FORM)
    return service, provider


def main():
    service, provider = start_both(sys.argv[1], sys.argv[2])
    for name, role in [("ada", "trainee"), ("teacher", "instructor"), ("ada", "trainee")]:
        browser = Browser(service.url)
        page = sign_in(browser, name)
        expect(browser.is_signed_in(), f"{name} is not signed in: {page.status} {page.url}")
        expect((name.capitalize(), role) in service.people(), f"people: {service.people()}")
        print(f"signed in: {name}, {role}")
    expect(len(service.people()) == 3, f"people: {service.people()}")
    # A second registration without a secret; its button is the first by name.
    service.add_provider(f"http://{provider}", "", name="By key", client_id="stylet-by-key", authentication="key", **FORM)
    browser = Browser(service.url)
    page = sign_in(browser, "ada")
    expect(browser.is_signed_in(), f"ada is not signed in by the key: {page.status} {page.url}")
    expect(len(service.people()) == 3, f"people: {service.people()}")
    print("signed in by the key: ada")


if __name__ == "__main__":
    main()
