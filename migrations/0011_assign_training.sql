-- What is to be trained, by whom and until when. A due date is kept as it was said, in the school's time zone, beside
-- the moment that it means: an extension counts calendar days from what was said.
CREATE TABLE assignments (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    exercise_id TEXT, -- an exercise, or
    curriculum_id TEXT, -- a course
    cohort_id BLOB, -- of a cohort, or
    person_id BLOB, -- of one trainee
    supervised INTEGER NOT NULL CHECK (supervised IN (0, 1)),
    attempt_limit INTEGER CHECK (attempt_limit > 0), -- of an exercise
    due_local TEXT, -- 2026-11-30T18:00:00
    time_zone TEXT NOT NULL,
    due_at INTEGER,
    made_by BLOB NOT NULL,
    made_at INTEGER NOT NULL,
    withdrawn_at INTEGER,
    UNIQUE (school_id, id),
    FOREIGN KEY (school_id, exercise_id) REFERENCES exercises (school_id, exercise_id),
    FOREIGN KEY (school_id, curriculum_id) REFERENCES curricula (school_id, curriculum_id),
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id),
    CHECK ((exercise_id IS NULL) <> (curriculum_id IS NULL)),
    CHECK ((cohort_id IS NULL) <> (person_id IS NULL)),
    CHECK ((due_local IS NULL) = (due_at IS NULL))
) STRICT;

CREATE INDEX assignments_by_cohort ON assignments (cohort_id, due_at) WHERE cohort_id IS NOT NULL;
CREATE INDEX assignments_by_person ON assignments (person_id, due_at) WHERE person_id IS NOT NULL;
CREATE INDEX assignments_by_due ON assignments (due_at) WHERE due_at IS NOT NULL AND withdrawn_at IS NULL;
CREATE INDEX assignments_by_school ON assignments (school_id, made_at);

CREATE TABLE assignment_extensions (
    school_id BLOB NOT NULL,
    assignment_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    days INTEGER NOT NULL CHECK (days BETWEEN 1 AND 366),
    due_at INTEGER NOT NULL,
    PRIMARY KEY (assignment_id, person_id),
    FOREIGN KEY (school_id, assignment_id) REFERENCES assignments (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
) STRICT;
