-- Since when a revision of a course is not the one that the school teaches any more: who had mastered it by then has mastered the course.
CREATE TABLE replaced_curricula (
    revision_id BLOB PRIMARY KEY NOT NULL REFERENCES curriculum_revisions (id),
    replaced_at INTEGER NOT NULL
) STRICT;

-- Those of before, by the next one of the same course.
INSERT INTO replaced_curricula (revision_id, replaced_at)
SELECT r.id, coalesce(
    (SELECT min(n.published_at) FROM curriculum_revisions n
     WHERE n.school_id = r.school_id AND n.curriculum_id = r.curriculum_id AND n.published_at > r.published_at), r.published_at)
FROM curriculum_revisions r JOIN curricula c ON c.school_id = r.school_id AND c.curriculum_id = r.curriculum_id
WHERE c.revision_id <> r.id;
