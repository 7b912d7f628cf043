"""Dynamic registration: an administrator registers the service at the learning platform of this folder, and a user launches.

    lti_register.py PROGRAM     the service to check
"""

import re
import sys

from lti_platform import Platform
from service import Browser, Service, expect, find_field

FIELDS = ("openid_configuration", "registration_token", "digest")


def register(service, address):
    """Opens the address of an offer and presses the only button; returns the page after it."""
    page = service.head.get(address)
    expect(page.status == 200 and 'action="/admin/platforms/register"' in page.text, f"{page.status} {page.text}")
    return service.head.post("/admin/platforms/register", page, **{name: find_field(page.text, name) for name in FIELDS})


def main():
    platform = Platform()
    service = Service(sys.argv[1], options=["--allow-plain-http", platform.address, "--allow-private-addresses"])
    address = platform.offer_registration(f"{service.url}/lti/register")
    stranger = Browser(service.url).get(address)
    expect("/admin/platforms/register" not in stranger.text, "a stranger may register")
    expect(not platform.received("register"), "registered before it was confirmed")
    done = register(service, address)
    sent = platform.received("register")
    expect([entry.status for entry in sent] == [201], f"{done.status} {done.text} {sent}")
    print(f"registered: {sent[0].body}")
    again = register(service, address)
    expect([entry.status for entry in platform.received("register")[1:]] in ([], [401]), f"registered twice: {again.status}")
    client = next(iter(platform.clients.values()))
    link = platform.add_link("Home", {})
    # New accounts are not created until an administrator allows it: the user has to join an account.
    page = Browser(service.url).launch(platform.begin_launch(client, "user-1", link))
    if found := re.search(r"code: (\w+)<", page.text):
        print(f"the first launch is refused: {found.group(1)}")
        own = service.find_platform()
        service.admit(own, client.get_registration().get_deployment_id())
        page = Browser(service.url).launch(platform.begin_launch(client, "user-1", link))
    expect(page.status == 200, f"{page.status} {page.url}")
    print(f"launched: {page.url.removeprefix(service.url)}")


if __name__ == "__main__":
    main()
