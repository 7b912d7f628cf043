-- Outcomes that a school defines, such as entrustable professional activities (EPAs), the courses that lead to them, the
-- names of the levels of entrustment, and the levels entrusted to trainees. A decision never changes: a later one follows
-- it. A level of NULL ends the entrustment.
CREATE TABLE outcomes (
    id UUID PRIMARY KEY NOT NULL,
    school_id UUID NOT NULL REFERENCES schools (id),
    code TEXT COLLATE "C" NOT NULL CHECK (length(code) BETWEEN 1 AND 40),
    title TEXT COLLATE "C" NOT NULL CHECK (length(title) BETWEEN 1 AND 300),
    description TEXT COLLATE "C" NOT NULL DEFAULT '',
    source TEXT COLLATE "C" NOT NULL DEFAULT '', -- its identifier in a catalogue; empty if it was entered by hand
    retired_at BIGINT,
    made_at BIGINT NOT NULL,
    UNIQUE (school_id, id),
    UNIQUE (school_id, code)
);

CREATE TABLE outcome_courses (
    school_id UUID NOT NULL,
    outcome_id UUID NOT NULL,
    curriculum_id TEXT COLLATE "C" NOT NULL,
    PRIMARY KEY (outcome_id, curriculum_id),
    FOREIGN KEY (school_id, outcome_id) REFERENCES outcomes (school_id, id)
);

CREATE INDEX outcome_courses_by_school ON outcome_courses (school_id, outcome_id);

CREATE TABLE outcome_levels (
    school_id UUID NOT NULL REFERENCES schools (id),
    level BIGINT NOT NULL CHECK (level BETWEEN 1 AND 10),
    name TEXT COLLATE "C" NOT NULL CHECK (length(name) BETWEEN 1 AND 120),
    PRIMARY KEY (school_id, level)
);

CREATE TABLE entrustments (
    id UUID PRIMARY KEY NOT NULL,
    school_id UUID NOT NULL,
    outcome_id UUID NOT NULL,
    person_id UUID NOT NULL,
    level BIGINT CHECK (level BETWEEN 1 AND 10),
    note TEXT COLLATE "C" NOT NULL CHECK (length(note) <= 2000), -- emptied when the person is erased
    decided_by UUID NOT NULL,
    decided_at BIGINT NOT NULL,
    FOREIGN KEY (school_id, outcome_id) REFERENCES outcomes (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, decided_by) REFERENCES people (school_id, id)
);

CREATE INDEX entrustments_by_person ON entrustments (school_id, person_id, decided_at);
CREATE INDEX entrustments_by_decider ON entrustments (school_id, decided_by);
CREATE INDEX entrustments_by_outcome ON entrustments (school_id, outcome_id);

CREATE TRIGGER entrustments_never_change
BEFORE UPDATE OF id, school_id, outcome_id, person_id, level, decided_by, decided_at ON entrustments
FOR EACH ROW EXECUTE FUNCTION refuse('an entrustment never changes: a later one follows it');
CREATE TRIGGER entrustments_never_go BEFORE DELETE ON entrustments
FOR EACH ROW EXECUTE FUNCTION refuse('an entrustment is never deleted');
CREATE TRIGGER entrustments_never_go_all_at_once BEFORE TRUNCATE ON entrustments
EXECUTE FUNCTION refuse('an entrustment is never deleted');
