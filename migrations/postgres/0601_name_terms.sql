-- Terms of a school, and the term that a cohort belongs to.
CREATE TABLE terms (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL REFERENCES schools (id),
    name TEXT COLLATE "C" NOT NULL,
    starts_on TEXT COLLATE "C" NOT NULL, -- the day in the school's time zone, as 2026-10-12
    starts_at BIGINT NOT NULL, -- when that day begins
    UNIQUE (school_id, id),
    UNIQUE (school_id, name)
);

CREATE TABLE cohort_terms (
    cohort_id UUID PRIMARY KEY NOT NULL,
    school_id UUID NOT NULL,
    term_id UUID NOT NULL,
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id),
    FOREIGN KEY (school_id, term_id) REFERENCES terms (school_id, id)
);

CREATE INDEX cohort_terms_by_cohort ON cohort_terms (school_id, cohort_id);
CREATE INDEX cohort_terms_by_term ON cohort_terms (school_id, term_id);
