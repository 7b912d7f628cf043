"""Learning platforms and learning record stores: forged launches, and addresses inside the network of the service."""

import base64
import json
import socket

from verdict import honest, refuse, status

ORIGIN = "https://training.example.org"
LAUNCH = {"iss": "https://lms.example.edu", "client_id": "c", "login_hint": "1"}


class Listener:
    """A port of this machine to which the service has no reason to connect."""

    def __enter__(self):
        self.socket = socket.create_server(("127.0.0.1", 0))
        self.socket.settimeout(0.5)
        self.port = self.socket.getsockname()[1]
        return self

    def __exit__(self, *_):
        self.socket.close()

    def was_called(self):
        try:
            self.socket.accept()[0].close()
        except TimeoutError:
            return False
        return True


def registration(at, **changes):
    """The form of a learning platform whose services have this address."""
    form = {"name": "Canvas", "issuer": LAUNCH["iss"], "client_id": LAUNCH["client_id"]}
    return form | {"auth_url": f"{at}/a", "token_url": f"{at}/t", "keys_url": f"{at}/k"} | changes


def forged(claims, algorithm="none"):
    """A token that nobody has signed."""
    parts = [{"alg": algorithm, "typ": "JWT", "kid": "1"}, claims]
    return ".".join(base64.urlsafe_b64encode(json.dumps(part).encode()).decode().rstrip("=") for part in parts) + "."


def attack_forged_launch(world):
    """a launch without a signature, with a state of one's own and with that of another browser; a launch that names another host"""
    town = world.own_town("--public-url", ORIGIN)
    made = town.browser("head").press("/admin/platforms", registration("https://lms.example.edu"))
    honest(made.status == 303, f"a platform is registered: {made}")
    victim, thief = town.stranger(), town.stranger()
    begun = victim.form("/lti/login", LAUNCH | {"target_link_uri": f"{ORIGIN}/lti/launch"})
    honest("lms.example.edu/a" in begun.text + begun.header("location") + begun.header("refresh"), f"a launch begins: {begun}")
    state = (begun.text + begun.header("location") + begun.header("refresh")).partition("state=")[2].partition("&")[0]
    honest(len(state) > 20, f"it has a state: {begun}")
    claims = {"iss": LAUNCH["iss"], "aud": "c", "sub": "1", "nonce": "x", "exp": 4_000_000_000, "iat": 1}
    for visitor, sent in ((thief, state), (thief, "0" * len(state)), (victim, state)):
        for algorithm in ("none", "HS256", "RS256"):
            answer = visitor.form("/lti/launch", {"state": sent, "id_token": forged(claims, algorithm)})
            refuse(answer.status in (200, 403, 503) and visitor.get("/").status == 303, f"{algorithm}: {answer}")
    status(town.stranger().form("/lti/login", LAUNCH | {"target_link_uri": "https://evil.example/"}), 400, 403)
    refuse(town.one("SELECT count(*) FROM identities") == 0, "an account has a new identity")
    return "nobody is signed in, and no account was made"


def attack_addresses_of_the_inner_network(world):
    """keys, tokens, a record store and a registration at addresses of this machine, of the network, and of a cloud's metadata"""
    town = world.own_town()
    head = town.browser("head")
    register = "/lti/register?registration_token=t&openid_configuration="
    record_store = {"user_name": "u", "password": "p", "version": "1.0.3", "ground": "A trial"}
    with Listener() as inner:
        places = (f"https://127.0.0.1:{inner.port}", f"http://127.0.0.1:{inner.port}", f"https://[::ffff:127.0.0.1]:{inner.port}",
                  f"https://localhost:{inner.port}", f"https://2130706433:{inner.port}", "http://169.254.169.254")
        for number, place in enumerate(places):
            head.press("/admin/platforms", registration(place, client_id=f"c{number}"))
            head.press("/admin/learning-records", record_store | {"endpoint": f"{place}/xAPI"})
            asked = head.get(f"{register}{place}/configuration")
            refuse(asked.status in (200, 422), f"{place}: {asked}")
            launched = town.stranger().form("/lti/login", LAUNCH | {"client_id": f"c{number}", "target_link_uri": "/"})
            refuse(launched.status < 500, f"{place}: {launched}")
        refuse(not inner.was_called(), "the service connects to its own machine")
        open_town = world.own_town("--allow-private-addresses")
        open_town.browser("head").get(f"{register}https://127.0.0.1:{inner.port}/configuration")
        honest(inner.was_called(), "a service that may connects")
    return f"no connection to any of {len(places)} addresses"


def attack_records_without_consent(world):
    """a trainee gives another's consent; an instructor switches the record store on and reads who was erased"""
    town = world.own_town()
    own = town.browser("ada").press("/account/learning-records", {"consent": "given", "person": town.person("ben")})
    refuse(town.one("SELECT count(*) FROM record_consents WHERE person_id = (SELECT id FROM people WHERE email = 'ben@example.org')") == 0,
           f"ada has consented for ben: {own}")
    form = {"endpoint": "https://lrs.example.edu", "user_name": "u", "password": "p", "version": "1.0.3", "ground": "A trial"}
    for name in ("teacher", "ada"):
        status(town.browser(name).press("/admin/learning-records", form), 403)
        status(town.browser(name).get("/admin/learning-records/erased.txt"), 403)
    honest(town.browser("head").press("/admin/learning-records", form).status == 303, "an administrator may")
    return "403 each"
