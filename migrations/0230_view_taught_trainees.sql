-- Whom somebody teaches: the trainees of the cohorts that they are an instructor of. What a viewer may see of trainees begins here.
CREATE VIEW taught_trainees AS
SELECT teacher.school_id, teacher.person_id AS teacher_id, teacher.cohort_id, learner.person_id AS trainee_id
FROM cohort_members teacher
JOIN cohort_members learner ON learner.cohort_id = teacher.cohort_id AND learner.role = 'trainee'
WHERE teacher.role = 'instructor';
