"""Members of a course, from the learning platform of this folder: a preview of all, and their cohort once it is confirmed.

    lti_members.py PROGRAM     the service to check
"""

import re
import sys
import urllib.parse

from lti_platform import Platform, register
from lti_services import PAGE_OF_MEMBERS
from service import Browser, Service, expect, find_field

PEOPLE = 450


def read_members(service, own, cohort):
    """Ties the only course to a cohort and reads its members; returns the page of the preview."""
    page = service.head.get(own)
    course = re.search(rf'action="({own}/courses/[0-9a-f-]+)"', page.text).group(1)
    return service.head.post(course, page, cohort=cohort, remove_missing="true", read="true")


def make_cohort(service):
    """Makes a cohort; returns its id."""
    page = service.head.post("/cohorts", service.head.get("/cohorts"), name="First year")
    return urllib.parse.urlsplit(page.url).path.split("/")[2]


def confirm(service, preview):
    """Confirms a preview; returns the page after it."""
    path = urllib.parse.urlsplit(preview.url).path
    return service.head.post(path, preview, digest=find_field(preview.text, "digest"))


def count_members(service):
    return service.rows("SELECT count(*) FROM cohort_members")[0][0]


def check_first_reading(service, platform, own, cohort):
    """Everybody is new but the teacher, who does not become a trainee, and those who have left."""
    preview = read_members(service, own, cohort)
    expect("/people/rosters/" in preview.url, f"{preview.status} {preview.url} {preview.text}")
    pages = len(platform.received("members"))
    expect(pages == PEOPLE / PAGE_OF_MEMBERS, f"{pages} pages of members")
    expect(count_members(service) == 0, "something changed before it was confirmed")
    done = confirm(service, preview)
    active = [member for member in platform.members[1:] if member["status"] == "Active"]
    expect(done.status == 200 and count_members(service) == len(active), f"{count_members(service)} of {len(active)}: {done.url}")
    print(f"{len(active)} of {PEOPLE} members are in the cohort, read from {pages} pages")


def check_departure(service, platform, own, cohort):
    """Two members who have left, one of them without a trace, are proposed to leave the cohort."""
    before = count_members(service)
    platform.members[3]["status"] = "Inactive"
    del platform.members[5]
    preview = read_members(service, own, cohort)
    expect(count_members(service) == before, "something changed before it was confirmed")
    confirm(service, preview)
    expect(count_members(service) == before - 2, f"{count_members(service)} after two of {before} have left")
    print("two who have left the course left the cohort, once this was confirmed")


def main():
    platform = Platform(people=PEOPLE, own_query={"type": "lti"})
    service = Service(sys.argv[1], options=["--allow-plain-http", platform.address, "--allow-private-addresses"])
    client = register(service, platform)
    launched = Browser(service.url).launch(platform.begin_launch(client, "user-1", next(iter(platform.links.values()))))
    expect(launched.status == 200, f"{launched.status} {launched.url}")
    own = service.find_platform()
    cohort = make_cohort(service)
    check_first_reading(service, platform, own, cohort)
    check_departure(service, platform, own, cohort)
    again = read_members(service, own, cohort)
    expect("Nothing to import" in again.text, f"{again.status} {again.text}")


if __name__ == "__main__":
    main()
