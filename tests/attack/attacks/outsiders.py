"""Strangers, other sites, and forms that did not come from a page of ours."""

import re

from attacks.belonging import routes
from verdict import honest, refuse, status


def attack_metrics_from_outside(world):
    """/metrics without a token behind a proxy, with a wrong one, in the query; the administrator's page as a trainee"""
    status(world.own_town("--behind-tls").stranger().get("/metrics"), 404)
    town = world.own_town("--behind-tls", "--metrics-token", "a-token-for-figures")
    status(town.stranger().get("/metrics"), 401)
    status(town.stranger(token="a-token-for-figure").get("/metrics"), 401)
    status(town.stranger().get("/metrics?token=a-token-for-figures"), 401)
    status(town.stranger(token=town.template.tokens["head"]).get("/metrics"), 401)
    honest(town.stranger(token="a-token-for-figures").get("/metrics").status == 200, "with the token they are there")
    status(world.town.browser("ada").get("/admin/service"), 403)
    return "404 without, 401 with a wrong one"


def attack_rows_by_looking(world):
    """three hundred views of /login, /forgotten and dead links by strangers without cookies; limit: no row"""
    town = world.own_town()
    count = lambda: town.one("SELECT count(*) FROM web_sessions")  # noqa: E731
    before = count()
    for n in range(300):
        town.stranger().get(("/login", "/forgotten", "/join/0")[n % 3])
    rows = count() - before
    visitor = town.stranger()
    honest(visitor.sign_in("ada@example.org").status == 303 and count() > before, "a sign-in is a row")
    refuse(rows == 0, f"{rows} rows")
    return "no row"


def attack_pages_as_a_stranger(world):
    """every page, form and call without signing in, with a made-up cookie and a made-up token"""
    town = world.own_town()
    session = world.scored("ada", town)
    open_to_all = re.compile(r"/(login|sign-in/|lti/(login|launch|register)|language|assets|recordings|healthz|readyz|\.well-known|metrics|join|forgotten|certificate$|calendar/|survey/)|/api/v1/(openapi|stations/pair)")
    listed = [one for one in routes(world, town, session) if not open_to_all.match(one[1])]
    honest(len(listed) > 60, f"only {len(listed)} routes are known")
    for visitor in (town.stranger(), town.stranger(cookies={"stylet_session": "AAAAAAAAAAAAAAAAAAAAAA"}), town.stranger(token="0" * 64)):
        for method, path, body in listed:
            answer = visitor.send(method, path, body, {"Content-Type": "application/x-www-form-urlencoded"} if body else None)
            expected = (401,) if path.startswith(("/api/", "/scim/")) else (303,)
            refuse(answer.status in expected and "Ada" not in answer.text, f"{method} {path}: {answer}")
            refuse(path.startswith(("/api/", "/scim/")) or answer.header("location").startswith("/login"), f"{path} leads to {answer.header('location')}")
    honest(town.browser("ada").get(f"/sessions/{session}").status == 200, "for her it is there")
    return f"{3 * len(listed)} requests: to the sign-in, or 401"


def attack_forms_without_their_token(world):
    """every form without its token, with another session's, and as text/plain or JSON, as an administrator and an instructor"""
    town = world.own_town()
    session = world.scored("ada", town)
    kind = "application/x-www-form-urlencoded"
    forms = [one for one in routes(world, town, session) if one[0] == "POST" and not one[1].startswith(("/api/", "/scim/", "/survey/"))]
    honest(len(forms) > 40, f"only {len(forms)} forms are known")
    theirs, tried = town.browser("eve").csrf(), 0
    audit = town.one("SELECT count(*) FROM audit_log")
    for name in ("head", "teacher", "ada"):
        visitor = town.browser(name)
        audit = town.one("SELECT count(*) FROM audit_log")
        for _, path, body in forms:
            for sent, content in ((body, kind), (f"csrf={theirs}&{body}", kind), (f"csrf={visitor.csrf()}&{body}", "text/plain"), ('{"csrf":"x"}', "application/json")):
                answer = visitor.send("POST", path, sent, {"Content-Type": content})
                tried += 1
                refuse(answer.status in (400, 403, 404, 415, 422), f"{path} as {name}, {content}: {answer}")
        refuse(town.one("SELECT count(*) FROM audit_log") == audit, f"something was done as {name}")
        honest(visitor.press("/account/language", {"language": "en"}).status == 303, "with its token a form is taken")
    return f"{tried} forged posts, nothing done"


def attack_other_sites(world):
    """requests that a page of another site makes: CORS of the API and of recordings, frames, and what a browser may guess"""
    town = world.own_town("--allow-origin", "https://lab.example.org")
    evil = {"Origin": "https://evil.example"}
    asks = {"Access-Control-Request-Method": "POST", "Access-Control-Request-Headers": "authorization"}
    for origin in ("https://evil.example", "null", "https://lab.example.org.evil.example", "http://lab.example.org"):
        for method, path in (("OPTIONS", "/api/v1/uploads"), ("GET", "/api/v1/sessions"), ("GET", "/account")):
            answer = town.program("ada").send(method, path, headers={"Origin": origin, **(asks if method == "OPTIONS" else {})})
            allowed = answer.header("access-control-allow-origin")
            refuse(allowed not in ("*", origin), f"{method} {path} from {origin}: {allowed}")
    good = town.program("ada").send("OPTIONS", "/api/v1/uploads", headers={"Origin": "https://lab.example.org", **asks})
    honest(good.header("access-control-allow-origin") == "https://lab.example.org", f"the origin that was allowed is: {good.headers}")
    page = town.browser("ada").get("/account", evil)
    wanted = {"x-content-type-options": "nosniff", "cross-origin-opener-policy": "same-origin", "cross-origin-resource-policy": "same-origin",
              "cache-control": "no-store", "referrer-policy": "same-origin"}
    for name, value in wanted.items():
        refuse(page.header(name) == value, f"{name}: {page.header(name)}")
    refuse("frame-ancestors 'none'" in page.header("content-security-policy") and page.header("permissions-policy"), "it may be framed")
    return "no origin but the one that was allowed; headers against frames and guesses"


def attack_words_of_the_inside(world):
    """answers to nonsense are searched for paths, SQL, traces and versions of libraries"""
    town = world.town
    ada, program = town.browser("ada"), town.program("ada")
    asked = [ada.get("/sessions/x"), ada.get("/sessions/00000000-0000-0000-0000-000000000000"), program.get("/api/v1/sessions?limit=-1"),
             program.tell("/api/v1/stations/sign-in", {"code": None}), program.upload(b"x"), program.tus("PATCH", "/api/v1/uploads/x"),
             ada.send("TRACE", "/"), ada.send("DELETE", "/account"), program.send("POST", "/api/v1/sessions/x/comments", "{", {"Content-Type": "application/json"})]
    for answer in asked:
        refuse(400 <= answer.status < 500, f"{answer}")
        for word in (str(town.data), "sqlx", "SELECT ", "panicked", ".rs:", "axum", "RUST_BACKTRACE"):
            refuse(word not in answer.text, f"it says {word}: {answer}")
        refuse(not answer.header("server") and not answer.header("x-powered-by"), "it names its program")
    honest(ada.get("/account").status == 200, "a page is there")
    return f"{len(asked)} answers, none tells of the inside"
