-- Statements about attempts, for the learning record store (xAPI) of a school.
CREATE TABLE record_stores (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL REFERENCES schools (id),
    endpoint TEXT COLLATE "C" NOT NULL, -- to which /statements is appended
    user_name TEXT COLLATE "C" NOT NULL,
    password_sealed BYTEA NOT NULL, -- opens with the key file, for this row only
    version TEXT COLLATE "C" NOT NULL CHECK (version IN ('1.0.3', '2.0.0')),
    ground TEXT COLLATE "C" CHECK (length(trim(ground)) > 0), -- the legal ground; absent: the consent of each person
    names BOOLEAN NOT NULL DEFAULT FALSE, -- statements contain names beside pseudonyms
    made_at BIGINT NOT NULL,
    disabled_at BIGINT,
    refused_at BIGINT, -- since when it refuses this service, which then sends nothing
    refusal TEXT COLLATE "C",
    UNIQUE (school_id, id)
);

CREATE UNIQUE INDEX record_stores_in_use ON record_stores (school_id) WHERE disabled_at IS NULL;

CREATE TABLE record_consents (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    person_id UUID NOT NULL,
    store_id UUID NOT NULL,
    wording TEXT COLLATE "C" NOT NULL CHECK (length(trim(wording)) > 0), -- what was agreed to
    given_at BIGINT NOT NULL,
    withdrawn_at BIGINT,
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, store_id) REFERENCES record_stores (school_id, id)
);

CREATE UNIQUE INDEX record_consents_given ON record_consents (school_id, person_id, store_id) WHERE withdrawn_at IS NULL;
CREATE INDEX record_consents_by_store ON record_consents (school_id, store_id);
CREATE INDEX record_consents_by_person ON record_consents (school_id, person_id);

CREATE TABLE statements (
    store_id UUID NOT NULL,
    id UUID NOT NULL, -- of the statement (UUIDv5)
    school_id UUID NOT NULL,
    person_id UUID NOT NULL,
    body TEXT COLLATE "C", -- JSON, until it is sent
    state TEXT COLLATE "C" NOT NULL CHECK (state IN ('waiting', 'sent', 'stopped')),
    tries BIGINT NOT NULL DEFAULT 0,
    next_run_at BIGINT NOT NULL,
    last_answer TEXT COLLATE "C", -- of the store, shortened
    made_at BIGINT NOT NULL,
    sent_at BIGINT,
    person_erased BOOLEAN NOT NULL DEFAULT FALSE, -- the person was erased here
    PRIMARY KEY (store_id, id),
    FOREIGN KEY (school_id, store_id) REFERENCES record_stores (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    CHECK ((state = 'sent') = (body IS NULL)),
    CHECK ((state = 'sent') = (sent_at IS NOT NULL))
);

CREATE INDEX statements_due ON statements (store_id, next_run_at) WHERE state = 'waiting';
CREATE INDEX statements_by_state ON statements (school_id, store_id, state, made_at);
CREATE INDEX statements_by_person ON statements (school_id, person_id, made_at);
CREATE INDEX statements_of_erased ON statements (school_id, made_at) WHERE person_erased;
