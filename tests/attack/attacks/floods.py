"""Much of something small: fields, sign-ins, uploads, connections, half requests, slow readers."""

import concurrent.futures
import os
import socket
import time

from attacks.bombs import costly_scene
from visitor import CutOff, Visitor, own_address
from verdict import alone, honest, refuse, status


def at_once(count, work):
    with concurrent.futures.ThreadPoolExecutor(count) as pool:
        return list(pool.map(work, range(count)))


@alone
def attack_form_of_many_fields(world):
    """150 000 fields of 1.9 MB in one form, signed in and as a stranger, eight at once; limit: an honest page 1 s"""
    town = world.town
    ada = town.browser("ada")
    stranger = town.stranger()
    csrf, theirs = ada.csrf(), stranger.csrf("/login")
    fields = "&email=aaaaaaa" * 150_000
    kind = {"Content-Type": "application/x-www-form-urlencoded"}
    honest(ada.form("/account/language", {"csrf": csrf, "language": "en"}).status == 303, "a form is taken")
    with world.watch(town, "ben") as watched:
        got = at_once(8, lambda n: (ada if n % 2 else stranger).send(
            "POST", "/account/language" if n % 2 else "/login", f"csrf={csrf if n % 2 else theirs}{fields}", kind).status)
    refuse(set(got) <= {400, 413}, f"answers {got}")
    return f"{sorted(set(got))}; {world.hold(watched, 200)}"


@alone
def attack_preview_of_a_costly_scene(world):
    """a draft's preview of a scene that takes minutes, four times, by one instructor; limit: an honest page 1 s, and 30 s of work"""
    town = world.own_town()
    teacher = town.browser("teacher")
    begun = teacher.press("/drafts", {"exercise": "only", "id": "costly", "title": "Costly"}, page="/drafts")
    honest(begun.status == 303, f"a draft is begun: {begun}")
    page = begun.header("location")
    document = town.template.exercise.read_text()
    scene = (town.template.exercise.parent.parent / "scenes/lower-back-training.toml").read_text()
    fields = {"document": document, "scene": scene}
    csrf = teacher.csrf()
    first = teacher.form(f"{page}/preview", {"csrf": csrf, **fields})
    honest(first.status == 200, f"an honest preview: {first}")
    costly = costly_scene(scene, "axisymmetric")
    many = document.replace("time_limit_s = ", "time_limit_s = 3600 # ", 1)
    begun = cpu_s(town)

    def ask(number):
        try:
            return teacher.form(f"{page}/preview", {"csrf": csrf, "document": f"{many}\n# {number}\n", "scene": f"{costly}\n# {number}\n"}).status
        except CutOff as error:
            return str(error)

    with world.watch(town, "ben") as watched:
        got = at_once(4, ask)
    left = cpu_s(town)
    time.sleep(5)
    after = cpu_s(town) - left
    refuse(after < 0.3, f"it goes on computing when nobody waits: {after:.1f} s of 5 s; answers {got}")
    return f"{got}, {left - begun:.0f} s of work; {world.hold(watched)}"


def cpu_s(town):
    """What the service has computed so far, in s."""
    fields = open(f"/proc/{town.service.child.pid}/stat").read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / 100


@alone
def attack_fifty_sign_ins(world):
    """fifty sign-ins at once, twice, half of unknown addresses; limit: 150 MB, an honest page 1 s"""
    town = world.own_town()
    honest(town.browser("ada"), "she is signed in")

    def sign_in(number):
        email = f"{'ben' if number % 2 else 'nobody'}{'' if number % 2 else number}@example.org"
        return town.stranger(timeout=120).sign_in(email, "a wrong password").status

    with world.watch(town, "teacher") as watched:
        got = at_once(50, sign_in) + at_once(50, sign_in)
    refuse(set(got) <= {401, 408, 429, 503}, f"answers {set(got)}")
    return f"{sorted(set(got))}; {world.hold(watched, 150)}"


def attack_uploads_begun(world):
    """500 uploads of 511 MB begun by one trainee; limit: 32, and 4 GB announced"""
    town = world.own_town()
    ada = town.program("ada")
    honest(ada.tus("POST", upload_length=1000).status == 201, "one is begun")
    got = [ada.tus("POST", upload_length=511_000_000).status for _ in range(60)]
    taken = got.count(201)
    refuse(taken * 511_000_000 <= 4_000_000_000 and set(got) <= {201, 429}, f"{taken} taken: {set(got)}")
    got = [ada.tus("POST", upload_length=1).status for _ in range(60)]
    refuse(taken + got.count(201) <= 32, f"{taken + got.count(201)} uploads begun")
    honest(town.program("ben").tus("POST", upload_length=1000).status == 201, "others may begin one")
    status(ada.tus("POST", upload_length=10**15), 413, 429)
    return f"{taken} large and {got.count(201)} small ones, then 429"


