-- What lets somebody in. Only hashes are kept: a copy of this file opens no door.
CREATE TABLE api_tokens (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    person_id BLOB, -- a person's token, or
    station TEXT, -- a station's, which uploads for whoever the recording names
    token_sha256 BLOB NOT NULL UNIQUE CHECK (length(token_sha256) = 32),
    created_at INTEGER NOT NULL,
    revoked_at INTEGER,
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    CHECK ((person_id IS NULL) <> (station IS NULL))
) STRICT;

CREATE TABLE web_sessions (
    id_sha256 BLOB PRIMARY KEY NOT NULL CHECK (length(id_sha256) = 32),
    data TEXT NOT NULL, -- JSON
    expires_at INTEGER NOT NULL
) STRICT;

CREATE INDEX web_sessions_by_expiry ON web_sessions (expires_at);
