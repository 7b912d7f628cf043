-- A second factor: codes that an app makes of a secret (RFC 6238), and recovery codes for whoever has lost the app.
CREATE TABLE second_factors (
    person_id BLOB PRIMARY KEY NOT NULL,
    school_id BLOB NOT NULL,
    sealed_secret BLOB NOT NULL, -- nonce and ciphertext: a copy of this file makes no code
    made_at INTEGER NOT NULL,
    confirmed_at INTEGER, -- absent: offered, and not asked for yet
    last_step INTEGER NOT NULL DEFAULT 0, -- time step of the last code that was taken, in 30 s since 1970 UTC
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
) STRICT;

-- Slow hashes, salted with the person. A used one is deleted.
CREATE TABLE recovery_codes (
    school_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    code_hash BLOB NOT NULL CHECK (length(code_hash) = 32),
    PRIMARY KEY (person_id, code_hash),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
) STRICT;

-- Of whom a school asks for one.
ALTER TABLE schools ADD COLUMN second_factor_of TEXT NOT NULL DEFAULT 'nobody'
    CHECK (second_factor_of IN ('nobody', 'teachers'));

-- A mail may tell that a second factor was turned off: the same table with one more kind.
CREATE TABLE mails_again (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    kind TEXT NOT NULL CHECK (kind IN ('invitation', 'reset', 'reminder', 'second_factor_off')),
    assignment_id BLOB, -- of a reminder
    tries INTEGER NOT NULL DEFAULT 0,
    next_run_at INTEGER, -- absent: sent, or given up
    sent_at INTEGER,
    error TEXT,
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    CHECK ((kind = 'reminder') = (assignment_id IS NOT NULL))
) STRICT;

INSERT INTO mails_again (id, school_id, person_id, kind, assignment_id, tries, next_run_at, sent_at, error)
SELECT id, school_id, person_id, kind, assignment_id, tries, next_run_at, sent_at, error FROM mails;
DROP TABLE mails;
ALTER TABLE mails_again RENAME TO mails;

CREATE INDEX mails_by_time ON mails (next_run_at) WHERE next_run_at IS NOT NULL;
CREATE INDEX mails_by_person ON mails (school_id, person_id);
-- Each reminder once.
CREATE UNIQUE INDEX reminders_once ON mails (assignment_id, person_id) WHERE assignment_id IS NOT NULL;
