-- The cohort of which a course of a learning platform lists the members.
CREATE TABLE platform_context_cohorts (
    context_id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    cohort_id UUID NOT NULL,
    tied_at BIGINT NOT NULL,
    FOREIGN KEY (school_id, context_id) REFERENCES platform_contexts (school_id, id),
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id)
);

CREATE INDEX platform_context_cohorts_by_context ON platform_context_cohorts (school_id, context_id);
CREATE INDEX platform_context_cohorts_by_cohort ON platform_context_cohorts (school_id, cohort_id);