def attack_disk_filled(world):
    """uploads when the disk is down to its reserve"""
    town = world.own_town("--reserve-mb", "100000000")
    tape = world.recording()
    answer = world.upload("ada", tape, town)
    status(answer, 507)
    status(town.program("ada").tus("POST", upload_length=1000), 507)
    honest(world.upload("ada", tape).status == 201, "elsewhere it is taken")
    honest(town.browser("ada").get("/account").status == 200, "pages are read")
    return f"507: {answer.json.get('title', '')}"


@alone
def attack_room_promised_twice(world):
    """uploads begun by several trainees for more than the disk has above its reserve, filled in pieces; an honest page 1 s"""
    disk = os.statvfs(world.programs.folder)
    room = 90_000_000
    town = world.own_town("--reserve-mb", str((disk.f_bavail * disk.f_frsize - room) // 1_000_000))
    begun = [(name, town.program(name).tus("POST", upload_length=25_000_000)) for name in ("ada", "ben", "eve") * 4]
    taken = [(name, answer.header("location")) for name, answer in begun if answer.status == 201]
    honest(taken, "a first one is begun")
    refuse(len(taken) * 25_000_000 <= room, f"{len(taken)} of 25 MB were promised {room // 1_000_000} MB")
    refuse({answer.status for _, answer in begun} <= {201, 507}, f"answers {[answer.status for _, answer in begun]}")
    piece = os.urandom(25_000_000)
    for name, place in taken:
        filled = town.program(name).tus("PATCH", place, piece, upload_offset=0)
        refuse(filled.status in (204, 422, 507), f"a piece: {filled}")
    honest(town.browser("ada").get("/account").status == 200, "she signs in when it is full")
    for name, place in taken:
        honest(town.program(name).tus("DELETE", place).status in (204, 404, 410), "an upload is ended")
    honest(town.program("ada").tus("POST", upload_length=25_000_000).status == 201, "there is room again")
    return f"{len(taken)} of 12 begun, then 507"


def attack_ballast(world):
    """a valid recording with attachments that no document names, again and again; limits of a trainee's share"""
    town = world.own_town("--person-attempts", "3")
    ballast = world.recording()
    ballast.attachments.append(("mesh/ballast.stl", "model/stl", os.urandom(2_000_000)))
    status(world.upload("ada", ballast, town), 422)
    got = [world.upload("ada", world.recording(), town).status for _ in range(5)]
    refuse(got == [201, 201, 201, 429, 429], f"answers {got}")
    honest(world.upload("ben", world.recording(), town).status == 201, "others may bring theirs")
    return f"422, and {got}"


@alone
def attack_slow_heads(world):
    """600 connections from one address that send half a head; limit: an honest page of another address 1 s"""
    town = world.own_town()
    address, held = own_address(), []
    honest(town.browser("ben"), "he is signed in")

    def hold(_):
        try:
            one = socket.create_connection(town.service.place, timeout=5, source_address=(address, 0))
            one.sendall(b"GET /login HTTP/1.1\r\nHost: x\r\nX-A")
            return one
        except OSError:
            return None

    with world.watch(town, "ben") as watched:
        for n in range(600):
            held.append(hold(n))
        time.sleep(2)
        said = world.hold(watched, 100)
    alive = sum(is_open(one) for one in held if one)
    refuse(alive <= 256, f"one address holds {alive} connections")
    ends = time.monotonic() + 25 * world.slack
    while alive and time.monotonic() < ends:
        time.sleep(0.5)
        alive = sum(is_open(one) for one in held if one)
    [one.close() for one in held if one]
    refuse(alive == 0, f"{alive} are held for longer than 25 s")
    return f"closed within their time; {said}"


def is_open(one):
    """Whether the other end still holds a connection."""
    try:
        one.settimeout(0.0)
        return one.recv(65536) != b""
    except BlockingIOError:
        return True
    except OSError:
        return False


@alone
def attack_half_bodies(world):
    """bodies that stop after a byte, and those of forms and calls that trickle; limit: given up within 75 s"""
    town = world.own_town()
    token = town.template.tokens["ada"]
    heads = [f"POST /api/v1/{path} HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer {token}\r\nContent-Type: {kind}\r\nContent-Length: 100000\r\n\r\n{{".encode()
             for path, kind in (("sessions", "application/octet-stream"), ("stations/pair", "application/json"), ("stations/sign-in", "application/json"))]
    heads.append(b"POST /login HTTP/1.1\r\nHost: x\r\nContent-Type: application/x-www-form-urlencoded\r\nContent-Length: 90000\r\n\r\na")
    held = []
    for number in range(100):
        one = socket.create_connection(town.service.place, timeout=5, source_address=(own_address(), 0))
        one.sendall(heads[number % 4])
        held.append(one)
    begun = time.monotonic()
    with world.watch(town, "ben") as watched:
        left = list(held)
        while left and time.monotonic() - begun < 75 * world.slack:
            # Who brings a recording may take an hour, as long as something arrives.
            [trickle(one) for number, one in enumerate(held) if number % 8 in (1, 2, 3) and one in left]
            time.sleep(1)
            left = [one for one in left if is_open(one)]
    [one.close() for one in held]
    refuse(not left, f"{len(left)} of 100 are held after {time.monotonic() - begun:.0f} s")
    return f"all given up after {time.monotonic() - begun:.0f} s; {world.hold(watched, 100)}"


def trickle(one):
    try:
        one.settimeout(0.2)
        one.sendall(b"a")
    except OSError:
        pass


@alone
def attack_slow_readers(world):
    """forty readers of ?with=comments and of a table that take a byte now and then; limit: 250 MB, an honest page 1 s"""
    town = world.own_town()
    session = world.scored("ada", town, world.expert())
    ada = town.browser("ada")
    for n in range(5):
        ada.press(f"/sessions/{session}/comments", {"kind": "question", "from_s": str(n), "body": "why? " * 100})
    path = f"/api/v1/sessions/{session}/recording?with=comments"
    whole = town.program("ada").get(path)
    honest(whole.status == 200 and len(whole.body) > 100_000, f"it is there: {whole.status}")
    held, token = [], town.template.tokens["ada"]
    with world.watch(town, "ben") as watched:
        for n in range(80):
            one = socket.socket()
            one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            one.bind((own_address(), 0))
            one.settimeout(10)
            one.connect(town.service.place)
            asked = path if n % 2 else "/api/v1/sessions?limit=100"
            one.sendall(f"GET {asked} HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer {token}\r\n\r\n".encode())
            held.append(one)
        time.sleep(4)
    [one.close() for one in held]
    return world.hold(watched, 250)


def attack_long_heads(world):
    """heads of 1 MB, 10 000 headers, addresses of 100 kB"""
    town = world.town
    for headers, path in (({"X-Long": "x" * 1_000_000}, "/login"), ({f"X-{n}": "1" for n in range(10_000)}, "/login"), ({}, "/login?" + "x" * 100_000)):
        try:
            status(town.stranger().get(path, headers), 400, 414, 431)
        except CutOff:
            pass
    honest(town.stranger().get("/login").status == 200, "a page is there")
    return "400, 414, 431 or cut off"


def attack_requests_that_smuggle(world):
    """two lengths, a length beside chunks, bare line feeds, a second request in a body"""
    town = world.town
    for head in (b"Content-Length: 5\r\nContent-Length: 6", b"Content-Length: 5\r\nTransfer-Encoding: chunked", b"Transfer-Encoding: chunked\r\nTransfer-Encoding: identity",
                 b"Content-Length: -1", b"Content-Length: +5", b"Transfer-Encoding: xchunked"):
        with socket.create_connection(town.service.place, timeout=10) as one:
            one.sendall(b"POST /login HTTP/1.1\r\nHost: x\r\n" + head + b"\r\n\r\n0\r\n\r\nGET /metrics HTTP/1.1\r\nHost: x\r\n\r\n")
            answer = read_all(one)
        refuse(b"stylet_build_info" not in answer, f"{head}: a second request was read out of the body")
        refuse(answer == b"" or answer.split()[1][:1] in (b"4",), f"{head}: {answer[:100]}")
    honest(town.stranger().get("/login").status == 200, "a page is there")
    return "400 or cut off"


def read_all(one):
    data = b""
    try:
        one.settimeout(2)
        while part := one.recv(65536):
            data += part
    except OSError:
        pass
    return data


def attack_two_brakes_at_once(world):
    """a hundred requests at once from each of three people while a fourth works; limit: an honest page 1 s"""
    town = world.own_town()
    paths = ["/", "/account", "/curricula", "/assignments"]
    browsers = [town.browser(name) for name in ("ada", "teacher", "head")]
    with world.watch(town, "ben") as watched:
        got = at_once(12, lambda n: [Visitor(town.service, cookies=dict(browsers[n % 3].cookies)).get(paths[i % 4]).status for i in range(25)])
    honest(all(set(one) == {200} for one in got), f"answers {got}")
    return world.hold(watched, 150, most_s=2.0)
