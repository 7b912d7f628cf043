"""Passwords, sessions, links and codes, and whoever guesses them."""

import concurrent.futures
import re
import statistics
import time

from visitor import PASSWORD
from verdict import alone, honest, refuse, status

NEW = "ein Pferd aus Mergel 7"


def guesses(visitor, count, email="ada@example.org"):
    return [visitor.sign_in(email, f"guess {n}").status for n in range(count)]


def attack_guessing_a_password(world):
    """thirty passwords for one account from one address, then the right one; many accounts from one address"""
    town = world.own_town()
    stranger = town.stranger()
    got = guesses(stranger, 30)
    refuse(got.count(401) <= 12 and got[-1] == 429, f"answers {got}")
    status(stranger.sign_in("ada@example.org"), 429)
    honest(town.stranger().sign_in("ada@example.org").status == 303, "she signs in from elsewhere")
    many = town.stranger()
    got = [many.sign_in(f"p{n}@example.org", "x").status for n in range(130)]
    refuse(got.count(401) <= 120, f"{got.count(401)} accounts tried in a row")
    return f"12 tries for one account, {got.count(401)} accounts from one address"


def attack_an_address_of_ones_own_choice(world):
    """X-Forwarded-For with a first hop, a line, a port, an IPv6 address of ones own /64 for every guess, behind a proxy"""
    town = world.own_town("--behind-tls")

    def tried(hops, name="ada"):
        got = []
        for n in range(16):
            headers, visitor = hops(n), town.stranger()
            page = visitor.send("GET", "/login", headers=dict(headers[:1]))
            cookie = page.header("set-cookie").split(";")[0]
            got.append(guess(town, (cookie, page.text, name), headers))
        return got.count(401)

    ways = {
        "a first hop": lambda n: [("X-Forwarded-For", f"6.6.6.{n}, 10.9.0.1")],
        "a first line": lambda n: [("X-Forwarded-For", f"6.6.6.{n}"), ("X-Forwarded-For", "10.9.0.2")],
        "a port": lambda n: [("X-Forwarded-For", f"10.9.0.3:{4000 + n}")],
        "an address of its /64": lambda n: [("X-Forwarded-For", f"2001:db8:9:9::{n:x}")],
        "that with a port": lambda n: [("X-Forwarded-For", f"[2001:db8:9:8::{n:x}]:{4000 + n}")],
        "an IPv4 address in IPv6": lambda n: [("X-Forwarded-For", "::ffff:10.9.0.4" if n % 2 else "10.9.0.4")],
        "other headers": lambda n: [("X-Forwarded-For", "10.9.0.5"), ("X-Real-IP", f"6.6.6.{n}"), ("Forwarded", f"for=6.6.7.{n}")],
    }
    found = {way: tried(hops) for way, hops in ways.items()}
    refuse(max(found.values()) <= 11, f"tries let through: {found}")
    apart = tried(lambda n: [("X-Forwarded-For", f"10.8.{n}.1")], "ben")
    honest(apart >= 15, f"different addresses are different: {apart}")
    return f"tries let through: {found}; of different addresses {apart}"


def guess(town, asked, headers):
    """A guess whose headers may be there twice, which a client by the book does not send."""
    import http.client
    import urllib.parse

    from visitor import csrf_in

    cookie, page, name = asked
    body = urllib.parse.urlencode({"csrf": csrf_in(page), "email": f"{name}@example.org", "password": "a guess"})
    connection = http.client.HTTPConnection(*town.service.place, timeout=60)
    connection.putrequest("POST", "/login")
    for name, value in [*headers, ("Cookie", cookie), ("Content-Type", "application/x-www-form-urlencoded"), ("Content-Length", str(len(body)))]:
        connection.putheader(name, value)
    connection.endheaders(body.encode())
    answer = connection.getresponse()
    answer.read()
    connection.close()
    return answer.status


def attack_guessing_by_a_stolen_session(world):
    """thirty old passwords typed at /account/password of a browser that was left open"""
    town = world.own_town()
    thief = town.browser("ada")
    got = [thief.press("/account/password", {"old": f"guess {n}", "password": NEW, "again": NEW}).status for n in range(30)]
    refuse(got.count(422) <= 12 and got[-1] == 429, f"answers {got}")
    right = town.browser("ben").press("/account/password", {"old": PASSWORD, "password": NEW, "again": NEW})
    honest(right.status == 303, f"who knows the old one sets a new one: {right}")
    return f"{got.count(422)} guesses, then 429"


def attack_flood_of_forgotten(world):
    """/forgotten for one person from forty addresses, then she signs in and asks herself"""
    town = world.own_town()
    home = town.stranger()
    honest(home.sign_in("ada@example.org").status == 303, "she signs in at home")
    for _ in range(40):
        other = town.stranger()
        for _ in range(3):
            other.press("/forgotten", {"email": "ada@example.org"}, page="/forgotten")
    answer = town.stranger(address=home.address).sign_in("ada@example.org")
    refuse(answer.status == 303, f"she is locked out at home: {answer}")
    time.sleep(8)
    folder = town.data / "mail"
    out = len(list(folder.glob("*"))) if folder.is_dir() else 0
    refuse(1 <= out <= 2, f"{out} letters to her")
    return f"{out} letters; at home she still signs in"


