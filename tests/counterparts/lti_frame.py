"""A launch from a frame on a page of another site, in Chromium with cookies of third parties blocked.

    lti_frame.py PROGRAM [PICTURES]     the service to check, and the folder for pictures of both pages
"""

import sys
from pathlib import Path

from chromium import Window
from lti import DEPLOYMENT, PLATFORM, start_both
from service import expect

# Key of a reference to an element (WebDriver, section 12.2).
ELEMENT = "element-6066-11e4-a52e-4f735466cecf"


def keep_picture(window, name):
    """Saves a picture of the page if a folder is named; of the second launch, it replaces that of the first."""
    if len(sys.argv) > 2:
        window.save_picture(Path(sys.argv[2]) / f"{name}.png")


def launch(window):
    """Opens the course and presses the only button in its frame; returns address and text of the new window."""
    window.open(f"http://{PLATFORM}/course")
    frame = window.find("iframe").removeprefix("/element/")
    window.call("POST", "/frame", {"id": {ELEMENT: frame}})
    course = window.call("GET", "/window/handles")
    window.wait(lambda: window.find_all("button"))
    keep_picture(window, "frame")
    window.press("button")
    opened = window.wait(lambda: set(window.call("GET", "/window/handles")) - set(course), "another window")
    window.call("POST", "/window", {"handle": opened.pop()})
    passing = ("about:blank", "/auth?", "/lti/login")
    window.wait(lambda: not any(part in window.address() for part in passing))
    text, address = window.wait(window.text), window.address()
    keep_picture(window, "opened")
    window.call("DELETE", "/window")
    window.call("POST", "/window", {"handle": course[0]})
    return address, text


def main():
    service, _, own = start_both(sys.argv[1])
    window = Window(service.folder)
    address, text = launch(window)
    expect("code: deployment" in text, f"{address}: {text}")
    print("refused: deployment")
    service.admit(own, DEPLOYMENT)
    address, text = launch(window)
    expect(address == f"{service.url}/" and "Name of ada" in text, f"{address}: {text}")
    print("launched from a frame: ada")
    window.close()


if __name__ == "__main__":
    main()
