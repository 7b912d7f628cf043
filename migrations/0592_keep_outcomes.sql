-- Outcomes that a school defines, such as entrustable professional activities (EPAs), the courses that lead to them, the
-- names of the levels of entrustment, and the levels entrusted to trainees. A decision never changes: a later one follows
-- it. A level of NULL ends the entrustment.
CREATE TABLE outcomes (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    code TEXT NOT NULL CHECK (length(code) BETWEEN 1 AND 40),
    title TEXT NOT NULL CHECK (length(title) BETWEEN 1 AND 300),
    description TEXT NOT NULL DEFAULT '',
    source TEXT NOT NULL DEFAULT '', -- its identifier in a catalogue; empty if it was entered by hand
    retired_at INTEGER,
    made_at INTEGER NOT NULL,
    UNIQUE (school_id, id),
    UNIQUE (school_id, code)
) STRICT;

CREATE TABLE outcome_courses (
    school_id BLOB NOT NULL,
    outcome_id BLOB NOT NULL,
    curriculum_id TEXT NOT NULL,
    PRIMARY KEY (outcome_id, curriculum_id),
    FOREIGN KEY (school_id, outcome_id) REFERENCES outcomes (school_id, id)
) STRICT;

CREATE INDEX outcome_courses_by_school ON outcome_courses (school_id, outcome_id);

CREATE TABLE outcome_levels (
    school_id BLOB NOT NULL REFERENCES schools (id),
    level INTEGER NOT NULL CHECK (level BETWEEN 1 AND 10),
    name TEXT NOT NULL CHECK (length(name) BETWEEN 1 AND 120),
    PRIMARY KEY (school_id, level)
) STRICT;

CREATE TABLE entrustments (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    outcome_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    level INTEGER CHECK (level BETWEEN 1 AND 10),
    note TEXT NOT NULL CHECK (length(note) <= 2000), -- emptied when the person is erased
    decided_by BLOB NOT NULL,
    decided_at INTEGER NOT NULL,
    FOREIGN KEY (school_id, outcome_id) REFERENCES outcomes (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, decided_by) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX entrustments_by_person ON entrustments (school_id, person_id, decided_at);
CREATE INDEX entrustments_by_decider ON entrustments (school_id, decided_by);
CREATE INDEX entrustments_by_outcome ON entrustments (school_id, outcome_id);

CREATE TRIGGER entrustments_never_change
BEFORE UPDATE OF id, school_id, outcome_id, person_id, level, decided_by, decided_at ON entrustments
BEGIN SELECT RAISE(ABORT, 'an entrustment never changes: a later one follows it'); END;
CREATE TRIGGER entrustments_never_go BEFORE DELETE ON entrustments
BEGIN SELECT RAISE(ABORT, 'an entrustment is never deleted'); END;
