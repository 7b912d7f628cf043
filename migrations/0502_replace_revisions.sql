-- Since when a revision of an exercise is not what the school gives any more: an attempt at it that began after that, and after the grace
-- that the school grants, counts nowhere.
CREATE TABLE replaced_revisions (
    revision_id BLOB PRIMARY KEY NOT NULL REFERENCES exercise_revisions (id),
    replaced_at INTEGER NOT NULL
) STRICT;

-- Those of before, by the next one of the same exercise.
INSERT INTO replaced_revisions (revision_id, replaced_at)
SELECT r.id, coalesce(
    (SELECT min(n.published_at) FROM exercise_revisions n
     WHERE n.school_id = r.school_id AND n.exercise_id = r.exercise_id AND n.published_at > r.published_at), r.published_at)
FROM exercise_revisions r JOIN exercises e ON e.school_id = r.school_id AND e.exercise_id = r.exercise_id
WHERE e.revision_id <> r.id;

ALTER TABLE schools ADD COLUMN replaced_grace_days INTEGER NOT NULL DEFAULT 7 CHECK (replaced_grace_days BETWEEN 0 AND 365);
