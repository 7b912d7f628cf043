-- A rater who may see the attempt otherwise is not blind: they teach the trainee, are an administrator, or have asked.
ALTER TABLE ratings ADD COLUMN may_know INTEGER NOT NULL DEFAULT 0 CHECK (may_know IN (0, 1));

-- What was given does not change by it, also where it is finished.
DROP TRIGGER finished_ratings_never_change;

UPDATE ratings SET may_know = 1
WHERE EXISTS (SELECT 1 FROM people p WHERE p.id = ratings.rater_id AND p.role = 'administrator')
   OR EXISTS (SELECT 1 FROM rating_rounds o WHERE o.id = ratings.round_id AND o.made_by = ratings.rater_id)
   OR EXISTS (
    SELECT 1 FROM sessions s
    JOIN cohort_members learner ON learner.person_id = s.trainee_id AND learner.role = 'trainee'
    JOIN cohort_members teacher ON teacher.cohort_id = learner.cohort_id AND teacher.role = 'instructor'
    WHERE s.school_id = ratings.school_id AND s.id = ratings.session_id AND teacher.person_id = ratings.rater_id);

CREATE TRIGGER finished_ratings_never_change BEFORE UPDATE ON ratings WHEN OLD.finished_at IS NOT NULL
BEGIN SELECT RAISE(ABORT, 'a finished rating never changes'); END;