@alone
def attack_who_has_an_account(world):
    """words and times of /login and /forgotten for an address that is known and one that is not; limit: medians a third apart"""
    town = world.own_town()
    pages, times = {}, {}
    for kind, email in (("known", "ada@example.org"), ("unknown", "xyz@example.org")):
        took = []
        for _ in range(8):
            answer = town.stranger().sign_in(email, "wrong password")
            honest(answer.status == 401, f"a wrong password: {answer}")
            took.append(answer.seconds)
            forgotten = town.stranger()
            asked = forgotten.press("/forgotten", {"email": email}, page="/forgotten")
        pages[kind] = [re.sub(r'value="[0-9a-f]{20,}"', "", page.text.replace(email, "")) for page in (answer, asked)]
        times[kind] = statistics.median(took)
    refuse(pages["known"] == pages["unknown"], "the pages differ")
    apart = abs(times["known"] - times["unknown"]) / max(times.values())
    refuse(apart < 0.34 * world.slack, f"medians {times}")
    return f"same pages; medians {times['known'] * 1e3:.0f} and {times['unknown'] * 1e3:.0f} ms"


def attack_planted_session(world):
    """a session id that was known before the sign-in, a cookie's flags, a session after signing out"""
    town = world.own_town("--behind-tls")
    visitor = town.stranger()
    page = visitor.get("/login")
    planted = dict(visitor.cookies)
    flags = page.header("set-cookie")
    refuse(flags.startswith("__Host-") and all(flag in flags for flag in ("Secure", "HttpOnly", "SameSite", "Path=/")), flags)
    honest(visitor.sign_in("ada@example.org").status == 303, "she signs in")
    refuse(planted != visitor.cookies, "the id stays")
    status(town.stranger(cookies=planted).get("/"), 303)
    kept = dict(visitor.cookies)
    honest(visitor.get("/").status == 200, "she is in")
    visitor.press("/logout")
    status(town.stranger(cookies=kept).get("/"), 303)
    return "a new id at sign-in, none after signing out; __Host-, Secure, HttpOnly, SameSite"


def attack_sessions_that_outlive(world):
    """sessions and tokens after a new password, after disabling, and after twelve hours"""
    town = world.own_town()
    one, two = town.stranger(), town.stranger()
    for visitor in (one, two):
        honest(visitor.sign_in("ada@example.org").status == 303 and visitor.get("/").status == 200, "two browsers")
    honest(one.press("/account/password", {"old": PASSWORD, "password": NEW, "again": NEW}).status == 303, "a new password")
    status(two.get("/"), 303)
    program, ben = town.program("ben"), town.browser("ben")
    honest(program.get("/api/v1/sessions").status == 200 and ben.get("/").status == 200, "ben is in")
    town.browser("head").press(f"/people/{town.person('ben')}/disable")
    status(ben.get("/"), 303)
    status(program.get("/api/v1/sessions"), 401)
    status(town.stranger().sign_in("ben@example.org"), 401)
    longest = town.one("SELECT max(expires_at) FROM web_sessions") / 1e6 - time.time()
    refuse(longest <= 12 * 3600 + 60, f"a session lasts {longest / 3600:.1f} h")
    honest(longest > 11 * 3600, f"a session lasts {longest / 3600:.1f} h")
    return f"303 and 401; the longest ends after {longest / 3600:.1f} h"


def attack_links_that_outlive(world):
    """an invitation's link after the address has changed, after it was used, and guessed ones"""
    town = world.own_town()
    head, ben = town.browser("head"), town.person("ben")
    links = []
    for _ in range(2):
        shown = head.press(f"/people/{ben}/link").text
        links.append(re.search(r"/join/[0-9A-Za-z_-]+", shown).group(0))
    honest(town.stranger().get(links[-1]).status == 200, "the link is good")
    head.press(f"/people/{ben}/change", {"name": "Ben", "email": "ben2@example.org", "role": "trainee"})
    for link in links:
        status(town.stranger().get(link), 404)
    fresh = re.search(r"/join/[0-9A-Za-z_-]+", head.press(f"/people/{ben}/link").text).group(0)
    used = town.stranger().press(fresh, {"password": NEW, "again": NEW}, page=fresh)
    honest(used.status == 303, f"the link sets a password: {used}")
    status(town.stranger().get(fresh), 404)
    status(town.stranger().get("/join/" + "0" * 64), 404)
    return "404"


