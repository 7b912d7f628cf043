-- What the rules for people at risk read: a short row for each trainee and exercise, kept with `practice`.
CREATE TABLE practice_signs (
    school_id UUID NOT NULL,
    trainee_id UUID NOT NULL,
    exercise_id TEXT COLLATE "C" NOT NULL,
    last_at BIGINT NOT NULL, -- start of the latest attempt
    last_score DOUBLE PRECISION NOT NULL,
    passes BIGINT NOT NULL,
    fails BIGINT NOT NULL, -- since the latest pass
    last_mean DOUBLE PRECISION, -- of the latest three scores; absent: fewer than six attempts
    falls DOUBLE PRECISION, -- by how much it is below that of the three before
    PRIMARY KEY (school_id, trainee_id, exercise_id),
    FOREIGN KEY (school_id, trainee_id) REFERENCES people (school_id, id)
);

CREATE INDEX practice_signs_failing ON practice_signs (school_id, last_at) WHERE fails >= 2;
CREATE INDEX practice_signs_falling ON practice_signs (school_id, last_at) WHERE falls >= 1;

INSERT INTO practice_signs (school_id, trainee_id, exercise_id, last_at, last_score, passes, fails, last_mean, falls)
SELECT p.school_id, p.trainee_id, p.exercise_id, s.last_at, s.last_score, p.passes, s.fails, s.last_mean, s.earlier_mean - s.last_mean
FROM practice p CROSS JOIN LATERAL (
    SELECT max((a.value ->> 1)::BIGINT) FILTER (WHERE a.place = p.attempts) AS last_at,
        max((a.value ->> 2)::DOUBLE PRECISION) FILTER (WHERE a.place = p.attempts) AS last_score,
        p.attempts - coalesce(max(a.place) FILTER (WHERE (a.value ->> 3)::BOOLEAN), 0) AS fails,
        avg((a.value ->> 2)::DOUBLE PRECISION) FILTER (WHERE p.attempts >= 6 AND a.place > p.attempts - 3) AS last_mean,
        avg((a.value ->> 2)::DOUBLE PRECISION) FILTER (WHERE a.place > p.attempts - 6 AND a.place <= p.attempts - 3) AS earlier_mean
    FROM jsonb_array_elements(p.history::JSONB) WITH ORDINALITY a (value, place)) s
WHERE p.attempts > 0;

-- When somebody practised last; absent: never.
ALTER TABLE people ADD COLUMN practised_at BIGINT;
CREATE INDEX people_by_practice ON people (school_id, practised_at) WHERE practised_at IS NOT NULL;

UPDATE people SET practised_at = (SELECT max(s.last_at) FROM practice_signs s
    WHERE s.school_id = people.school_id AND s.trainee_id = people.id);

-- The school's own rules; a rule without a row is as it is by itself.
CREATE TABLE risk_rules (
    school_id UUID NOT NULL REFERENCES schools (id),
    rule TEXT COLLATE "C" NOT NULL CHECK (rule IN ('not_begun', 'failing', 'falling', 'inactive')),
    applies BOOLEAN NOT NULL,
    number BIGINT NOT NULL CHECK (number >= 0), -- days, failures, points, weeks
    weight BIGINT NOT NULL CHECK (weight >= 1 AND weight <= 9),
    PRIMARY KEY (school_id, rule)
);

-- What was done for somebody: a message, a conversation, a note. Erased with the person.
CREATE TABLE support_notes (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    person_id UUID NOT NULL, -- for whom
    by_id UUID NOT NULL, -- who did it
    kind TEXT COLLATE "C" NOT NULL CHECK (kind IN ('message', 'spoken', 'note')),
    subject TEXT COLLATE "C", -- of a message
    body TEXT COLLATE "C" NOT NULL,
    mailed BOOLEAN NOT NULL, -- a message that was queued as a mail
    made_at BIGINT NOT NULL,
    UNIQUE (school_id, id),
    CHECK ((kind = 'message') = (subject IS NOT NULL)),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, by_id) REFERENCES people (school_id, id)
);

CREATE INDEX support_notes_by_person ON support_notes (school_id, person_id, made_at);
CREATE INDEX support_notes_by_author ON support_notes (school_id, by_id);

-- A mail and a notice may be a message.
ALTER TABLE mails DROP CONSTRAINT mails_kind_check;
ALTER TABLE mails ADD CONSTRAINT mails_kind_check CHECK (kind IN ('invitation', 'reset', 'reminder', 'second_factor_off', 'news', 'identity_joined', 'message'));
ALTER TABLE mails ADD COLUMN note_id UUID;
ALTER TABLE notices DROP CONSTRAINT notices_kind_check;
ALTER TABLE notices ADD CONSTRAINT notices_kind_check CHECK (kind IN ('comment', 'question', 'answer', 'override', 'rating', 'assignment', 'delivery', 'message'));
ALTER TABLE notices ADD COLUMN note_id UUID;
