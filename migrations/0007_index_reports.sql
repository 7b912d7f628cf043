-- What the pages ask for: a trainee's latest attempts, a school's latest, those at an exercise, and the newest
-- grading of each without reading the table.
CREATE INDEX sessions_by_trainee_and_time ON sessions (school_id, trainee_id, started_at);
CREATE INDEX sessions_by_time ON sessions (school_id, started_at);
CREATE INDEX sessions_by_exercise ON sessions (school_id, exercise_id, started_at);
CREATE INDEX sessions_flagged ON sessions (school_id) WHERE verify_flagged = 1;
CREATE INDEX sessions_refused ON sessions (school_id) WHERE state = 'refused';
DROP INDEX scores_by_session;
CREATE INDEX scores_by_session ON scores (school_id, session_id, computed_at, id);