def attack_guessing_codes(world):
    """pairing codes and sign-in codes, a hundred each"""
    town = world.own_town()
    stranger = town.stranger()
    got = [stranger.tell("/api/v1/stations/pair", {"code": f"AAAA{n:04}", "name": "x"}).status for n in range(40)]
    refuse(got.count(403) <= 12 and got[-1] == 429, f"answers {got}")
    token = town.programs.run("user", "token", "--data-dir", town.data, "--school", "North", "--station", "lab").stdout.strip()
    station = town.stranger(token=token)
    ada = town.browser("ada")
    ada.press("/sign-in-code", page="/")
    code = re.search(r'code-to-type">([^<]+)<', ada.get("/sign-in-code").text).group(1)
    honest(station.tell("/api/v1/stations/sign-in", {"code": code}).status == 200, "the right code signs in")
    got = [station.tell("/api/v1/stations/sign-in", {"code": f"A{n:05}"}).status for n in range(40)]
    refuse(got.count(403) <= 21 and got[-1] == 429, f"answers {got}")
    status(station.tell("/api/v1/stations/sign-in", {"code": code}), 429)
    return "10 pairing codes and 20 sign-in codes, then 429"


def attack_common_passwords(world):
    """passwords that everybody tries, one's own name, address and school, runs and repetitions, and short ones"""
    town = world.own_town()
    ada = town.browser("ada")
    bad = ["password123", "1234567890", "qwertyuiop", "aaaaaaaaaaaa", "Ada@example.org", "ada.example", "north north", "letmein1234", "short", "abcdefghijkl", "Passw0rd123", "iloveyou1234", "1q2w3e4r5t", "metallica1", "strawberry"]
    got = {}
    for word in bad:
        answer = ada.press("/account/password", {"old": PASSWORD, "password": word, "again": word})
        if answer.status == 429:
            # Ten at a time may be tried: the others are tried at a link.
            answer = by_link(town, word)
        got[word[:20]] = answer.status
    taken = [word for word, code in got.items() if code == 303]
    refuse(not taken, f"taken: {taken}")
    refuse(set(got.values()) == {422}, f"answers {got}")
    honest(town.browser("ben").press("/account/password", {"old": PASSWORD, "password": NEW, "again": NEW}).status == 303, "a good one is taken")
    return f"{len(got)} refused"


def by_link(town, word):
    link = re.search(r"/join/[0-9A-Za-z_-]+", town.browser("head").press(f"/people/{town.person('ada')}/link").text).group(0)
    return town.stranger().press(link, {"password": word, "again": word}, page=link)


def attack_sign_ins_that_nobody_sees(world):
    """wrong passwords and a flood, then the audit log and the log are searched for them and for what was typed"""
    town = world.own_town()
    stranger = town.stranger()
    guesses(stranger, 15)
    stranger.sign_in("my-secret-password", "typed")
    lines = town.rows("SELECT action, object, details FROM audit_log WHERE action LIKE 'sign_in.%'")
    failed = [line for line in lines if line[0] == "sign_in.failed"]
    refuse(len(failed) >= 10 and any(line[0] == "sign_in.blocked" for line in lines), f"{lines}")
    refuse("secret" not in repr(lines) and "guess 1" not in repr(lines) + town.log(), "what was typed is in a log")
    refuse("sign-in failed" in town.log() or stranger.address in town.log(), "the log knows nothing")
    honest(town.browser("ada") and town.rows("SELECT 1 FROM audit_log WHERE action = 'person.signed_in'"), "a sign-in is there, too")
    return f"{len(failed)} failed and the flood in the audit log, without what was typed"


def attack_password_alone(world):
    """an administrator's account with nothing but the password"""
    town = world.own_town()
    answer = town.stranger().sign_in("head@example.org")
    honest(answer.status in (200, 303), f"the password is right: {answer}")
    page = town.browser("head").get("/account").text.lower()
    refuse("second factor" in page or "passkey" in page or "authenticator" in page, "no second factor can be set up")
    return "a second factor can be asked for"


@alone
def attack_strangers_at_the_door(world):
    """300 strangers who guess at once with addresses that nobody has; limits: who signed in before waits 3 s, no row of the audit log each"""
    town = world.own_town()
    hers = town.stranger(address=town.browser("ada").address)
    rows = town.one("SELECT count(*) FROM audit_log")

    def guess(number):
        return town.stranger(timeout=120).sign_in(f"nobody{number}@example.org", "a wrong password").status

    with concurrent.futures.ThreadPoolExecutor(100) as pool:
        guesses = pool.map(guess, range(300))
        time.sleep(1)
        again, took = world.within(3, lambda: hers.sign_in("ada@example.org"), "signing in again")
        got = set(guesses)
    honest(again.status == 303, f"she is in: {again}")
    refuse(got <= {401, 408, 429, 503}, f"answers {got}")
    grown = town.one("SELECT count(*) FROM audit_log") - rows
    refuse(grown < 10, f"{grown} rows in the audit log")
    honest(town.one("SELECT sum(tries) FROM unknown_sign_ins") > 0, "they are counted")
    return f"{sorted(got)}, she waits {took:.1f} s"
