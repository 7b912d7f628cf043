"""The code of now that an app makes of a secret (RFC 6238: SHA-1, six digits, 30 s), from the standard library alone.

    totp.py SECRET      the secret in base32, groups and spaces allowed
"""

import base64
import hashlib
import hmac
import struct
import sys
import time


def code(secret: str, at: float) -> str:
    text = "".join(letter for letter in secret.upper() if letter.isalnum())
    key = base64.b32decode(text + "=" * (-len(text) % 8))
    digest = hmac.new(key, struct.pack(">Q", int(at) // 30), hashlib.sha1).digest()
    offset = digest[-1] & 15
    number = struct.unpack(">I", digest[offset : offset + 4])[0] & 0x7FFFFFFF
    return f"{number % 1_000_000:06}"


if __name__ == "__main__":
    print(code(sys.argv[1], time.time()))
