-- What people say about a moment of an attempt, and what is answered. One that is taken back stays, unseen.
CREATE TABLE comments (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    session_id BLOB NOT NULL,
    author_id BLOB NOT NULL,
    answers BLOB, -- the comment that this one answers; else this one has a kind and a moment
    kind TEXT CHECK (kind IN ('praise', 'error', 'question', 'teaching')),
    from_s REAL CHECK (from_s >= 0), -- since the start of the attempt
    to_s REAL CHECK (to_s >= from_s), -- absent: a moment
    body TEXT NOT NULL CHECK (length(trim(body)) > 0),
    made_at INTEGER NOT NULL,
    withdrawn_at INTEGER,
    UNIQUE (school_id, session_id, id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    FOREIGN KEY (school_id, author_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, session_id, answers) REFERENCES comments (school_id, session_id, id),
    CHECK ((answers IS NULL) = (kind IS NOT NULL)),
    CHECK ((answers IS NULL) = (from_s IS NOT NULL))
) STRICT;

CREATE INDEX comments_by_session ON comments (school_id, session_id, made_at, id);

-- Experts who let their attempts be shown to others, as one curve among at least five. Consent may be taken back.
CREATE TABLE expert_consents (
    school_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    given_at INTEGER NOT NULL,
    recorded_by BLOB NOT NULL, -- themselves, or the administrator to whom they gave it
    note TEXT NOT NULL, -- how it was given
    PRIMARY KEY (school_id, person_id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, recorded_by) REFERENCES people (school_id, id)
) STRICT;
