-- A training station is a token of its own: when it was last seen, and how many wrong sign-in codes it has passed on.
ALTER TABLE api_tokens ADD COLUMN last_seen_at INTEGER;
ALTER TABLE api_tokens ADD COLUMN wrong_codes INTEGER NOT NULL DEFAULT 0;
ALTER TABLE api_tokens ADD COLUMN wrong_since INTEGER;
-- Two stations of one name could not be told apart in the audit log.
CREATE UNIQUE INDEX stations_by_name ON api_tokens (school_id, station) WHERE revoked_at IS NULL;

-- Codes by which a station joins a school. A used one is deleted.
CREATE TABLE pairing_codes (
    code_sha256 BLOB PRIMARY KEY NOT NULL CHECK (length(code_sha256) = 32),
    school_id BLOB NOT NULL,
    made_by BLOB NOT NULL,
    expires_at INTEGER NOT NULL,
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id)
) STRICT;

-- Codes by which trainees sign in at a station of their school, one each. The hash is a slow one, salted with the
-- school, so that a person can be found by their code and a copy of this file does not tell it.
CREATE TABLE sign_in_codes (
    school_id BLOB NOT NULL,
    person_id BLOB PRIMARY KEY NOT NULL,
    code_hash BLOB NOT NULL CHECK (length(code_hash) = 32),
    made_at INTEGER NOT NULL,
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    UNIQUE (school_id, code_hash)
) STRICT;
