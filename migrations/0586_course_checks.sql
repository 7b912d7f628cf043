-- When the members of a course were last compared with its cohort, and the number of differences; NULL if they could not be read.
ALTER TABLE platform_context_cohorts ADD COLUMN checked_at INTEGER;
ALTER TABLE platform_context_cohorts ADD COLUMN differences INTEGER;
