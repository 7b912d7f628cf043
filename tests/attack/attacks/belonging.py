"""Who reaches whose attempts, and what one school sees of another."""

import re

from town import ROOT
from verdict import honest, refuse, status


def reach(town, name, session, trainee):
    """What somebody is answered who wants a trainee, their attempt, its recording, and to grade it."""
    paths = [f"/trainees/{trainee}", f"/sessions/{session}", f"/sessions/{session}/grade"]
    pages = [town.browser(name).get(path).status for path in paths]
    return [*pages, town.program(name).get(f"/api/v1/sessions/{session}/recording").status]


def attack_cohort_of_ones_own(world):
    """an instructor makes a cohort, adds a colleague's trainee by address, and says yes for her in four ways"""
    town = world.own_town()
    session, ada = world.scored("ada", town), town.person("ada")
    eve = town.browser("colleague")
    made = eve.press("/cohorts", {"name": "Mine"})
    cohort = made.header("location").split("/")[2]
    people = f"/cohorts/{cohort}/people"
    honest(eve.press(people, {"email": "ada@example.org"}).status == 303, "she is asked for")
    refuse(reach(town, "colleague", session, ada) == [404] * 4, "asking is enough")
    status(eve.press(f"{people}/{ada}/answer", {"answer": "yes"}), 403)
    status(eve.press(f"/account/cohorts/{cohort}", {"answer": "yes"}), 403, 404)
    eve.press(people, {"email": "ada@example.org", "answer": "yes", "agreed": "yes", "role": "trainee"})
    status(town.browser("near").press(f"{people}/{ada}/answer", {"answer": "yes"}), 404)
    refuse(reach(town, "colleague", session, ada) == [404] * 4, "one of the ways leads to her attempt")
    agreed = town.browser("ada").press(f"/account/cohorts/{cohort}", {"answer": "yes"})
    honest(agreed.status == 303 and reach(town, "colleague", session, ada) == [200] * 4, "once she agrees he sees it")
    eve.press(f"{people}/{ada}/remove")
    told = town.browser("ada").get("/account").text
    refuse("has removed you from Mine" in told and "has asked for a place in" in told, "leaving hides that he was there")
    return "404 until she agrees; she sees who asked, saw and left"


def attack_grade_of_a_colleagues_trainee(world):
    """overrides, reviews, comments and supervision of somebody whom one does not teach"""
    town = world.town
    session = world.scored("ada")
    for path, fields in {
        f"/sessions/{session}/override": {"score": "99", "reason": "x"},
        f"/sessions/{session}/review": {},
        f"/sessions/{session}/supervision": {"confirm": "yes"},
        f"/sessions/{session}/comments": {"kind": "praise", "from_s": "1", "body": "x"},
        f"/sessions/{session}/regrade": {"reason": "x"},
        f"/sessions/{session}/exam-files": {},
    }.items():
        status(town.browser("colleague").press(path, fields), 404)
        if "comments" not in path:
            status(town.browser("ada").press(path, fields), 403, 404)
    honest(town.browser("teacher").press(f"/sessions/{session}/supervision", {"confirm": "yes"}).status == 303, "her teacher may")
    return "404 for the colleague, 403 for herself"


def attack_levels_of_entrustment(world):
    """a trainee, a colleague and an administrator of another school decide on a level; an instructor changes the catalogue"""
    town = world.own_town()
    added = town.browser("head").press("/admin/outcomes", {"code": "EPA 1", "title": "Puncture"})
    outcome = added.header("location").rsplit("/", 1)[-1]
    path = f"/trainees/{town.person('ada')}/outcomes/{outcome}"
    for name, expected in {"ada": 403, "ben": 403, "colleague": 404, "chief": 404}.items():
        status(town.browser(name).press(path, {"level": "5", "note": ""}), expected)
    for form in ("/admin/outcomes", f"/admin/outcomes/{outcome}", "/admin/outcomes/levels"):
        status(town.browser("teacher").press(form, {"code": "EPA 1", "title": "x", "levels": "a\r\nb"}), 403)
    refuse(town.one("SELECT count(*) FROM entrustments") == 0, "somebody has decided")
    honest(town.browser("teacher").press(path, {"level": "2", "note": ""}).status == 303, "her teacher may")
    return "403 and 404; no decision"


