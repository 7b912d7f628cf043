-- What the rules for people at risk read: a short row for each trainee and exercise, kept with `practice`.
CREATE TABLE practice_signs (
    school_id BLOB NOT NULL,
    trainee_id BLOB NOT NULL,
    exercise_id TEXT NOT NULL,
    last_at INTEGER NOT NULL, -- start of the latest attempt
    last_score REAL NOT NULL,
    passes INTEGER NOT NULL,
    fails INTEGER NOT NULL, -- since the latest pass
    last_mean REAL, -- of the latest three scores; absent: fewer than six attempts
    falls REAL, -- by how much it is below that of the three before
    PRIMARY KEY (school_id, trainee_id, exercise_id),
    FOREIGN KEY (school_id, trainee_id) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX practice_signs_failing ON practice_signs (school_id, last_at) WHERE fails >= 2;
CREATE INDEX practice_signs_falling ON practice_signs (school_id, last_at) WHERE falls >= 1;

INSERT INTO practice_signs (school_id, trainee_id, exercise_id, last_at, last_score, passes, fails, last_mean, falls)
SELECT school_id, trainee_id, exercise_id, last_at, last_score, passes, fails, last_mean, earlier_mean - last_mean
FROM (SELECT p.school_id, p.trainee_id, p.exercise_id, p.passes,
        json_extract(p.history, '$[#-1][1]') AS last_at, CAST(json_extract(p.history, '$[#-1][2]') AS REAL) AS last_score,
        (SELECT count(*) FROM json_each(p.history) a WHERE a.key > coalesce(
           (SELECT max(b.key) FROM json_each(p.history) b WHERE json_extract(b.value, '$[3]')), -1)) AS fails,
        CASE WHEN p.attempts >= 6 THEN (SELECT avg(json_extract(a.value, '$[2]')) FROM json_each(p.history) a
           WHERE a.key >= p.attempts - 3) END AS last_mean,
        (SELECT avg(json_extract(a.value, '$[2]')) FROM json_each(p.history) a
           WHERE a.key >= p.attempts - 6 AND a.key < p.attempts - 3) AS earlier_mean
      FROM practice p WHERE p.attempts > 0) signs;

-- When somebody practised last; absent: never.
ALTER TABLE people ADD COLUMN practised_at INTEGER;
CREATE INDEX people_by_practice ON people (school_id, practised_at) WHERE practised_at IS NOT NULL;

UPDATE people SET practised_at = (SELECT max(s.last_at) FROM practice_signs s
    WHERE s.school_id = people.school_id AND s.trainee_id = people.id);

-- The school's own rules; a rule without a row is as it is by itself.
CREATE TABLE risk_rules (
    school_id BLOB NOT NULL REFERENCES schools (id),
    rule TEXT NOT NULL CHECK (rule IN ('not_begun', 'failing', 'falling', 'inactive')),
    applies INTEGER NOT NULL CHECK (applies IN (0, 1)),
    number INTEGER NOT NULL CHECK (number >= 0), -- days, failures, points, weeks
    weight INTEGER NOT NULL CHECK (weight >= 1 AND weight <= 9),
    PRIMARY KEY (school_id, rule)
) STRICT;

-- What was done for somebody: a message, a conversation, a note. Erased with the person.
CREATE TABLE support_notes (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    person_id BLOB NOT NULL, -- for whom
    by_id BLOB NOT NULL, -- who did it
    kind TEXT NOT NULL CHECK (kind IN ('message', 'spoken', 'note')),
    subject TEXT, -- of a message
    body TEXT NOT NULL,
    mailed INTEGER NOT NULL CHECK (mailed IN (0, 1)), -- a message that was queued as a mail
    made_at INTEGER NOT NULL,
    UNIQUE (school_id, id),
    CHECK ((kind = 'message') = (subject IS NOT NULL)),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, by_id) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX support_notes_by_person ON support_notes (school_id, person_id, made_at);
CREATE INDEX support_notes_by_author ON support_notes (school_id, by_id);

-- A mail and a notice may be a message: the same tables with one more kind.
CREATE TABLE mails_again (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    kind TEXT NOT NULL CHECK (kind IN ('invitation', 'reset', 'reminder', 'second_factor_off', 'news', 'identity_joined', 'message')),
    assignment_id BLOB, -- of a reminder
    tries INTEGER NOT NULL DEFAULT 0,
    next_run_at INTEGER, -- absent: sent, or given up
    sent_at INTEGER,
    error TEXT,
    note_id BLOB, -- of a message
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    CHECK ((kind = 'reminder') = (assignment_id IS NOT NULL))
) STRICT;

INSERT INTO mails_again (id, school_id, person_id, kind, assignment_id, tries, next_run_at, sent_at, error)
SELECT id, school_id, person_id, kind, assignment_id, tries, next_run_at, sent_at, error FROM mails;
DROP TABLE mails;
ALTER TABLE mails_again RENAME TO mails;

CREATE INDEX mails_by_time ON mails (next_run_at) WHERE next_run_at IS NOT NULL;
CREATE INDEX mails_by_person ON mails (school_id, person_id);
CREATE UNIQUE INDEX reminders_once ON mails (assignment_id, person_id) WHERE assignment_id IS NOT NULL;
CREATE INDEX mails_failed ON mails (school_id, id) WHERE error IS NOT NULL AND sent_at IS NULL;

CREATE TABLE notices_again (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    person_id BLOB NOT NULL, -- recipient
    kind TEXT NOT NULL CHECK (kind IN ('comment', 'question', 'answer', 'override', 'rating', 'assignment', 'delivery', 'message')),
    by_id BLOB NOT NULL, -- who did it, or whose grade it is
    session_id BLOB, -- the attempt; absent for an assignment, a grade and the person who asked for a round
    comment_id BLOB,
    assignment_id BLOB,
    round_id BLOB,
    made_at INTEGER NOT NULL,
    read_at INTEGER, -- absent: it is new
    mailed_at INTEGER, -- when a letter that names it was queued
    note_id BLOB, -- of a message
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
