-- Grades for learning platforms: one row for each link and each of its users. What is sent is read from the grades when it is sent.
CREATE UNIQUE INDEX platform_links_by_school ON platform_links (school_id, id);

CREATE TABLE deliveries (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    kind TEXT NOT NULL CHECK (kind IN ('ags')),
    platform_id BLOB NOT NULL,
    link_id BLOB NOT NULL, -- whose line item gets the grade
    person_id BLOB NOT NULL,
    subject TEXT NOT NULL, -- the person, as the platform names them
    state TEXT NOT NULL CHECK (state IN ('waiting', 'idle', 'sent', 'stopped')),
    version INTEGER NOT NULL DEFAULT 0, -- grows whenever the grade may have changed
    tries INTEGER NOT NULL DEFAULT 0, -- since the last success or change
    next_run_at INTEGER,
    body TEXT, -- JSON: what the platform has, without its timestamp; absent: nothing, or unknown
    stamped_at INTEGER, -- timestamp of the last message, which may not have arrived
    last_status INTEGER, -- of HTTP
    last_answer TEXT CHECK (length(last_answer) <= 500), -- of a platform that refused
    made_at INTEGER NOT NULL,
    sent_at INTEGER,
    UNIQUE (school_id, link_id, subject),
    CHECK ((state = 'waiting') = (next_run_at IS NOT NULL)),
    FOREIGN KEY (school_id, platform_id) REFERENCES platforms (school_id, id),
    FOREIGN KEY (school_id, link_id) REFERENCES platform_links (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX deliveries_due ON deliveries (school_id, platform_id, next_run_at) WHERE next_run_at IS NOT NULL;
CREATE INDEX deliveries_by_state ON deliveries (school_id, platform_id, state, id);
CREATE INDEX deliveries_by_person ON deliveries (school_id, person_id);

-- A notice may tell that a grade was refused: the same table with one more kind.
CREATE TABLE notices_again (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    person_id BLOB NOT NULL, -- recipient
    kind TEXT NOT NULL CHECK (kind IN ('comment', 'question', 'answer', 'override', 'rating', 'assignment', 'delivery')),
    by_id BLOB NOT NULL, -- who did it, or whose grade it is
    session_id BLOB, -- the attempt; absent for an assignment, a grade and the person who asked for a round
    comment_id BLOB,
    assignment_id BLOB,
    round_id BLOB,
    made_at INTEGER NOT NULL,
    read_at INTEGER, -- absent: it is new
    mailed_at INTEGER, -- when a letter that names it was queued
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, by_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    FOREIGN KEY (school_id, session_id, comment_id) REFERENCES comments (school_id, session_id, id)
) STRICT;

INSERT INTO notices_again (id, school_id, person_id, kind, by_id, session_id, comment_id, assignment_id, round_id, made_at, read_at, mailed_at)
SELECT id, school_id, person_id, kind, by_id, session_id, comment_id, assignment_id, round_id, made_at, read_at, mailed_at FROM notices;
DROP TABLE notices;
ALTER TABLE notices_again RENAME TO notices;

CREATE INDEX notices_by_person ON notices (school_id, person_id, made_at);
CREATE INDEX notices_unread ON notices (school_id, person_id, made_at) WHERE read_at IS NULL;
CREATE INDEX notices_unmailed ON notices (made_at) WHERE read_at IS NULL AND mailed_at IS NULL;
CREATE INDEX notices_by_comment ON notices (comment_id) WHERE comment_id IS NOT NULL;
CREATE INDEX notices_by_assignment ON notices (assignment_id) WHERE assignment_id IS NOT NULL;
CREATE INDEX notices_by_round ON notices (round_id) WHERE round_id IS NOT NULL;
CREATE INDEX notices_by_author ON notices (school_id, by_id);
CREATE INDEX notices_by_session ON notices (school_id, session_id) WHERE session_id IS NOT NULL;
