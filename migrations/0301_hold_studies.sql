-- Validation studies: whom, at what, how often, asked what, and what they have agreed to.
CREATE TABLE studies (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    title TEXT NOT NULL CHECK (length(trim(title)) > 0),
    owner_id BLOB NOT NULL,
    attempts INTEGER NOT NULL CHECK (attempts BETWEEN 1 AND 50), -- asked of each participant at each exercise
    groups TEXT NOT NULL, -- JSON: names, from the least experienced to the experts
    questions TEXT NOT NULL, -- JSON: what is asked of each participant
    consent TEXT NOT NULL CHECK (length(trim(consent)) > 0), -- what they agree to
    controller TEXT NOT NULL CHECK (length(trim(controller)) > 0), -- who answers for the data
    contact TEXT NOT NULL CHECK (length(trim(contact)) > 0),
    kept_months INTEGER NOT NULL CHECK (kept_months BETWEEN 1 AND 360), -- after its end
    generated INTEGER NOT NULL DEFAULT 0 CHECK (generated IN (0, 1)), -- the participants are a program's
    created_at INTEGER NOT NULL,
    closed_at INTEGER,
    UNIQUE (school_id, id),
    FOREIGN KEY (school_id, owner_id) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX studies_by_time ON studies (school_id, created_at);
CREATE INDEX studies_by_owner ON studies (school_id, owner_id);

CREATE TABLE study_exercises (
    school_id BLOB NOT NULL,
    study_id BLOB NOT NULL,
    position INTEGER NOT NULL,
    revision_id BLOB NOT NULL,
    PRIMARY KEY (study_id, position),
    UNIQUE (study_id, revision_id),
    FOREIGN KEY (school_id, study_id) REFERENCES studies (school_id, id),
    FOREIGN KEY (school_id, revision_id) REFERENCES exercise_revisions (school_id, id)
) STRICT;

-- Whoever takes part: guests, who are nobody outside the study, and people of the school.
CREATE TABLE study_participants (
    school_id BLOB NOT NULL,
    study_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    group_place INTEGER NOT NULL, -- in the study's groups
    facts TEXT NOT NULL, -- JSON: answers to the study's questions, in their order
    added_at INTEGER NOT NULL,
    added_by BLOB NOT NULL,
    consented_at INTEGER NOT NULL,
    withdrawn_at INTEGER,
    PRIMARY KEY (study_id, person_id),
    FOREIGN KEY (school_id, study_id) REFERENCES studies (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, added_by) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX study_participants_by_person ON study_participants (school_id, person_id);
CREATE INDEX study_participants_by_adder ON study_participants (school_id, added_by);

-- A survey of a study is asked of its participants alone, after each attempt or after the last.
ALTER TABLE surveys ADD COLUMN study_id BLOB REFERENCES studies (id);
ALTER TABLE surveys ADD COLUMN at_end INTEGER NOT NULL DEFAULT 0 CHECK (at_end IN (0, 1));
CREATE INDEX surveys_of_study ON surveys (school_id, study_id) WHERE study_id IS NOT NULL;
