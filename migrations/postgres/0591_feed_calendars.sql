-- Calendars of due dates at a secret address, one per person. Only the hash of the secret is stored.
CREATE TABLE calendar_feeds (
    person_id UUID PRIMARY KEY NOT NULL,
    school_id UUID NOT NULL,
    secret_sha256 BYTEA NOT NULL UNIQUE CHECK (length(secret_sha256) = 32),
    made_at BIGINT NOT NULL,
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
);

CREATE INDEX calendar_feeds_by_person ON calendar_feeds (school_id, person_id);