def attack_roles_by_form(world):
    """a trainee and an instructor make themselves administrators, by forms of others and by fields that no form has"""
    town = world.town
    new = {"name": "New", "email": "new@example.org", "role": "administrator"}
    for name in ("ada", "teacher"):
        own = town.person(name)
        change = {"name": name, "email": f"{name}@example.org", "role": "administrator"}
        for path, fields in {"/people": new, f"/people/{own}/change": change, f"/people/{own}/enable": {}}.items():
            status(town.browser(name).press(path, fields), 403)
        town.browser(name).press("/account/language", {"language": "en", "role": "administrator", "school_id": "1"})
        role = town.one("SELECT role FROM people WHERE email = ?", f"{name}@example.org")
        refuse(role != "administrator", f"{name} is {role} now")
    status(town.browser("head").press(f"/people/{town.person('chief')}/change", {**new, "role": "trainee"}), 404)
    honest(town.browser("head").press("/people", {**new, "role": "trainee"}).status == 303, "an administrator may")
    return "403 each"


def identities(town, session):
    """What stands for every {name} in the list of routes, all of the school North."""
    table = {
        "session": session, "trainee": town.person("ada"), "cohort": town.cohort("Spring"), "exercise": "only",
        "course": "one-step", "asked": town.person("ben"), "station": town.person("ada"), "person": town.person("ben"),
    }
    made = {
        "assignment": ("assignments", "teacher", "/assignments", {"task": "exercise:only", "cohort": table["cohort"]}),
        "draft": ("drafts", "teacher", "/drafts", {"exercise": "only", "id": "other"}),
        "survey": ("surveys", "teacher", "/surveys/new", {"instrument": "sus", "title": "Why?", "identity": "named"}),
        "regrading": ("regradings", "teacher", "/exercises/only/regrade", {}),
    }
    for key, (relation, name, path, fields) in made.items():
        town.browser(name).press(path, fields)
        found = town.rows(f"SELECT id FROM {relation} ORDER BY rowid DESC LIMIT 1")
        if found:
            value = found[0][0]
            table[key] = value.hex() if isinstance(value, bytes) else value
    return {key: with_dashes(value) for key, value in table.items()}


def with_dashes(value):
    value = str(value)
    return re.sub(r"^(.{8})(.{4})(.{4})(.{4})(.{12})$", r"\1-\2-\3-\4-\5", value) if re.fullmatch("[0-9a-f]{32}", value) else value


def routes(world, town, session):
    """Method, path and body of every route whose ids are known, from the list that the service's own tests keep."""
    table, found = identities(town, session), []
    for line in (ROOT / "web-admin/tests/main/every_route.txt").read_text().splitlines():
        if not re.match(r"(GET|POST|PUT|PATCH|DELETE|HEAD) ", line):
            continue
        words, body = line.split("|")[0].split(), line.split("|")[2].strip() if line.count("|") > 1 else ""
        for key, value in table.items():
            words[1], body = words[1].replace(f"{{{key}}}", value), body.replace(f"{{{key}}}", value)
        if "{" not in words[1]:
            found.append((words[0], words[1], "" if "{" in body and "/api/" not in words[1] else body))
    return found


def attack_ids_of_another_school(world):
    """every address with an id of North, as an administrator, an instructor and a trainee of South"""
    town = world.own_town()
    session = world.scored("ada", town)
    with_ids = [one for one in routes(world, town, session) if re.search("[0-9a-f]{8}-[0-9a-f]{4}", one[1]) and one[0] == "GET"]
    honest(len(with_ids) > 25, f"only {len(with_ids)} addresses with an id are known")
    seen = 0
    for _, path, _ in with_ids:
        api = path.startswith("/api/")
        owners = [(town.program if api else town.browser)(name).get(path).status for name in ("teacher", "head", "ada")]
        seen += 200 in owners
        for name in ("chief", "guide", "sam"):
            answer = (town.program if api else town.browser)(name).get(path)
            refuse(answer.status in ((401,) if path.startswith("/scim/") else (403, 404)), f"{path} as {name}: {answer}")
            refuse("Ada" not in answer.text and session not in answer.text.replace(path, ""), f"{path} as {name} tells of her")
    honest(seen > 20, f"only {seen} of {len(with_ids)} addresses are there for their owners")
    return f"{3 * len(with_ids)} requests refused; {seen} of these pages are there for North"


