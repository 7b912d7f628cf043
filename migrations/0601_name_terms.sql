-- Terms of a school, and the term that a cohort belongs to.
CREATE TABLE terms (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    name TEXT NOT NULL,
    starts_on TEXT NOT NULL, -- the day in the school's time zone, as 2026-10-12
    starts_at INTEGER NOT NULL, -- when that day begins
    UNIQUE (school_id, id),
    UNIQUE (school_id, name)
) STRICT;

CREATE TABLE cohort_terms (
    cohort_id BLOB PRIMARY KEY NOT NULL,
    school_id BLOB NOT NULL,
    term_id BLOB NOT NULL,
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id),
    FOREIGN KEY (school_id, term_id) REFERENCES terms (school_id, id)
) STRICT;

CREATE INDEX cohort_terms_by_cohort ON cohort_terms (school_id, cohort_id);
CREATE INDEX cohort_terms_by_term ON cohort_terms (school_id, term_id);
