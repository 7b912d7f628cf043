-- What others did that concerns somebody, until they have read it: a comment, an answer, another score, a rating round's result, an assignment.
CREATE TABLE notices (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    person_id BLOB NOT NULL, -- whom it is for
    kind TEXT NOT NULL CHECK (kind IN ('comment', 'question', 'answer', 'override', 'rating', 'assignment')),
    by_id BLOB NOT NULL, -- who did it
    session_id BLOB, -- the attempt that it is about; absent for an assignment and for whoever asked for a round
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

CREATE INDEX notices_by_person ON notices (school_id, person_id, made_at);
CREATE INDEX notices_unread ON notices (school_id, person_id, made_at) WHERE read_at IS NULL;
CREATE INDEX notices_unmailed ON notices (made_at) WHERE read_at IS NULL AND mailed_at IS NULL;
CREATE INDEX notices_by_comment ON notices (comment_id) WHERE comment_id IS NOT NULL;
CREATE INDEX notices_by_assignment ON notices (assignment_id) WHERE assignment_id IS NOT NULL;
CREATE INDEX notices_by_round ON notices (round_id) WHERE round_id IS NOT NULL;
CREATE INDEX notices_by_author ON notices (school_id, by_id);
CREATE INDEX notices_by_session ON notices (school_id, session_id) WHERE session_id IS NOT NULL;

-- Whether somebody is mailed what is new for them, at most once a day.
ALTER TABLE people ADD COLUMN mail_news INTEGER NOT NULL DEFAULT 1 CHECK (mail_news IN (0, 1));

-- A mail may tell what is new: the same table with one more kind.
CREATE TABLE mails_again (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    kind TEXT NOT NULL CHECK (kind IN ('invitation', 'reset', 'reminder', 'second_factor_off', 'news')),
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
