"""Chromium, driven by WebDriver."""

import base64
import json
import sys
import time
import urllib.request
from pathlib import Path

from service import free_address, start, wait_for


class Window:
    """A window of a Chromium of its own, without cookies of third parties."""

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

    def open(self, address):
        self.call("POST", "/url", {"url": address})

    def address(self):
        return self.call("GET", "/url")

    def text(self):
        return self.call("POST", "/execute/sync", {"script": "return document.body.innerText", "args": []})

    def find_all(self, selector):
        """Returns the paths of the elements of a selector."""
        found = self.call("POST", "/elements", {"using": "css selector", "value": selector})
        return [f"/element/{value}" for element in found for value in element.values()]

    def find(self, selector):
        """Returns the path of the first element of a selector, and waits for it."""
        return self.wait(lambda: self.find_all(selector), selector)[0]

    def press(self, selector):
        self.call("POST", f"{self.find(selector)}/click")

    def fill(self, selector, text):
        self.call("POST", f"{self.find(selector)}/value", {"text": text})

    def save_picture(self, file):
        Path(file).write_bytes(base64.b64decode(self.call("GET", "/screenshot")))

    def close(self):
        self.call("DELETE", "")

    @staticmethod
    def wait(condition, what="the page"):
        """Returns the first true value of a condition, within ten seconds."""
        for _ in range(100):
            if value := condition():
                return value
            time.sleep(0.1)
        sys.exit(f"Chromium does not show {what}")
