"""What people type: names, titles, letters, pages, tables, and where they are sent."""

import io
import re
import tarfile
import time
import urllib.parse

from verdict import honest, refuse, status

BAD = ["A\u202eB", "A\u2028B", "A\u2029B", "A\nB", "A\r\nBcc: x@evil.example", "A\x00B", "=1+1", "@SUM(A1)", "+1", "-1", "A\x1b[31mB", "\u2066A\u2069"]


def attack_names_that_turn_lines(world):
    """U+202E, line separators, control characters and formulas in names of people, cohorts and stations"""
    town, got = world.town, []
    head = town.browser("head")
    for number, bad in enumerate(BAD):
        for path, fields in {
            "/people": {"name": bad, "email": f"bad{number}@example.org", "role": "trainee"},
            "/cohorts": {"name": bad},
        }.items():
            answer = head.press(path, fields)
            if answer.status == 303:
                got.append((path, bad))
    refuse(not got, f"taken: {got}")
    honest(head.press("/people", {"name": "Zoë Müller", "email": "zm@example.org", "role": "trainee"}).status == 303, "a name is taken")
    return f"{2 * len(BAD)} names refused"


def letters(town, wait=20):
    """Every letter that has gone out."""
    folder = town.data / "mail"
    for _ in range(wait * 5):
        if folder.is_dir() and any(folder.iterdir()):
            break
        time.sleep(0.2)
    return [path.read_bytes().decode("utf-8", "replace") for path in sorted(folder.glob("*"))] if folder.is_dir() else []


def attack_titles_that_write_letters(world):
    """a survey's title and a recipient's name that end the header or begin the letter's body"""
    town = world.own_town()
    teacher = town.browser("teacher")
    new = {"instrument": "sus", "title": "What do you think?", "identity": "anonymous"}
    for title in ("A\n\nDear Ana,\nclick https://evil.example", "A\r\nBcc: all@example.org", "A\u2029B", "A\u202eB", "x" * 5000):
        status(teacher.press("/surveys/new", {**new, "title": title}, page="/surveys/new"), 422)
    made = teacher.press("/surveys/new", new, page="/surveys/new")
    honest(made.status == 303, f"a survey is made: {made}")
    survey = made.header("location")
    for label in ("Ana \u202ekE <ana@example.org>", "Ana\r\nBcc: b@example.org <ana@example.org>", "a@example.org>\nBcc: <x@example.org"):
        answer = teacher.press(f"{survey}/links", {"labels": label, "do": "mail"}, page=survey)
        refuse(answer.status == 422 or "Bcc" not in answer.header("location"), f"{label!r}: {answer}")
    sent = teacher.press(f"{survey}/links", {"labels": "Dr Ek <ek@example.org>", "do": "mail"}, page=survey)
    honest(sent.status == 303, f"a letter is asked for: {sent}")
    found = letters(town)
    honest(any("ek@example.org" in letter for letter in found), "it goes out")
    refuse(not any(re.search(r"(?im)^(b?cc):", letter) or "evil.example" in letter for letter in found), "a header was planted")
    return f"titles and names 422; {len(found)} letters, none with a header of the attacker's"


def attack_letters_without_end(world):
    """600 letters with survey links in one go, and the rest in further ones"""
    town = world.own_town()
    teacher = town.browser("teacher")
    made = teacher.press("/surveys/new", {"instrument": "sus", "title": "T", "identity": "anonymous"}, page="/surveys/new")
    survey = made.header("location")

    def ask(first, count):
        labels = "\n".join(f"p{n}@example.org" for n in range(first, first + count))
        return teacher.press(f"{survey}/links", {"labels": labels, "do": "mail"}, page=survey)

    status(ask(0, 600), 422)
    honest(ask(0, 150).status == 303, "150 may go out")
    answers = [ask(150 * n, 150).status for n in range(1, 4)]
    queued = town.one("SELECT count(*) FROM survey_letters")
    refuse(queued <= 300, f"{queued} letters in an hour: {answers}")
    return f"{queued} letters taken, then {answers[-1]}"


