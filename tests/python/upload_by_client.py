"""Uploads a recording with a client that openapi-python-client has made of the API's own description, waits for the score, and reads
everything back through the lists: upload_by_client.py FOLDER URL TOKEN FILE. FOLDER is where the client was made."""

import json
import sys
import time
from pathlib import Path

folder, url, token, path = sys.argv[1:]
sys.path.insert(0, folder)

from stylet_client import AuthenticatedClient  # noqa: E402
from stylet_client.api.score import show_score  # noqa: E402
from stylet_client.api.sessions import list_sessions, show_session  # noqa: E402
from stylet_client.api.upload import upload_recording  # noqa: E402
from stylet_client.models import Graded, Problem  # noqa: E402
from stylet_client.types import File  # noqa: E402

client = AuthenticatedClient(base_url=f"{url}/api/v1", token=token)
with Path(path).open("rb") as recording:
    made = upload_recording.sync_detailed(client=client, body=File(payload=recording))
assert made.status_code == 201, made
session = made.parsed.session_id

for _ in range(300):
    score = show_score.sync(session, client=client)
    if isinstance(score, Graded):
        break
    time.sleep(0.1)
assert isinstance(score, Graded), score

page = list_sessions.sync(client=client, limit=1)
assert [listed.session_id for listed in page.sessions] == [session], page
assert show_session.sync(session, client=client).recording_sha256 == page.sessions[0].recording_sha256
stranger = AuthenticatedClient(base_url=f"{url}/api/v1", token="no token")
assert isinstance(show_session.sync(session, client=stranger), Problem), "a refusal is a problem"
print(json.dumps({"session": str(session), **score.to_dict()}))
