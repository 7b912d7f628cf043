-- Instruments as they were published. A revision never changes; `instruments` points at the current one.
CREATE TABLE instrument_revisions (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    instrument_id TEXT NOT NULL,
    title TEXT NOT NULL,
    sha256 TEXT NOT NULL,
    bytes BLOB NOT NULL,
    published_at INTEGER NOT NULL,
    UNIQUE (school_id, id),
    UNIQUE (school_id, sha256)
) STRICT;

CREATE INDEX instrument_revisions_by_instrument ON instrument_revisions (school_id, instrument_id, published_at);

CREATE TABLE instruments (
    school_id BLOB NOT NULL REFERENCES schools (id),
    instrument_id TEXT NOT NULL,
    revision_id BLOB NOT NULL,
    PRIMARY KEY (school_id, instrument_id),
    FOREIGN KEY (school_id, revision_id) REFERENCES instrument_revisions (school_id, id)
) STRICT;

CREATE TRIGGER instrument_revisions_never_change BEFORE UPDATE ON instrument_revisions
BEGIN SELECT RAISE(ABORT, 'a published instrument revision never changes'); END;
CREATE TRIGGER instrument_revisions_never_go BEFORE DELETE ON instrument_revisions
BEGIN SELECT RAISE(ABORT, 'a published instrument revision is never deleted'); END;

-- A survey asks one revision of an instrument, so that all its answers can be compared.
CREATE TABLE surveys (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    revision_id BLOB NOT NULL,
    title TEXT NOT NULL,
    owner_id BLOB, -- absent: a course asks for it, and the administrators own it
    identity TEXT NOT NULL CHECK (identity IN ('anonymous', 'pseudonymous', 'named')),
    after_attempts INTEGER NOT NULL CHECK (after_attempts IN (0, 1)), -- asked after each attempt, not once
    generated INTEGER NOT NULL CHECK (generated IN (0, 1)), -- the answers were made by a program
    opens_at INTEGER NOT NULL,
    closes_at INTEGER,
    created_at INTEGER NOT NULL,
    UNIQUE (school_id, id),
    FOREIGN KEY (school_id, revision_id) REFERENCES instrument_revisions (school_id, id),
    FOREIGN KEY (school_id, owner_id) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX surveys_by_time ON surveys (school_id, created_at);
CREATE INDEX surveys_after_attempts ON surveys (school_id, created_at) WHERE after_attempts = 1;

-- Whom a survey is for. None of a survey after attempts: every trainee.
CREATE TABLE survey_cohorts (
    school_id BLOB NOT NULL,
    survey_id BLOB NOT NULL,
    cohort_id BLOB NOT NULL,
    PRIMARY KEY (survey_id, cohort_id),
    FOREIGN KEY (school_id, survey_id) REFERENCES surveys (school_id, id),
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id)
) STRICT;

CREATE INDEX survey_cohorts_by_cohort ON survey_cohorts (cohort_id, survey_id);

-- After which exercises a survey is asked. None: after all.
CREATE TABLE survey_exercises (
    school_id BLOB NOT NULL,
    survey_id BLOB NOT NULL,
    exercise_id TEXT NOT NULL,
    PRIMARY KEY (survey_id, exercise_id),
    FOREIGN KEY (school_id, survey_id) REFERENCES surveys (school_id, id)
) STRICT;

-- One row for each link and each person who began. Its id is random and an anonymous row keeps neither person, attempt
-- nor the hour, so that nothing in this file leads from an anonymous answer to who gave it.
CREATE TABLE survey_responses (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    survey_id BLOB NOT NULL,
    token_sha256 BLOB NOT NULL UNIQUE CHECK (length(token_sha256) = 32),
    state TEXT NOT NULL CHECK (state IN ('invited', 'begun', 'submitted', 'withdrawn')),
    role TEXT NOT NULL, -- 'professional' for a link, or the person's
    label TEXT, -- whom a link was made for
    person_id BLOB,
    session_id BLOB,
    exercise_id TEXT, -- of the attempt, as the next two
    device TEXT,
    simulator_version TEXT,
    language TEXT NOT NULL,
    answers TEXT NOT NULL, -- JSON: an array in the order of the instrument's items
    consented_at INTEGER,
    expires_at INTEGER, -- of a link
    submitted_at INTEGER,
    UNIQUE (school_id, id),
    CHECK ((state = 'submitted') = (submitted_at IS NOT NULL)),
    CHECK (state IN ('invited', 'withdrawn') OR consented_at IS NOT NULL),
    FOREIGN KEY (school_id, survey_id) REFERENCES surveys (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id)
) STRICT;

CREATE INDEX survey_responses_by_survey ON survey_responses (school_id, survey_id, state);
CREATE UNIQUE INDEX survey_responses_of_person ON survey_responses (survey_id, person_id, coalesce(session_id, x''))
WHERE person_id IS NOT NULL;

-- Who has answered, and after which attempt: never what. Kept apart, so that "once" can be held for anonymous answers.
CREATE TABLE survey_participations (
    school_id BLOB NOT NULL,
    survey_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    session_id BLOB,
    FOREIGN KEY (school_id, survey_id) REFERENCES surveys (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id)
) STRICT;

CREATE UNIQUE INDEX survey_participations_once
ON survey_participations (survey_id, person_id, coalesce(session_id, x''));

-- Themes that a reader has found in a comment.
CREATE TABLE survey_tags (
    school_id BLOB NOT NULL,
    survey_id BLOB NOT NULL,
    response_id BLOB NOT NULL,
    item_id TEXT NOT NULL,
    tag TEXT NOT NULL,
    PRIMARY KEY (response_id, item_id, tag),
    FOREIGN KEY (school_id, survey_id) REFERENCES surveys (school_id, id),
    FOREIGN KEY (school_id, response_id) REFERENCES survey_responses (school_id, id)
) STRICT;

CREATE INDEX survey_tags_by_survey ON survey_tags (school_id, survey_id);
