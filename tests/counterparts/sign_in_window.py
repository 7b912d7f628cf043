"""Sign-in by other people's providers in Chromium: each is left for by its button, and its own pages are filled in.

    sign_in_window.py PROGRAM FOLDER [PICTURES]     the service to check, the folder with the providers, and where to save pictures
"""

import sys
from pathlib import Path

import glewlwyd
import oidc_provider
from bridge import Bridge, start_service
from chromium import Window
from service import expect, free_address


class SignIn:
    """A sign-in at a service, with a picture of each page."""

    def __init__(self, name, service):
        self.name, self.service = name, service
        self.window = Window(service.folder)
        self.pictures = 0
        self.window.open(f"{service.url}/login")
        self.save_picture()
        self.window.press('form[action^="/sign-in/"] button')
        self.window.wait(lambda: not self.window.address().startswith(service.url), "the provider")

    def fill(self, texts, button):
        """Fills fields in, by selector, and presses a button."""
        for selector, text in texts.items():
            self.window.fill(selector, text)
        self.save_picture()
        self.window.press(button)

    def end(self):
        """Ends the program unless Ada is signed in at the service."""
        self.window.wait(lambda: self.window.address() == f"{self.service.url}/", f"the home page after {self.name}")
        self.save_picture()
        self.window.open(f"{self.service.url}/account")
        expect("Ada" in self.window.text(), f"{self.name}: {self.window.text()}")
        self.window.close()
        print(f"signed in by {self.name}: Ada")

    def save_picture(self):
        if len(sys.argv) > 3:
            self.pictures += 1
            self.window.save_picture(Path(sys.argv[3]) / f"{self.name}-{self.pictures}.png")


def try_oidc_provider(program, folder):
    service, _ = oidc_provider.start_both(program, folder)
    page = SignIn("oidc-provider", service)
    page.fill({"input[name=login]": "ada", "input[name=password]": "any"}, "button[type=submit]")
    page.window.find("input[name=prompt][value=consent]")
    page.fill({}, "button[type=submit]")
    page.end()


def try_glewlwyd(program, folder):
    service, _ = glewlwyd.start_both(program, folder / "glewlwyd")
    page = SignIn("glewlwyd", service)
    page.fill({"#username": "ada", "#password": glewlwyd.PASSWORD}, "#passwordForm button[type=submit]")
    for button in ["#grant-profile", "#grant-email", ".carousel-item.active .btn-primary"]:
        page.window.press(button)
    # The page calls the provider to grant access, and then shows the next one.
    page.window.wait(lambda: not page.window.find_all("#grant-profile"), "the granted access")
    page.fill({}, ".card-footer .btn-success")
    page.end()


def try_bridge(program):
    address = free_address()
    bridge = Bridge(f"http://{address}/sign-in/callback")
    page = SignIn("SATOSA", start_service(program, bridge, address))
    page.fill({"input[name=name]": "ada"}, "button")
    page.end()


def main():
    program, folder = sys.argv[1], Path(sys.argv[2])
    try_oidc_provider(program, folder)
    if (folder / "glewlwyd").exists():
        try_glewlwyd(program, folder)
    try_bridge(program)


if __name__ == "__main__":
    main()
