-- Passkeys (WebAuthn): public keys, each with its name, as a second factor. Nothing here is secret.
CREATE TABLE passkeys (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    name TEXT NOT NULL,
    credential_id BLOB NOT NULL UNIQUE, -- the authenticator's own name of it: nobody else's, whatever their school
    public_key TEXT NOT NULL, -- in JSON: the key, its counter, and what the authenticator said of itself
    sign_count INTEGER NOT NULL, -- signatures it has counted; 0 where it counts none
    made_at INTEGER NOT NULL,
    last_used_at INTEGER, -- absent: not since it was made
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX passkeys_by_person ON passkeys (school_id, person_id);