PAYLOADS = ['"><script>alert(7)</script>', "'><img src=x onerror=alert(7)>", "</textarea><svg/onload=alert(7)>", "javascript:alert(7)//", "{{7*7}}"]


def attack_planted_scripts(world):
    """payloads in comments, cohorts, surveys, drafts, names and an event's text, then every page that shows them"""
    town = world.own_town()
    tape = world.recording(device=PAYLOADS[0]).fresh()
    tape.edit("/events", lambda event: setattr(event, "text", PAYLOADS[1]))
    session = world.scored("ada", town, tape)
    head, teacher, ada = (town.browser(name) for name in ("head", "teacher", "ada"))
    for number, payload in enumerate(PAYLOADS):
        head.press("/people", {"name": f"x{payload}", "email": f"x{number}@example.org", "role": "trainee"})
        teacher.press("/cohorts", {"name": f"x{payload}"})
        teacher.press(f"/sessions/{session}/comments", {"kind": "praise", "from_s": "0.5", "body": f"x{payload}"})
        teacher.press("/surveys/new", {"instrument": "sus", "title": f"x{payload}", "identity": "named"}, page="/surveys/new")
        made = teacher.press("/drafts", {"exercise": "only", "id": f"copy-{number}"})
        if made.header("location"):
            path = made.header("location")
            text = town.template.exercise.read_text().replace('title = "', f'title = "x{payload}'.replace('"', "\\\"").replace('title = \\"', 'title = "'), 1)
            teacher.press(path, {"seen": "1", "document": text, "scene": "", "act": "save"}, page=path)
    cohort = town.cohort("Spring")
    pages = ["/", "/account", "/cohorts", f"/cohorts/{cohort}", f"/cohorts/{cohort}/people", f"/sessions/{session}", f"/sessions/{session}/replay"]
    pages += [f"/trainees/{town.person('ada')}", "/surveys", "/drafts", "/people", "/admin", "/review", "/progress", "/assignments"]
    pages += [path for path in re.findall(r'href="(/drafts/[^"]+)', teacher.get("/drafts").text)]
    shown = 0
    for who in (head, teacher, ada):
        for path in pages:
            answer = who.get(path)
            shown += "alert(7)" in answer.text
            for raw in ("<script>alert(7)", "<img src=x", "<svg/onload", 'href="javascript:', ">49<"):
                refuse(raw not in answer.text, f"{path} holds {raw}")
            policy = answer.header("content-security-policy")
            refuse("default-src 'none'" in policy and "unsafe-inline" not in policy, f"{path}: {policy}")
    honest(shown > 5, f"only {shown} pages show what was planted")
    return f"escaped on {shown} pages, under a policy without inline code"


def attack_formulas_in_tables(world):
    """names and texts that are formulas, in the tables for spreadsheets"""
    town = world.town
    world.scored("ada")
    head = town.browser("head")
    for path in ("/progress.csv", "/progress/attempts.csv", f"/cohorts/{town.cohort('Spring')}/progress.csv"):
        table = head.get(path)
        honest(table.status == 200 and table.text.count("\n") > 1, f"{path} is there: {table.status}")
        cells = [cell.strip('"') for line in table.text.splitlines() for cell in line.split(",")]
        found = [cell for cell in cells if re.match(r"[=@\t\r]|[+-](?![\d.])", cell)]
        refuse(not found, f"{path}: {found[:3]}")
    return "no cell begins with a formula's sign; such names are refused at the door"


