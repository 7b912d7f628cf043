-- Addresses under which a viewer elsewhere may read one recording for a short while. Only hashes are kept.
CREATE TABLE recording_links (
    token_sha256 BLOB PRIMARY KEY NOT NULL CHECK (length(token_sha256) = 32),
    school_id BLOB NOT NULL,
    session_id BLOB NOT NULL,
    made_by BLOB NOT NULL,
    expires_at INTEGER NOT NULL,
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX recording_links_by_expiry ON recording_links (expires_at);
