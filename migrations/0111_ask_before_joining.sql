-- Who belongs to a cohort is decided by administrators, or asked for by its instructors and agreed to by the trainee or by an
-- administrator. Until then nothing of the trainee is seen.
CREATE TABLE cohort_requests (
    school_id BLOB NOT NULL,
    cohort_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    asked_by BLOB NOT NULL,
    asked_at INTEGER NOT NULL,
    PRIMARY KEY (cohort_id, person_id),
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, asked_by) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX cohort_requests_by_person ON cohort_requests (person_id);
CREATE INDEX cohort_requests_by_school ON cohort_requests (school_id, asked_at);

-- What was done about somebody's place in a cohort, for them to see: rows are added and never change.
CREATE TABLE cohort_acts (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    cohort_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    act TEXT NOT NULL CHECK (act IN ('asked', 'declined', 'joined', 'left')),
    done_by BLOB, -- NULL: on the command line
    done_at INTEGER NOT NULL,
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, done_by) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX cohort_acts_by_person ON cohort_acts (school_id, person_id, done_at);
