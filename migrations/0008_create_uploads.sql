-- Uploads that arrive in pieces (tus). The bytes lie in the uploads folder under the row's id; only the first
-- `received` of them are known to be on the disk, and whatever the file holds beyond is as if it had never arrived.
CREATE TABLE uploads (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    person_id BLOB, -- begun with a person's token, or
    station_id BLOB, -- with a station's
    length INTEGER NOT NULL, -- bytes in all
    received INTEGER NOT NULL DEFAULT 0,
    metadata TEXT NOT NULL, -- Upload-Metadata as it was sent
    expires_at INTEGER NOT NULL,
    session_id BLOB, -- the attempt it has become
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, station_id) REFERENCES api_tokens (school_id, id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    CHECK ((person_id IS NULL) <> (station_id IS NULL)),
    CHECK (received BETWEEN 0 AND length),
    CHECK (session_id IS NULL OR received = length)
) STRICT;

-- What the foreign key to a station needs.
CREATE UNIQUE INDEX api_tokens_by_school ON api_tokens (school_id, id);
CREATE INDEX uploads_by_expiry ON uploads (expires_at);
