-- The cohort of which a course of a learning platform lists the members.
CREATE TABLE platform_context_cohorts (
    context_id BLOB PRIMARY KEY NOT NULL CHECK (length(context_id) = 16),
    school_id BLOB NOT NULL,
    cohort_id BLOB NOT NULL,
    tied_at INTEGER NOT NULL,
    FOREIGN KEY (school_id, context_id) REFERENCES platform_contexts (school_id, id),
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id)
) STRICT;

CREATE INDEX platform_context_cohorts_by_context ON platform_context_cohorts (school_id, context_id);
CREATE INDEX platform_context_cohorts_by_cohort ON platform_context_cohorts (school_id, cohort_id);
