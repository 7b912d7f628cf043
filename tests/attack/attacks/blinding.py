"""Whoever rates blindly learns from nothing whose attempt it is."""

import re

from verdict import honest, refuse, status


def round_of(town, sessions):
    raters = [town.person(name) for name in ("near", "colleague")]
    fields = [("title", "Round"), ("instrument", "global-rating-puncture")]
    fields += [("rater", rater) for rater in raters] + [("attempt", session) for session in sessions]
    made = town.browser("teacher").press("/ratings", fields, page="/ratings/new")
    honest(made.status == 303, f"a round is made: {made}")
    return made.header("location")


def holds(text, word):
    """A number counts where it stands by itself: within the digits of a curve any will be found."""
    return re.search(rf"(?<![\d.]){word}(?!\d)", text) if word.isdigit() else word in text


def attack_what_a_rater_receives(world):
    """pages, headers, replay and series of a blind rating are searched for names, ids, hashes, times and sizes"""
    town = world.own_town()
    town.programs.run("curricula", "import", "curricula", "--school", "North", "--data-dir", town.data, check=False)
    sessions = [world.scored("ada", town), world.scored("ben", town)]
    page = round_of(town, sessions)
    rater = town.browser("colleague")
    listed = rater.get(page)
    ratings = sorted(set(re.findall(r"/rate/([0-9a-f-]{36})", listed.text)))
    honest(len(ratings) >= 1, f"the rater is asked: {listed}")
    telling = {"Ada", "Ben", *(town.template.pseudonyms[name] for name in ("ada", "ben")), *sessions, town.person("ada"), town.person("ben")}
    for sha, size, motion in town.rows("SELECT recording_sha256, recording_size, motion_sha256 FROM sessions"):
        telling |= {sha, motion, str(size)}
    answers = []
    for rating in ratings:
        answers += [rater.get(f"/rate/{rating}"), *(rater.get(f"/api/v1/ratings/{rating}{tail}") for tail in ("/replay", "/replay/frames", "/series"))]
    honest(all(answer.status == 200 for answer in answers), f"all of it is there: {[a.status for a in answers]}")
    for answer in [listed, rater.get("/ratings"), *answers]:
        whole = answer.text + repr(answer.headers)
        found = [word for word in telling if holds(whole, word)]
        refuse(not found, f"it holds {found}: {answer}")
        for name in ("last-modified", "etag"):
            refuse(not answer.header(name), f"{name}: {answer.header(name)}")
    seen = town.browser("teacher").get(f"/sessions/{sessions[0]}").text
    honest("Ada" in seen and sessions[0] in seen, "who may know is told")
    return f"nothing of {len(telling)} telling words in {len(answers) + 2} answers"


def attack_conditions_that_find_out_times(world):
    """If-Modified-Since, If-None-Match and ranges on a blind replay, and the attempt's own addresses"""
    town = world.own_town()
    sessions = [world.scored("ada", town), world.scored("ben", town)]
    page = round_of(town, sessions)
    rater = town.browser("colleague")
    rating = re.search(r"/rate/([0-9a-f-]{36})", rater.get(page).text).group(1)
    for part in ("replay", "replay/frames"):
        for condition in ({"If-Modified-Since": "Fri, 01 Jan 2100 00:00:00 GMT"}, {"If-None-Match": "*"}):
            answer = rater.get(f"/api/v1/ratings/{rating}/{part}", condition)
            refuse(answer.status == 200, f"{part} with {condition}: {answer.status}")
    for session in sessions:
        for path in (f"/sessions/{session}", f"/sessions/{session}/replay", f"/api/v1/sessions/{session}/replay"):
            status(rater.get(path), 404)
    status(rater.get(f"{page}/ratings.csv"), 409)
    status(town.browser("near").get(f"/rate/{rating}"), 404)
    for path in (f"/rate/{rating}", f"/api/v1/ratings/{rating}/replay"):
        status(town.browser("ada").get(path), 403, 404)
    return "200 whatever the condition; 404 for the attempts and for another's rating"


def attack_rater_who_knows_unmarked(world):
    """a rater who teaches the trainee rates, and the results do not say so"""
    town = world.own_town()
    page = round_of(town, [world.scored("ada", town)])
    marked = town.rows("SELECT name FROM pragma_table_info('ratings') WHERE name LIKE '%know%'")
    honest(marked, "ratings keep who may know")
    column = marked[0][0]
    known = {email: flag for email, flag in town.rows(
        f"SELECT p.email, r.{column} FROM ratings r JOIN people p ON p.id = r.rater_id")}
    honest(known.get("colleague@example.org") in (0, None), f"who does not teach her is not marked: {known}")
    refuse(known.get("near@example.org"), f"who teaches her is not marked: {known}")
    return f"marked at the asking; the page of the round says so ({town.browser('teacher').get(page).status})"
