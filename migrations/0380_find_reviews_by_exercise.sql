-- The attempts at one exercise that wait to be looked at, for an administrator.
CREATE INDEX sessions_to_review_at ON sessions (school_id, exercise_id, review_rank, started_at, id)
WHERE state = 'scored' AND reviewed = 0;
