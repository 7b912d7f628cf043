"""Programs of others read the PDFs and the calendar of the demonstration school.

    papers.py PROGRAM [FOLDER]     with qpdf, poppler-utils and zbar-tools; the papers are kept in the folder

qpdf checks the syntax; poppler reads metadata, fonts, text and attachment; ZBar reads the code on the printed page; icalendar and vobject read the
calendar. None of them checks the whole of PDF/A: krilla does while it writes, and refuses a file that does not conform.
"""

import html
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import icalendar
import vobject

from service import Browser, Demonstration, expect, find_field

# The demonstration has one trainee who has mastered a course by supervised attempts.
MASTER = "hana.suzuki@demo.example"
HEAD = "ingrid.halvorsen@demo.example"
SIGNATORY = "Prof. Dr. Zoë Łukasiewicz-Großmann"


def run(*command):
    """Runs a program and returns its output."""
    # pdfinfo writes titles of headings as they stand in the file, also in UTF-16.
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    expect(done.returncode == 0, f"{command}: {done.stdout} {done.stderr}")
    return done.stdout


def check_pdf(file, title, language):
    """Checks syntax, metadata and fonts of a paper."""
    expect("No syntax or stream encoding errors" in run("qpdf", "--check", str(file)), f"qpdf: {file.name}")
    facts = dict(re.findall(r"^([^:\n]+): +(.*)$", run("pdfinfo", str(file)), re.MULTILINE))
    expect(title in facts["Title"], f"{file.name}: title {facts['Title']}")
    expect(facts["Tagged"] == "yes", f"{file.name}: {facts}")
    claims = run("pdfinfo", "-meta", str(file))
    for claim in ("pdfaid:part>3<", "pdfaid:conformance>A<", "pdfuaid:part>1<"):
        expect(claim in claims, f"{file.name} does not claim {claim}")
    tree = run("pdfinfo", "-struct-text", str(file))
    for tag in ("H1", "P", "Table", "TH", "TD"):
        expect(re.search(rf"^ *{tag}\b", tree, re.MULTILINE), f"{file.name} has no {tag}: {tree}")
    catalogue = run("qpdf", "--json", "--json-key=qpdf", str(file))
    expect(f'"/Lang": "u:{language}"' in catalogue, f"{file.name}: language {language}")
    expect('"/DisplayDocTitle": true' in catalogue, f"{file.name} shows its file name")
    fonts = run("pdffonts", str(file)).splitlines()[2:]
    expect(fonts, f"{file.name} has no fonts")
    for font in fonts:
        expect(re.search(r" yes yes yes +\d+ +0$", font), f"not embedded as a subset with Unicode: {font}")
    return " ".join(run("pdftotext", "-layout", str(file), "-").split())


def check_certificate(demonstration, browser, folder):
    """The PDF certifies what the page certifies, and its code leads to the page that finds it genuine."""
    home = browser.get("/")
    form = html.unescape(re.search(r'action="(/trainees/[^"]+/certificates/[^"/]+)"', home.text).group(1))
    csrf = find_field(home.text, "csrf")
    page, paper = (browser.open(form, {"csrf": csrf, "format": kind}) for kind in ("html", "pdf"))
    file = folder / "certificate.pdf"
    file.write_bytes(paper.body)
    text = check_pdf(file, "Certificate of Hana Suzuki", "en")
    body = page.text.split("<main>")[1].split("</main>")[0]
    for shown in re.findall(r">([^<]+)<", body):
        words = " ".join(html.unescape(shown).split())
        missing = words and words not in text and not words.startswith("The file of this page")
        expect(not missing or " ".join(words.split()[:4]) in text, f"{words!r} is not on paper: {text}")
    run("pdfdetach", "-saveall", "-o", str(folder), str(file))
    attached = json.loads((folder / "certificate.json").read_text(encoding="utf-8"))
    statement = json.loads(attached["statement"])
    expect(statement["trainee"] == "Hana Suzuki", f"{statement}")
    key = Browser(demonstration.url).get("/.well-known/stylet-certificate-key").text.strip()
    for signed in (file, folder / "certificate.json"):
        run(demonstration.program, "certificate", "verify", str(signed), "--key", key)
    run("pdftoppm", "-r", "150", "-png", "-singlefile", str(file), str(folder / "certificate"))
    code = run("zbarimg", "-q", "--raw", str(folder / "certificate.png")).strip()
    checked = browser.get(code)
    expect(checked.status == 200 and "Genuine" in checked.text, f"the code {code}: {checked.text}")
    print(f"certificate: {len(paper.body)} bytes, its code is genuine", flush=True)


def check_transcript(browser, folder):
    """The transcript in German has the figures of the page."""
    account = browser.get("/account")
    browser.post("/account/language", account, language="de")
    address = re.search(r'href="(/trainees/[^"]+/transcript)"', browser.get("/").text).group(1)
    paper = browser.get(f"{address}.pdf")
    file = folder / "transcript.pdf"
    file.write_bytes(paper.body)
    text = check_pdf(file, "Hana Suzuki", "de")
    cells = re.findall(r"<td[^>]*>([^<]+)</td>", browser.get(address).text)
    for cell in cells:
        expect(html.unescape(cell).strip() in text, f"{cell!r} is not on paper: {text}")
    expect(SIGNATORY in text, f"no signatory: {text}")
    print(f"transcript: {len(paper.body)} bytes, {len(cells)} cells", flush=True)


def check_calendar(demonstration):
    """Both programs read the same instants as the API."""
    for (email,) in demonstration.rows("SELECT email FROM people WHERE role = 'trainee' ORDER BY email"):
        browser = demonstration.sign_in(email)
        made = browser.post("/account/calendar", browser.get("/account/calendar"))
        address = re.search(r'value="(http[^"]+\.ics)"', made.text).group(1)
        feed = Browser(demonstration.url).get(address)
        expect(feed.status == 200 and "Set-Cookie" not in feed.headers, f"{feed.status} {feed.headers}")
        first = {event["UID"]: event["DTSTART"].dt for event in icalendar.Calendar.from_ical(feed.text).walk("VEVENT")}
        read = vobject.readOne(feed.text)
        second = {event.uid.value: event.dtstart.value for event in getattr(read, "vevent_list", [])}
        expect(first == second, f"{first} {second}")
        expect(all(due.utcoffset().total_seconds() == 0 for due in first.values()), f"not in UTC: {first}")
        if first:
            print(f"calendar: {len(first)} events, the first on {min(first.values()):%Y-%m-%d %H:%M} UTC", flush=True)
            return
    sys.exit("failed: nothing is due")


def main():
    demonstration = Demonstration(sys.argv[1])
    head = demonstration.sign_in(HEAD)
    page = head.get("/admin/settings")
    form = dict(re.findall(r'<input id="(\w+)" name="\1"[^>]* value="([^"]*)"', page.text))
    form |= {"time_zone": "Europe/Berlin", "letter_language": "en", "signatory_name": SIGNATORY, "signatory_function": "Studiendekanin"}
    settled = head.post("/admin/settings", page, **form)
    expect(settled.status == 200 and "saved=true" in settled.url, f"{settled.status} {settled.text}")
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(sys.argv[2]) if len(sys.argv) > 2 else Path(folder)
        browser = demonstration.sign_in(MASTER)
        check_certificate(demonstration, browser, folder)
        check_transcript(browser, folder)
    check_calendar(demonstration)


if __name__ == "__main__":
    main()
