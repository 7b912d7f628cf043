"""Uploads a recording with tuspy as its README does it: upload_by_tus.py URL TOKEN FILE. Prints the address of the upload."""

import sys

from tusclient import client

url, token, path = sys.argv[1:]
service = client.TusClient(f"{url}/api/v1/uploads", headers={"Authorization": f"Bearer {token}"})
# No metadata, and pieces small enough that there are several.
uploader = service.uploader(path, chunk_size=100_000)
uploader.upload()
assert uploader.offset == uploader.get_file_size(), "not all of it was sent"
print(uploader.url)
