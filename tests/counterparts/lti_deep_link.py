"""Deep linking: a teacher chooses content of the service for a course of the learning platform of this folder, and trainees open it.

    lti_deep_link.py PROGRAM     the service to check
"""

import re
import sys
import urllib.parse

from attempts import publish_exercise, read_recordings
from lti_platform import Platform, register
from service import Browser, Service, expect, find_field

TEACHER = "user-0"


def make_teacher(service, platform, client):
    """Launches the teacher of the course, whose account is a trainee's until an administrator changes it."""
    home = next(iter(platform.links.values()))
    page = Browser(service.url).launch(platform.begin_launch(client, TEACHER, home))
    expect(page.status == 200, f"{page.status} {page.url}")
    refused = Browser(service.url).launch(platform.begin_launch(client, TEACHER))
    expect(refused.status == 403, f"a trainee chooses: {refused.status} {refused.url}")
    own = re.search(r'href="(/people/[0-9a-f-]{36})">Name 0<', service.head.get("/people").text).group(1)
    form = {"name": "Name 0", "email": "user-0@uni.example", "role": "instructor"}
    changed = service.head.post(f"{own}/change", service.head.get(own), **form)
    expect(changed.status == 200, f"{changed.status} {changed.text}")


def choose(service, platform, client, pick):
    """Chooses content that `pick` returns of all that is shown; returns the chosen content and the page at the platform."""
    browser = Browser(service.url)
    page = browser.launch(platform.begin_launch(client, TEACHER))
    expect(page.status == 200 and "/lti/deep-link/" in page.url, f"{page.status} {page.url}")
    chosen = pick(re.findall(r'name="content" value="([^"]*)"', page.text))
    form = [("csrf", find_field(page.text, "csrf")), *(("content", one) for one in chosen)]
    answer = browser.open(urllib.parse.urlsplit(page.url).path, form)
    expect(answer.status == 200 and f'action="{platform.url}/deep-link-return"' in answer.text, f"{answer.status} {answer.text}")
    signed = {"JWT": find_field(answer.text, "JWT")}
    return chosen, browser.open(f"{platform.url}/deep-link-return", signed), signed


def main():
    platform = Platform()
    service = Service(sys.argv[1], options=["--allow-plain-http", platform.address, "--allow-private-addresses"])
    pages = [publish_exercise(service, tape) for tape in read_recordings()]
    client = register(service, platform)
    make_teacher(service, platform, client)
    before = len(platform.links)
    _, added, _ = choose(service, platform, client, lambda shown: [])
    expect(added.status == 200 and len(platform.links) == before, f"nothing chosen: {added.status} {added.text}")
    chosen, added, signed = choose(service, platform, client, lambda shown: [one for one in shown if one.startswith("exercise:")])
    expect(added.status == 200 and len(chosen) == len(pages), f"{chosen}: {added.status} {added.text}")
    expect(Browser(service.url).open(f"{platform.url}/deep-link-return", signed).status == 401, "an answer twice")
    links = list(platform.links.values())[before:]
    expect({platform.book.items[link.item]["resourceId"] for link in links} == set(chosen), f"line items: {platform.book.items}")
    for number, link in enumerate(links):
        page = Browser(service.url).launch(platform.begin_launch(client, f"user-{number + 2}", link))
        expect(page.status == 200 and page.url == service.url + link.custom["stylet"], f"{page.status} {page.url}")
        expect(link.custom["stylet"] in pages, link)
        print(f"chosen and launched: {link.title}")


if __name__ == "__main__":
    main()