def attack_redirects_elsewhere(world):
    """next= and Referer that lead to another site, at sign-in, at choosing a language and after it"""
    town = world.town
    for way in ("//evil.example", "/\\evil.example", "https://evil.example", "/%09/evil.example", "/\t/evil.example", "javascript:alert(1)", "/a\r\nX: y"):
        visitor = town.stranger()
        answer = visitor.sign_in("ada@example.org", next=way)
        places = [answer.header("location"), visitor.send("GET", "/login?next=" + urllib.parse.quote(way)).header("location")]
        chosen = visitor.press("/language", {"language": "de", "next": way, "back": way}, page="/account")
        referred = visitor.form("/language", {"csrf": visitor.csrf(), "language": "de"}, {"Referer": "https://evil.example/x"})
        places += [chosen.header("location"), referred.header("location")]
        refuse(not any("evil" in place or ":" in place for place in places), f"{way!r}: {places}")
        refuse(not answer.header("x"), "a header was planted")
    honest(town.stranger().sign_in("ada@example.org", next="/cohorts").header("location") == "/cohorts", "an address of ours is gone to")
    return "seven ways, all end here"


def attack_paths(world):
    """.. in addresses of assets, recordings, exports and ids, plain, encoded once and twice"""
    town = world.town
    up = ["../" * 6 + "etc/passwd", "..%2f" * 6 + "etc/passwd", "%2e%2e/" * 6 + "etc/passwd", "..%252f" * 6 + "etc/passwd", "....//" * 6 + "etc/passwd",
          "..\\" * 6 + "etc/passwd", "%00", "style.css%00.png", "../stylet.db", "/etc/passwd"]
    bases = ["/assets/", "/recordings/", "/recordings/x/", "/survey/", "/join/", "/sessions/", "/api/v1/sessions/", "/api/v1/uploads/", "/surveys/x/results/", "/exercises/"]
    ada = town.browser("ada")
    honest(ada.get("/assets/style.css").status == 200, "assets are there")
    for base in bases:
        for tail in up:
            answer = ada.get(base + tail)
            refuse(answer.status in (303, 400, 401, 404, 405) and "root:" not in answer.text, f"{base}{tail}: {answer}")
    return f"{len(bases) * len(up)} addresses, 400 or 404 or to the sign-in"


def attack_archives(world):
    """backups that hold .., absolute paths, links, devices and a bomb, given to restore"""
    programs = world.programs
    town = world.own_town()
    good = programs.folder / "good.tar"
    good.unlink(missing_ok=True)
    programs.run("backup", "--to", good, "--data-dir", town.data)
    with tarfile.open(good) as archive:
        members = [(member, archive.extractfile(member).read() if member.isfile() else None) for member in archive]

    def restore(extra, name):
        bad, place = programs.folder / "bad.tar", programs.folder / f"restored-{name}"
        with tarfile.open(bad, "w") as archive:
            for member, data in [*members[:1], *extra, *members[1:]]:
                archive.addfile(member, io.BytesIO(data) if data is not None else None)
        return programs.run("restore", bad, "--data-dir", place, check=False), place

    honest(restore([], "good")[0].returncode == 0, "a backup is restored")
    for name, kind, link in (("../../escaped", tarfile.REGTYPE, ""), ("/tmp/stylet-escaped", tarfile.REGTYPE, ""), ("recordings/x", tarfile.SYMTYPE, "/etc"),
                             ("recordings/x/passwd", tarfile.LNKTYPE, "/etc/passwd"), ("recordings/dev", tarfile.CHRTYPE, ""), ("other.txt", tarfile.REGTYPE, "")):
        member = tarfile.TarInfo(name)
        member.type, member.linkname, member.size = kind, link, 4 if kind == tarfile.REGTYPE else 0
        done, place = restore([(member, b"evil" if kind == tarfile.REGTYPE else None)], re.sub(r"\W", "", name))
        refuse(done.returncode != 0, f"{name} is restored: {done.stdout}")
        refuse(not (place / "stylet.db").exists(), f"{name}: half of it is there")
    for path in (programs.folder / "escaped", programs.folder.parent / "escaped"):
        refuse(not path.exists(), f"{path} was written")
    return "six archives refused, nothing written"