def attack_trainee_looks_at_another(world):
    """a trainee asks for another's page, attempt, recording, replay, comments, score, link and progress"""
    town = world.town
    session, ada = world.scored("ada"), town.person("ada")
    tails = ["", "/replay", "/grade"]
    paths = [f"/sessions/{session}{tail}" for tail in tails] + [f"/trainees/{ada}", f"/trainees/{ada}/exercises/only"]
    api = [f"/api/v1/sessions/{session}{tail}" for tail in ("", "/score", "/recording", "/series", "/replay", "/comments")]
    for name, pages, calls in (("ada", 200, 200), ("ben", 404, 404)):
        got = [town.browser(name).get(path).status for path in paths] + [town.program(name).get(path).status for path in api]
        check = honest if name == "ada" else refuse
        check(set(got) == {pages} == {calls}, f"{name}: {got}")
    status(town.browser("ben").press(f"/sessions/{session}/links"), 404)
    listed = town.program("ben").get("/api/v1/sessions").text
    refuse(session not in listed, "it is in the other's list")
    return "404 everywhere"


def attack_station_reads_attempts(world):
    """a station's token asks for sessions, recordings, scores and assignments"""
    town = world.own_town()
    session = world.scored("ada", town)
    token = town.programs.run("user", "token", "--data-dir", town.data, "--school", "North", "--station", "lab").stdout.strip()
    station = town.stranger(token=token)
    honest(station.get("/api/v1/exercises").status == 200, "it reads exercises")
    for tail in ("", f"/{session}", f"/{session}/recording", f"/{session}/score", f"/{session}/comments"):
        status(station.get(f"/api/v1/sessions{tail}"), 403)
    status(station.get("/api/v1/me/assignments"), 403)
    refuse(station.get("/").status == 303, "it opens pages")
    return "403 each"


def attack_uploads_of_others(world):
    """a piece for, a look at and the end of somebody else's upload"""
    town = world.town
    recording = world.recording().write()
    begun = town.program("ada").tus("POST", upload_length=len(recording))
    path = begun.header("location")
    honest(begun.status == 201, f"she begins one: {begun}")
    for name in ("ben", "head", "sam"):
        other = town.program(name)
        for method, more in (("HEAD", {}), ("PATCH", {"upload_offset": 0}), ("DELETE", {})):
            status(other.tus(method, path, b"x" if method == "PATCH" else b"", **more), 404)
    status(town.stranger().tus("HEAD", path), 401)
    honest(town.program("ada").tus("PATCH", path, recording, upload_offset=0).status == 204, "she ends it")
    return "404, and 401 for a stranger"


def attack_study_of_anybody(world):
    """an instructor adds somebody else's trainee to a study by address, says yes for her, reads her attempts, and answers in her place"""
    town = world.own_town()
    colleague = town.browser("colleague")
    fields = [("title", "A study"), ("exercise", "only"), ("attempts", "3"), ("groups", "One\r\nTwo"), ("questions", ""),
              ("after", "nasa-tlx"), ("consent", "I take part."), ("controller", "North"), ("contact", "a@example.org"), ("kept", "12")]
    made = colleague.press("/studies/new", fields, page="/studies/new")
    honest(made.status == 303, f"a study is made: {made}")
    study, ada = made.header("location"), town.person("ada")
    asked = colleague.press(f"{study}/participants", {"email": "ada@example.org", "group": "0", "consent": "yes"}, page=study)
    honest(asked.status == 303, f"she is asked: {asked}")
    world.scored("ada", town)
    rows = lambda: len(colleague.get(f"{study}/results/study.csv").text.splitlines()) - 1
    refuse(rows() == 0, "she is in it without a word of hers")
    status(colleague.press(f"/account{study}/join", {"terms": "x"}), 404)
    status(colleague.press(f"{study}/participants/{ada}/links", page=study), 404)
    terms = re.search(r'name="terms" value="([^"]+)"', town.browser("ada").get("/account/studies").text).group(1)
    agreed = town.browser("ada").press(f"/account{study}/join", {"terms": terms})
    honest(agreed.status == 303, f"she agrees: {agreed}")
    refuse(rows() == 0, "what she did before she agreed is in it")
    world.scored("ada", town)
    honest(rows() == 1, "what she does from then on is in it")
    status(colleague.press(f"{study}/participants/{ada}/links", page=study), 404)
    honest(town.browser("ada").press(f"/account{study}/leave").status == 303 and rows() == 0, "she leaves it")
    return "nothing before she agrees, and nobody answers for her"
