"""A launch from a frame on a page of another site, in Chromium with cookies of third parties blocked.

    lti_frame.py PROGRAM     the service to check
"""

import json
import sys
import time
import urllib.request

from lti import PLATFORM, admit, start_both
from service import expect, free_address, start, wait_for


class Window:
    """Chromium, driven by WebDriver."""

    def __init__(self, folder):
        driver = free_address()
        start(["chromedriver", f"--port={driver.split(':')[1]}"], folder)
        self.url = f"http://{driver}"
        wait_for(f"{self.url}/status")
        options = {
            "args": ["--headless=new", "--no-sandbox", "--test-third-party-cookie-phaseout", f"--user-data-dir={folder}/profile"],
            "prefs": {"profile.block_third_party_cookies": True, "profile.cookie_controls_mode": 1},
        }
        session = self.call("POST", "/session", {"capabilities": {"alwaysMatch": {"goog:chromeOptions": options}}})
        self.url += f"/session/{session['sessionId']}"

    def call(self, method, path, body=None):
        body = json.dumps({} if body is None else body).encode() if method == "POST" else None
        request = urllib.request.Request(self.url + path, body, {"Content-Type": "application/json"}, method=method)
        with urllib.request.urlopen(request, timeout=60) as answer:
            return json.load(answer)["value"]

    def find(self, selector):
        return self.call("POST", "/element", {"using": "css selector", "value": selector})

    def launch(self):
        """Opens the course and presses the only button in its frame; returns address and text of the new window after five seconds at most."""
        self.call("POST", "/url", {"url": f"http://{PLATFORM}/course"})
        self.call("POST", "/frame", {"id": self.find("iframe")})
        course = self.call("GET", "/window/handles")
        button = self.find("button")
        self.call("POST", f"/element/{next(iter(button.values()))}/click")
        self.call("POST", "/window", {"handle": self.wait(lambda: set(self.call("GET", "/window/handles")) - set(course)).pop()})
        passing = ("about:blank", "/auth?", "/lti/login")
        self.wait(lambda: not any(part in self.call("GET", "/url") for part in passing))
        text = self.wait(lambda: self.call("POST", "/execute/sync", {"script": "return document.body.innerText", "args": []}))
        address = self.call("GET", "/url")
        self.call("DELETE", "/window")
        self.call("POST", "/window", {"handle": course[0]})
        return address, text

    @staticmethod
    def wait(condition):
        """Returns the first true value of a condition."""
        for _ in range(100):
            if value := condition():
                return value
            time.sleep(0.1)
        sys.exit("Chromium does not get there")


def main():
    service, _, own = start_both(sys.argv[1])
    window = Window(service.folder)
    address, text = window.launch()
    expect("code: deployment" in text, f"{address}: {text}")
    print("refused: deployment")
    admit(service, own)
    address, text = window.launch()
    expect(address == f"{service.url}/" and "Name of ada" in text, f"{address}: {text}")
    print("launched from a frame: ada")
    window.call("DELETE", "")


if __name__ == "__main__":
    main()
