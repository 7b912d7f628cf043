-- What pages of a large school ask for, each in an index alone: people by role, recordings that wait, and the queue of
-- attempts to review, by trainee.
CREATE INDEX people_by_role ON people (school_id, role) WHERE disabled_at IS NULL;
CREATE INDEX sessions_pending ON sessions (school_id) WHERE state = 'pending';
DROP INDEX sessions_to_review_by_trainee;
CREATE INDEX sessions_to_review_by_trainee ON sessions (school_id, trainee_id, verify_flagged DESC, started_at, id)
WHERE state = 'scored' AND reviewed = 0;
