-- Statements about attempts, for the learning record store (xAPI) of a school.
CREATE TABLE record_stores (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    endpoint TEXT NOT NULL, -- to which /statements is appended
    user_name TEXT NOT NULL,
    password_sealed BLOB NOT NULL, -- opens with the key file, for this row only
    version TEXT NOT NULL CHECK (version IN ('1.0.3', '2.0.0')),
    ground TEXT CHECK (length(trim(ground)) > 0), -- the legal ground; absent: the consent of each person
    names INTEGER NOT NULL DEFAULT 0 CHECK (names IN (0, 1)), -- statements contain names beside pseudonyms
    made_at INTEGER NOT NULL,
    disabled_at INTEGER,
    refused_at INTEGER, -- since when it refuses this service, which then sends nothing
    refusal TEXT,
    UNIQUE (school_id, id)
) STRICT;

CREATE UNIQUE INDEX record_stores_in_use ON record_stores (school_id) WHERE disabled_at IS NULL;

CREATE TABLE record_consents (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    store_id BLOB NOT NULL,
    wording TEXT NOT NULL CHECK (length(trim(wording)) > 0), -- what was agreed to
    given_at INTEGER NOT NULL,
    withdrawn_at INTEGER,
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, store_id) REFERENCES record_stores (school_id, id)
) STRICT;

CREATE UNIQUE INDEX record_consents_given ON record_consents (school_id, person_id, store_id) WHERE withdrawn_at IS NULL;
CREATE INDEX record_consents_by_store ON record_consents (school_id, store_id);
CREATE INDEX record_consents_by_person ON record_consents (school_id, person_id);

CREATE TABLE statements (
    store_id BLOB NOT NULL,
    id BLOB NOT NULL CHECK (length(id) = 16), -- of the statement (UUIDv5)
    school_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    body TEXT, -- JSON, until it is sent
    state TEXT NOT NULL CHECK (state IN ('waiting', 'sent', 'stopped')),
    tries INTEGER NOT NULL DEFAULT 0,
    next_run_at INTEGER NOT NULL,
    last_answer TEXT, -- of the store, shortened
    made_at INTEGER NOT NULL,
    sent_at INTEGER,
    person_erased INTEGER NOT NULL DEFAULT 0 CHECK (person_erased IN (0, 1)), -- the person was erased here
    PRIMARY KEY (store_id, id),
    FOREIGN KEY (school_id, store_id) REFERENCES record_stores (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    CHECK ((state = 'sent') = (body IS NULL)),
    CHECK ((state = 'sent') = (sent_at IS NOT NULL))
) STRICT, WITHOUT ROWID;

CREATE INDEX statements_due ON statements (store_id, next_run_at) WHERE state = 'waiting';
CREATE INDEX statements_by_state ON statements (school_id, store_id, state, made_at);
CREATE INDEX statements_by_person ON statements (school_id, person_id, made_at);
CREATE INDEX statements_of_erased ON statements (school_id, made_at) WHERE person_erased;
