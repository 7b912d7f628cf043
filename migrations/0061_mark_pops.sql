-- Trainees mark the moment of each pop on traces of force that say nothing else, and are measured against the recording.
CREATE TABLE segment_tasks (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    title TEXT NOT NULL CHECK (length(trim(title)) > 0),
    cohort_id BLOB NOT NULL,
    due_local TEXT, -- 2026-11-30T18:00:00
    time_zone TEXT NOT NULL,
    due_at INTEGER,
    made_by BLOB NOT NULL,
    made_at INTEGER NOT NULL,
    withdrawn_at INTEGER,
    UNIQUE (school_id, id),
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id),
    CHECK ((due_local IS NULL) = (due_at IS NULL))
) STRICT;

CREATE INDEX segment_tasks_by_school ON segment_tasks (school_id, made_at);
CREATE INDEX segment_tasks_by_cohort ON segment_tasks (cohort_id, made_at);

-- The attempts of a task. The id is random: a trainee knows an attempt by it alone.
CREATE TABLE segment_traces (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    task_id BLOB NOT NULL,
    session_id BLOB NOT NULL,
    position INTEGER NOT NULL, -- from 1
    UNIQUE (school_id, id),
    UNIQUE (task_id, session_id),
    FOREIGN KEY (school_id, task_id) REFERENCES segment_tasks (school_id, id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id)
) STRICT;

CREATE TABLE segment_marks (
    school_id BLOB NOT NULL,
    trace_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    marks TEXT NOT NULL, -- JSON: moments since the start of the attempt, in s
    sent_at INTEGER, -- from then on they stay, for the truth has been shown
    PRIMARY KEY (trace_id, person_id),
    FOREIGN KEY (school_id, trace_id) REFERENCES segment_traces (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX segment_marks_by_person ON segment_marks (school_id, person_id);

CREATE TRIGGER sent_marks_never_change BEFORE UPDATE ON segment_marks WHEN OLD.sent_at IS NOT NULL
BEGIN SELECT RAISE(ABORT, 'sent marks never change'); END;
